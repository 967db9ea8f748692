#pragma once
#include <tapestry/raster/deferred.hpp>
#include <tapestry/raster/implementation/outline_crossings.hpp>
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::raster {
namespace detail {
template <std::floating_point T>
void require_pixels(const char* operation, const char* what, const PixelFaces& pixels,
                    const Array<T, 3>& array, std::size_t channels) {
  require_shape(operation, what, array, {pixels.height, pixels.width, channels});
}

/// Calls visit(first entry of the pixel in an array of three channels, indices of its corners' attributes).
template <class Visit>
void for_each_attribute(const PixelFaces& pixels, const std::vector<geometry::Corners>& corners,
                        std::size_t attribute_count, Visit visit) {
  if (corners.size() != pixels.mesh->faces.size())
    throw ShapeError(
        {"interpolate: corners of ", corners.size(), " faces, expected ", pixels.mesh->faces.size()});
  for (std::size_t pixel = 0; pixel < pixels.face.size(); ++pixel) {
    if (pixels.face[pixel] < 0) continue;
    std::array<std::size_t, 3> attributes;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t index = corners[static_cast<std::size_t>(pixels.face[pixel])][k];
      attributes[k] = static_cast<std::size_t>(index);
      if (index < 0 || attributes[k] >= attribute_count)
        throw Error(ErrorKind::mismatch, {"interpolate: face ", pixels.face[pixel], " refers to attribute ",
                                          index, " of ", attribute_count});
    }
    visit(pixel, attributes);
  }
}
}  // namespace detail

template <std::floating_point T>
Array<T, 3> barycentrics(const PixelFaces& pixels) {
  const detail::SeenPoints points(pixels);
  auto result = zeros<T, 3>({pixels.height, pixels.width, 3});
  parallel_for(pixels.height, [&](std::size_t row) {
    for (std::size_t pixel = row * pixels.width; pixel < (row + 1) * pixels.width; ++pixel)
      if (pixels.face[pixel] >= 0) {
        const auto b = points[pixel].barycentric;
        for (std::size_t k = 0; k < 3; ++k) result.data()[3 * pixel + k] = static_cast<T>(b[k]);
      }
  });
  return result;
}

template <std::floating_point T>
void barycentrics_adjoint(const PixelFaces& pixels, const Array<T, 3>& adjoint,
                          std::vector<geometry::Vector3>& positions_adjoint) {
  detail::require_pixels("barycentrics_adjoint", "adjoint", pixels, adjoint, 3);
  detail::require_positions_adjoint("barycentrics_adjoint", *pixels.mesh, positions_adjoint);
  const detail::SeenPoints points(pixels);
  for (std::size_t pixel = 0; pixel < pixels.face.size(); ++pixel) {
    if (pixels.face[pixel] < 0) continue;
    const T* const of_b = adjoint.data() + 3 * pixel;
    const auto of_corners = points[pixel].adjoint_of(
        {static_cast<double>(of_b[0]), static_cast<double>(of_b[1]), static_cast<double>(of_b[2])});
    for (std::size_t k = 0; k < 3; ++k)
      points.add(of_corners[k], points.corners(pixels.face[pixel])[k], positions_adjoint);
  }
}

template <std::floating_point T>
Array<T, 3> interpolate(const PixelFaces& pixels, const Array<T, 3>& barycentric,
                        const Array<T, 2>& attributes, const std::vector<geometry::Corners>& corners) {
  detail::require_pixels("interpolate", "barycentric", pixels, barycentric, 3);
  const std::size_t channels = attributes.shape(1);
  auto out = zeros<T, 3>({pixels.height, pixels.width, channels});
  detail::for_each_attribute(pixels, corners, attributes.shape(0), [&](std::size_t pixel, const auto& of) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < channels; ++c)
        out.data()[pixel * channels + c] += barycentric.data()[3 * pixel + k] * attributes(of[k], c);
  });
  return out;
}

template <std::floating_point T>
void interpolate_adjoint(const PixelFaces& pixels, const Array<T, 3>& barycentric,
                         const Array<T, 2>& attributes, const std::vector<geometry::Corners>& corners,
                         const Array<T, 3>& out_adjoint, Array<T, 3>* barycentric_adjoint,
                         Array<T, 2>* attributes_adjoint) {
  const std::size_t channels = attributes.shape(1);
  detail::require_pixels("interpolate_adjoint", "barycentric", pixels, barycentric, 3);
  detail::require_pixels("interpolate_adjoint", "out_adjoint", pixels, out_adjoint, channels);
  if (barycentric_adjoint != nullptr)
    detail::require_pixels("interpolate_adjoint", "barycentric_adjoint", pixels, *barycentric_adjoint, 3);
  if (attributes_adjoint != nullptr)
    require_shape("interpolate_adjoint", "attributes_adjoint", *attributes_adjoint, attributes.shape());
  detail::for_each_attribute(pixels, corners, attributes.shape(0), [&](std::size_t pixel, const auto& of) {
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < channels; ++c) {
        const T adjoint = out_adjoint.data()[pixel * channels + c];
        if (barycentric_adjoint != nullptr)
          barycentric_adjoint->data()[3 * pixel + k] += adjoint * attributes(of[k], c);
        if (attributes_adjoint != nullptr)
          (*attributes_adjoint)(of[k], c) += adjoint * barycentric.data()[3 * pixel + k];
      }
  });
}

