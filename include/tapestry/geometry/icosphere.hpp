#pragma once
#include <cstddef>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {

/// A sphere of nearly equal triangles: an icosahedron whose faces are cut into four, again and again, the new
/// corners moved out to the sphere. 20·4ⁿ faces, seen from outside, and 10·4ⁿ + 2 positions.
///
/// \param subdivisions  n, 0 to 8
/// \throws DomainError for more than 8, or unless radius is positive
[[nodiscard]] Mesh icosphere(std::size_t subdivisions, double radius = 1, const Vector3& centre = {0, 0, 0});

}  // namespace tapestry::geometry
