#pragma once
/// \file
/// The compiled part of geometry/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/geometry/implementation/car_axes.hpp>
#include <tapestry/geometry/implementation/mesh.hpp>
#include <tapestry/geometry/implementation/polygon_triangulator.hpp>
