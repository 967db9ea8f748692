#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh_topology.hpp>
#include <tapestry/geometry/position_array.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/loss/mesh_regularity_variable.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// The shape of a car as a parameter p, a row for each of its V positions: position v moves by
///
///   reach · longest extent of the car · tanh p[w(v)],
///
/// with w(v) the first position at the same place, so that seams stay closed. p = 0 is the car as it is.
struct ShapeParameter {
  raster::PaintedMesh car;                         ///< as it is
  std::shared_ptr<const raster::MeshEdges> edges;  ///< of it
  geometry::MeshTopology topology;                 ///< of it, positions at one place being one
  double reach = 0.01;                             ///< greatest offset along an axis, in longest extents
  double stiffness = 1;                            ///< weight of shape_roughness()

  [[nodiscard]] std::size_t row_count() const { return car.mesh.positions.size(); }
};

/// The longest edge of a mesh's bounding box, in its units; 0 without finite positions.
[[nodiscard]] inline double longest_extent(const geometry::Mesh& mesh) {
  double longest = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = 0, high = 0;
    bool any = false;
    for (const auto& position : mesh.positions) {
      if (!geometry::is_finite(position)) continue;
      low = any ? std::min(low, position[axis]) : position[axis];
      high = any ? std::max(high, position[axis]) : position[axis];
      any = true;
    }
    longest = std::max(longest, high - low);
  }
  return longest;
}

/// \throws DomainError for a filtered atlas, through which no picture can be differentiated by positions;
///         Error (mismatch) if a face refers to a missing position
[[nodiscard]] inline ShapeParameter shape_parameter(const raster::PaintedMesh& car) {
  if (raster::is_filtered(car.layout))
    throw DomainError("shape_parameter: expected a bilinear atlas, found a filtered one");
  (void)geometry::mesh_topology(car.mesh);  // refuses what edges take for granted
  auto edges = std::make_shared<const raster::MeshEdges>(raster::mesh_edges(car.mesh));
  geometry::Mesh welded;
  welded.positions = car.mesh.positions;
  welded.faces = car.mesh.faces;
  for (auto& face : welded.faces)
    for (std::int32_t& corner : face) corner = edges->welded[static_cast<std::size_t>(corner)];
  return {car, edges, geometry::mesh_topology(welded)};
}

/// Where positions go on the tape, in shares of the reach: d = tanh p[w(v)], [V, 3], each in [−1, 1].
///
/// \param parameter  [row, 3], whose last V rows are p
/// \throws ShapeError if there are not as many
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> shape_steps(const ShapeParameter& shape,
                                              const ArrayVariable<T, 2>& parameter) {
  const std::size_t count = shape.row_count();
  if (parameter.shape()[0] < count || parameter.shape()[1] != 3)
    throw ShapeError("shape_steps: parameter is " + tapestry::detail::to_text(parameter.shape()) +
                     ", expected at least " + std::to_string(count) + " rows of 3");
  const std::size_t first = parameter.shape()[0] - count;
  std::vector<std::size_t> places;
  for (const std::int32_t row : shape.edges->welded)
    for (std::size_t c = 0; c < 3; ++c) places.push_back(3 * (first + static_cast<std::size_t>(row)) + c);
  return tanh(reshape(gather(parameter, std::move(places)), Extents<2>{count, 3}));
}

/// How unevenly the shape moves: 1/E · Σ |d_a − d_b|² over edges, 0 where all of it moves alike. It is the
/// quadratic form of the mesh's Laplacian.
/// Source: Xiao et al., "MeshAdv" (CVPR 2019), the Laplacian loss of displacements, there a sum.
/// \param shape  must outlive the tape's last reverse()
/// \param steps  d, see shape_steps()
template <std::floating_point T>
[[nodiscard]] Variable<T> shape_roughness(const ShapeParameter& shape, const ArrayVariable<T, 2>& steps) {
  return loss::edge_length(shape.topology, steps);
}

/// Where positions are on the tape, [V, 3].
/// \param steps  see shape_steps()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> shape_positions(const ShapeParameter& shape,
                                                  const ArrayVariable<T, 2>& steps) {
  const auto farthest = static_cast<T>(shape.reach * longest_extent(shape.car.mesh));
  return ArrayVariable<T, 2>(geometry::position_array<T>(shape.car.mesh)) + farthest * steps;
}

/// The offsets that a parameter comes to, [V, 3], in longest extents of the car, whatever its units.
template <std::floating_point T>
[[nodiscard]] Array<T, 2> shape_offsets(const ShapeParameter& shape, const Array<T, 2>& parameter) {
  Array<T, 2> offsets = shape_steps(shape, ArrayVariable<T, 2>(parameter)).value();
  for (T& offset : offsets.storage()) offset *= static_cast<T>(shape.reach);
  return offsets;
}

/// A car in another shape. Normals stay those of the car.
/// \param offsets  see shape_offsets()
/// \throws ShapeError unless there is one a position
template <std::floating_point T>
[[nodiscard]] raster::PaintedMesh reshaped(raster::PaintedMesh car, const Array<T, 2>& offsets) {
  require_shape("reshaped", "offsets", offsets, {car.mesh.positions.size(), 3});
  const double longest = longest_extent(car.mesh);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    car.mesh.positions[i / 3][i % 3] += longest * static_cast<double>(offsets.data()[i]);
  return car;
}

}  // namespace tapestry::camouflage
