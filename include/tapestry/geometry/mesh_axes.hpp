#pragma once
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {

/// How a mesh lies in its file: which of its axes, x, y, z, -x, -y or -z, point up and to its front.
struct MeshAxes {
  std::string up = "z";
  std::string forward = "x";
};

/// The unit vector of an axis by its name: x, y, z, -x, -y or -z.
/// \throws DomainError for any other name
[[nodiscard]] Vector3 axis_by_name(const std::string& name);

/// The rotation that takes a mesh with these axes to z up and its front to +x; its rows are forward,
/// up × forward, which is left, and up.
/// \throws DomainError for names of no axis, or unless up and forward are perpendicular
[[nodiscard]] Matrix3 world_from_mesh(const MeshAxes& axes);

/// The mesh turned to z up and its front to +x; the same bits where it lies so already.
/// \throws DomainError as world_from_mesh()
[[nodiscard]] Mesh turned_upright(Mesh mesh, const MeshAxes& axes);

/// Of an upright mesh, whether it is higher than long, as no car is: one that stands on its nose or tail.
[[nodiscard]] bool is_higher_than_long(const Mesh& upright);

}  // namespace tapestry::geometry
