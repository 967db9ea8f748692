#pragma once
/// \file
/// All of geometry/ that programs name: meshes and cameras.
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/point_columns.hpp>
#include <tapestry/geometry/polygon_triangulator.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/geometry/transform.hpp>
