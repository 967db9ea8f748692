#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::geometry {

/// The positions of a mesh as the tape takes them, [V, 3].
template <std::floating_point T>
[[nodiscard]] Array<T, 2> position_array(const Mesh& mesh) {
  Array<T, 2> array(Extents<2>{mesh.positions.size(), 3});
  for (std::size_t i = 0; i < array.size(); ++i)
    array.data()[i] = static_cast<T>(mesh.positions[i / 3][i % 3]);
  return array;
}

/// Gives a mesh the positions of an array, [V, 3].
/// \throws ShapeError, which names `operation`, unless there are as many as the mesh has
template <std::floating_point T>
void set_positions(Mesh& mesh, const Array<T, 2>& positions, const char* operation = "set_positions") {
  require_shape(operation, "positions", positions, {mesh.positions.size(), 3});
  for (std::size_t i = 0; i < positions.size(); ++i)
    mesh.positions[i / 3][i % 3] = static_cast<double>(positions.data()[i]);
}

}  // namespace tapestry::geometry