template <std::floating_point T>
Array<T, 3> antialias(const PixelFaces& pixels, const Array<T, 3>& colour) {
  const std::size_t channels = colour.shape(2);
  detail::require_pixels("antialias", "colour", pixels, colour, channels);
  Array<T, 3> out = colour;
  for (const auto& crossing : detail::OutlineSearch(pixels).crossings()) {
    const T* const other = colour.data() + crossing.other() * channels;
    const T* const own = colour.data() + crossing.target() * channels;
    for (std::size_t c = 0; c < channels; ++c)
      out.data()[crossing.target() * channels + c] += static_cast<T>(crossing.weight()) * (other[c] - own[c]);
  }
  return out;
}

template <std::floating_point T>
void antialias_adjoint(const PixelFaces& pixels, const Array<T, 3>& colour, const Array<T, 3>& out_adjoint,
                       Array<T, 3>* colour_adjoint, std::vector<geometry::Vector3>* positions_adjoint) {
  const char* const operation = "antialias_adjoint";
  const std::size_t channels = colour.shape(2);
  detail::require_pixels(operation, "colour", pixels, colour, channels);
  detail::require_pixels(operation, "out_adjoint", pixels, out_adjoint, channels);
  if (positions_adjoint != nullptr)
    detail::require_positions_adjoint(operation, *pixels.mesh, *positions_adjoint);
  if (colour_adjoint != nullptr) {
    detail::require_pixels(operation, "colour_adjoint", pixels, *colour_adjoint, channels);
    *colour_adjoint += out_adjoint;
  }
  const detail::OutlineSearch search(pixels);
  for (const auto& crossing : search.crossings()) {
    const std::size_t target = crossing.target() * channels, other = crossing.other() * channels;
    double by_weight = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const T adjoint = out_adjoint.data()[target + c];
      by_weight += static_cast<double>(adjoint * (colour.data()[other + c] - colour.data()[target + c]));
      if (colour_adjoint == nullptr) continue;
      const T part = static_cast<T>(crossing.weight()) * adjoint;
      colour_adjoint->data()[other + c] += part;
      colour_adjoint->data()[target + c] -= part;
    }
    if (positions_adjoint != nullptr)
      detail::add_crossing(crossing, search.points(), crossing.share() > 0.5 ? by_weight : -by_weight,
                           *positions_adjoint);
  }
}

template <std::floating_point T>
Rasterised<T> rasterise(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height,
                        std::size_t width, const ArrayVariable<T, 2>& positions,
                        std::shared_ptr<const MeshEdges> edges) {
  auto shape = std::make_shared<geometry::Mesh>(mesh);
  if (detail::is_given(positions)) geometry::set_positions("rasterise", *shape, positions.value());
  const auto pixels = std::make_shared<const PixelFaces>(
      pixel_faces(std::move(shape), camera, height, width, std::move(edges)));
  const auto pullback = [pixels](const Array<T, 3>& adjoint, Array<T, 2>* positions_adjoint) {
    std::vector<geometry::Vector3> moving(pixels->mesh->positions.size(), geometry::Vector3{0, 0, 0});
    barycentrics_adjoint(*pixels, adjoint, moving);
    detail::add_positions(moving, *positions_adjoint);
  };
  return {pixels, record_array(barycentrics<T>(*pixels), pullback, positions), positions};
}

template <std::floating_point T>
ArrayVariable<T, 3> interpolate(const Rasterised<T>& rasterised,
                                const std::type_identity_t<ArrayVariable<T, 2>>& attributes,
                                const std::vector<geometry::Corners>& corners) {
  const auto& [pixels, barycentric, positions] = rasterised;
  auto pullback = [pixels = pixels, b = barycentric.shared_value(), values = attributes.shared_value(),
                   corners](const Array<T, 3>& adjoint, Array<T, 3>* b_adjoint,
                            Array<T, 2>* attributes_adjoint) {
    interpolate_adjoint(*pixels, *b, *values, corners, adjoint, b_adjoint, attributes_adjoint);
  };
  return record_array(interpolate(*pixels, barycentric.value(), attributes.value(), corners),
                      std::move(pullback), barycentric, attributes);
}

template <std::floating_point T>
ArrayVariable<T, 3> texture_coordinates(const Rasterised<T>& rasterised) {
  const auto& mesh = *rasterised.pixels->mesh;
  Array<T, 2> uvs(Extents<2>{mesh.uvs.size(), 2});
  for (std::size_t i = 0; i < uvs.size(); ++i) uvs.data()[i] = static_cast<T>(mesh.uvs[i / 2][i % 2]);
  return interpolate<T>(rasterised, uvs, mesh.face_uvs);
}

template <std::floating_point T>
ArrayVariable<T, 3> antialias(const Rasterised<T>& rasterised,
                              const std::type_identity_t<ArrayVariable<T, 3>>& colour) {
  const auto pullback = [pixels = rasterised.pixels, values = colour.shared_value()](
                            const Array<T, 3>& adjoint, Array<T, 3>* colour_adjoint,
                            Array<T, 2>* positions_adjoint) {
    std::vector<geometry::Vector3> moving(pixels->mesh->positions.size(), geometry::Vector3{0, 0, 0});
    antialias_adjoint(*pixels, *values, adjoint, colour_adjoint,
                      positions_adjoint == nullptr ? nullptr : &moving);
    if (positions_adjoint != nullptr) detail::add_positions(moving, *positions_adjoint);
  };
  return record_array(antialias(*rasterised.pixels, colour.value()), pullback, colour, rasterised.positions);
}
}  // namespace tapestry::raster
