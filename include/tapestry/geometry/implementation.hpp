#pragma once
/// \file
/// The compiled part of geometry/, for one source file of a program; see tapestry/implementation.hpp.
#include <tapestry/geometry/implementation/carla_pose.hpp>
#include <tapestry/geometry/implementation/face_selection.hpp>
#include <tapestry/geometry/implementation/icosphere.hpp>
#include <tapestry/geometry/implementation/mesh_axes.hpp>
#include <tapestry/geometry/implementation/mesh_topology.hpp>
#include <tapestry/geometry/implementation/orientation.hpp>
#include <tapestry/geometry/implementation/polygon_triangulator.hpp>
