#pragma once
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/detail/surface.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::raster {
namespace detail {
template <std::floating_point T>
void require_bakeable(const char* operation, const PaintedMesh& body, const Array<T, 2>& texels) {
  require_layout(operation, body);
  require_shape(operation, "texels", texels, {body.layout.texel_count(body.mesh), 3});
}
}  // namespace detail

template <std::floating_point T>
Array<T, 2> with_unused_filled(const TextureLayout& layout, const Array<T, 2>& used,
                               const Array<T, 2>& texels) {
  const auto pyramid = MipPyramid(layout, used)(texels);
  Array<T, 2> filled = texels;
  if (std::any_of(used.data(), used.data() + used.size(), [](T value) { return value != T(0); }))
    std::copy_n(pyramid.data(), filled.size(), filled.data());
  return filled;
}

template <std::floating_point T>
ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                  const ArrayVariable<T, 2>& texels, image::ColourSpace space) {
  if (!pyramid) return image::in_space(space, texels);
  const auto value = std::make_shared<const Array<T, 2>>((*pyramid)(texels.value(), space));
  const bool is_linear = space == image::ColourSpace::linear;
  const auto pullback = [pyramid, kept = is_linear ? texels.shared_value() : nullptr,
                         light = is_linear ? value : nullptr](const Array<T, 2>& pyramid_adjoint,
                                                              Array<T, 2>* texels_adjoint) {
    pyramid->adjoint(pyramid_adjoint, *texels_adjoint, kept.get(), light.get());
  };
  return record_array(value, pullback, texels);
}

template <std::floating_point T>
Array<T, 2> used_texels(const PaintedMesh& body) {
  if (!body.layout.traits().is_picture)
    throw DomainError("used_texels: expected an atlas, found a texture of another kind");
  detail::require_layout("used_texels", body);
  auto used = zeros<T, 2>({body.layout.height, body.layout.width});
  detail::for_each_used_texel(
      body, [&](std::size_t, std::size_t row, std::size_t column) { used(row, column) = T(1); });
  return used;
}

template <std::floating_point T>
Array<T, 2> used_texels_or_all(const PaintedMesh& body) {
  try {
    return used_texels<T>(body);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::limit) throw;
    return filled<T, 2>({body.layout.height, body.layout.width}, T(1));
  }
}

template <std::floating_point T>
Array<T, 2> bake_atlas(const PaintedMesh& body, const Array<T, 2>& texels, const TextureLayout& to) {
  detail::require_bakeable("bake_atlas", body, texels);
  if (!to.traits().is_picture || to.height == 0 || to.width == 0 || !(to.u_extent > 0))
    throw DomainError("bake_atlas: expected the layout of an atlas with rows, columns and a u_extent");
  const SurfaceColour<T, PreparedUnlit> colour(body, texels, {});
  auto atlas = filled<T, 2>({to.height * to.width, 3}, T(0.5));
  auto used = zeros<T, 2>({to.height, to.width});
  for (const bool is_rim : {true, false}) {
    for (std::size_t face = 0; face < body.painted.size(); ++face) {
      if (body.painted[face] == 0) continue;
      for_each_atlas_texel(
          body.mesh, to, face, [&](std::size_t row, std::size_t column, const std::array<double, 3>& b) {
            if ((std::min({b[0], b[1], b[2]}) < 0) != is_rim) return;
            const auto value = colour.at(static_cast<std::int32_t>(face), detail::clamped_barycentric(b));
            for (std::size_t c = 0; c < 3; ++c) atlas(row * to.width + column, c) = static_cast<T>(value[c]);
            used(row, column) = T(1);
          });
    }
  }
  return with_unused_filled(to, used, atlas);
}

template <std::floating_point T>
Array<T, 2> bake_cube(const PaintedMesh& body, const Array<T, 2>& texels, const TextureLayout& to, T unused) {
  detail::require_bakeable("bake_cube", body, texels);
  if (!to.traits().is_by_face || to.texels_per_edge == 0 || to.texels_per_edge > 256)
    throw DomainError("bake_cube: expected the layout of a cube of 1 to 256 texels an edge");
  const SurfaceColour<T, PreparedUnlit> colour(body, texels, {});
  auto cube = filled<T, 2>({to.texel_count(body.mesh), 3}, unused);
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    for_each_texel_on(to, body.mesh, face, [&](std::size_t texel, const std::array<double, 3>& b) {
      const auto value = colour.at(static_cast<std::int32_t>(face), b);
      for (std::size_t c = 0; c < 3; ++c) cube(texel, c) = static_cast<T>(value[c]);
    });
  }
  return cube;
}
}  // namespace tapestry::raster
