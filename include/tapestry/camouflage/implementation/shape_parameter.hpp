#pragma once
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/image/over.hpp>

namespace tapestry::camouflage {
namespace detail {
/// The longest edge of a mesh's bounding box, in its units; 0 without finite positions.
[[nodiscard]] inline double longest_extent(const geometry::Mesh& mesh) {
  return 2 * geometry::bounds_of(mesh.positions).half_length();
}
}  // namespace detail

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
  const auto farthest = static_cast<T>(shape.reach * detail::longest_extent(shape.car.mesh));
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
  const double longest = detail::longest_extent(car.mesh);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    car.mesh.positions[i / 3][i % 3] += longest * static_cast<double>(offsets.data()[i]);
  return car;
}

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
}  // namespace tapestry::camouflage
