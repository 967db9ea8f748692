#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/bounds.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/mesh_axes.hpp>
#include <tapestry/geometry/transform.hpp>
#include <utility>

namespace tapestry::geometry {

Vector3 axis_by_name(const std::string& name) {
  const bool is_negative = name.starts_with('-');
  const std::string letter = name.substr(is_negative ? 1 : 0);
  if (letter != "x" && letter != "y" && letter != "z")
    throw DomainError("axis_by_name: found " + in_quotes(name) + ", expected x, y, z, -x, -y or -z");
  Vector3 axis{0, 0, 0};
  axis[static_cast<std::size_t>(letter[0] - 'x')] = is_negative ? -1 : 1;
  return axis;
}

Matrix3 world_from_mesh(const MeshAxes& axes) {
  const Vector3 up = axis_by_name(axes.up), forward = axis_by_name(axes.forward);
  if (dot(up, forward) != 0)
    throw DomainError("world_from_mesh: up is " + axes.up + " and forward " + axes.forward +
                      ", expected two axes at a right angle");
  return {forward, cross(up, forward), up};
}

Mesh turned_upright(Mesh mesh, const MeshAxes& axes) {
  const Matrix3 rotation = world_from_mesh(axes);
  if (rotation == world_from_mesh({})) return mesh;
  for (auto* const vectors : {&mesh.positions, &mesh.normals})
    for (Vector3& vector : *vectors) vector = multiply(rotation, vector);
  return mesh;
}

bool is_higher_than_long(const Mesh& upright) {
  const Bounds bounds = bounds_of(upright.positions);
  const Vector3 extent = subtract(bounds.high, bounds.low);
  return extent[2] > extent[0];
}

}  // namespace tapestry::geometry
