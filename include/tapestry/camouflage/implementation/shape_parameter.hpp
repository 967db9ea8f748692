#pragma once
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/image/over.hpp>

namespace tapestry::camouflage {

double longest_extent(const geometry::Mesh& mesh) {
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

ShapeParameter shape_parameter(const raster::PaintedMesh& car) {
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

template <std::floating_point T>
ArrayVariable<T, 2> shape_steps(const ShapeParameter& shape, const ArrayVariable<T, 2>& parameter) {
  const std::size_t count = shape.row_count();
  if (parameter.shape()[0] < count || parameter.shape()[1] != 3)
    throw ShapeError(
        {"shape_steps: parameter is ", parameter.shape(), ", expected at least ", count, " rows of 3"});
  const std::size_t first = parameter.shape()[0] - count;
  std::vector<std::size_t> places;
  for (const std::int32_t row : shape.edges->welded)
    for (std::size_t c = 0; c < 3; ++c) places.push_back(3 * (first + static_cast<std::size_t>(row)) + c);
  return tanh(reshape(gather(parameter, std::move(places)), Extents<2>{count, 3}));
}

template <std::floating_point T>
ArrayVariable<T, 2> shape_positions(const ShapeParameter& shape, const ArrayVariable<T, 2>& steps) {
  const auto farthest = static_cast<T>(shape.reach * longest_extent(shape.car.mesh));
  return ArrayVariable<T, 2>(geometry::position_array<T>(shape.car.mesh)) + farthest * steps;
}

template <std::floating_point T>
Array<T, 2> shape_offsets(const ShapeParameter& shape, const Array<T, 2>& parameter) {
  Array<T, 2> offsets = shape_steps(shape, ArrayVariable<T, 2>(parameter)).value();
  for (T& offset : offsets.storage()) offset *= static_cast<T>(shape.reach);
  return offsets;
}

template <std::floating_point T>
raster::PaintedMesh reshaped(raster::PaintedMesh car, const Array<T, 2>& offsets) {
  require_shape("reshaped", "offsets", offsets, {car.mesh.positions.size(), 3});
  const double longest = longest_extent(car.mesh);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    car.mesh.positions[i / 3][i % 3] += longest * static_cast<double>(offsets.data()[i]);
  return car;
}

template decltype(shape_steps<float>) shape_steps<float>;
template decltype(shape_steps<double>) shape_steps<double>;
template decltype(shape_positions<float>) shape_positions<float>;
template decltype(shape_positions<double>) shape_positions<double>;
template decltype(shape_offsets<float>) shape_offsets<float>;
template decltype(shape_offsets<double>) shape_offsets<double>;
template decltype(reshaped<float>) reshaped<float>;
template decltype(reshaped<double>) reshaped<double>;

template <std::floating_point T>
RedrawnView<T> redrawn(const View<T>& view, const ShapeParameter& shape, const ArrayVariable<T, 2>& texels,
                       const ArrayVariable<T, 2>& positions) {
  if (!view.sight) throw DomainError({"redrawn: view ", view.name, " does not keep what it is drawn by"});
  const auto& [camera, light, mask, samples] = *view.sight;
  const std::size_t height = mask.shape(0), width = mask.shape(1);
  const auto drawn = raster::render(shape.car, camera, height, width, light,
                                    raster::RenderInputs<T>{.texels = texels, .positions = positions},
                                    raster::BoundaryIntegral{samples, true, shape.edges});
  Array<T, 3> mask_of_channels(Extents<3>{height, width, 3});
  for (std::size_t i = 0; i < mask_of_channels.size(); ++i) mask_of_channels.data()[i] = mask.data()[i / 3];
  const ArrayVariable<T, 3> render = drawn.picture * ArrayVariable<T, 3>(std::move(mask_of_channels));
  const ArrayVariable<T, 2> coverage = drawn.coverage * ArrayVariable<T, 2>(mask);
  return {render, image::over(render, coverage, ArrayVariable<T, 3>(view.background), 0, 0, view.space),
          std::make_shared<const Array<T, 2>>(detail::interior_of(coverage.value()))};
}

template decltype(redrawn<float>) redrawn<float>;
template decltype(redrawn<double>) redrawn<double>;

}  // namespace tapestry::camouflage
