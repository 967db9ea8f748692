#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/mip_levels.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/surface.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <tapestry/raster/used_texels.hpp>
#include <vector>

namespace tapestry::raster::detail {

std::vector<MipOverlap> mip_overlaps(std::size_t coarse_size, std::size_t fine_size) {
  std::vector<MipOverlap> overlaps;
  overlaps.reserve(coarse_size);
  for (std::size_t coarse = 0; coarse < coarse_size; ++coarse) {
    // In units of 1 / coarse_size of a fine texel, so that all bounds are whole numbers.
    const std::size_t begin = coarse * fine_size, end = begin + fine_size;
    MipOverlap overlap{begin / coarse_size, 0, {}};
    for (std::size_t fine = overlap.first; fine * coarse_size < end; ++fine) {
      const std::size_t low = std::max(begin, fine * coarse_size);
      const std::size_t high = std::min(end, (fine + 1) * coarse_size);
      overlap.weights[overlap.count++] = static_cast<double>(high - low) / static_cast<double>(fine_size);
    }
    overlaps.push_back(overlap);
  }
  return overlaps;
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

MipPyramid::MipPyramid(const TextureLayout& layout) : layout_(layout) {
  const auto levels = mip_levels(layout);
  for (std::size_t level = 1; level < levels.size(); ++level)
    steps_.emplace_back(levels[level - 1], levels[level]);
  texel_count_ = levels.back().first_texel + 1;
}

double MipPyramid::part_of(std::size_t fine, std::size_t coarse) const {
  if (shares_.empty()) return 1;
  if (shares_[fine] == 0) return 0;
  return shares_[fine] / shares_[coarse];
}

template <std::floating_point T>
Array<T, 2> with_unused_filled(const TextureLayout& layout, const Array<T, 2>& used,
                               const Array<T, 2>& texels) {
  const auto pyramid = MipPyramid(layout, used)(texels);
  Array<T, 2> filled = texels;
  if (std::any_of(used.data(), used.data() + used.size(), [](T value) { return value != T(0); }))
    std::copy_n(pyramid.data(), filled.size(), filled.data());
  return filled;
}

template decltype(with_unused_filled<float>) with_unused_filled<float>;
template decltype(with_unused_filled<double>) with_unused_filled<double>;

template <std::floating_point T>
ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                  const ArrayVariable<T, 2>& texels) {
  if (!pyramid) return texels;
  const auto pullback = [pyramid](const Array<T, 2>& pyramid_adjoint, Array<T, 2>* texels_adjoint) {
    pyramid->adjoint(pyramid_adjoint, *texels_adjoint);
  };
  return record_array((*pyramid)(texels.value()), pullback, texels);
}

template ArrayVariable<float, 2> stored_texels<float>(const std::shared_ptr<const MipPyramid>& pyramid,
                                                      const ArrayVariable<float, 2>& texels);
template ArrayVariable<double, 2> stored_texels<double>(const std::shared_ptr<const MipPyramid>& pyramid,
                                                        const ArrayVariable<double, 2>& texels);

}  // namespace tapestry::raster

namespace tapestry::raster::detail {

bool TexelRectangle::meets(const UvTriangle& corner) const {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto [low, high] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
    if (!(high > (axis == 0 ? left : top) && low < (axis == 0 ? right : bottom))) return false;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& a = corner[k];
    const auto& b = corner[(k + 1) % 3];
    const auto& c = corner[(k + 2) % 3];
    const double nx = a[1] - b[1], ny = b[0] - a[0];
    if (nx == 0 && ny == 0) continue;
    const double apex = nx * (c[0] - a[0]) + ny * (c[1] - a[1]);
    const double centre = nx * ((left + right) / 2 - a[0]) + ny * ((top + bottom) / 2 - a[1]);
    const double reach = (std::abs(nx) * (right - left) + std::abs(ny) * (bottom - top)) / 2;
    if (centre + reach <= std::min(0.0, apex) || centre - reach >= std::max(0.0, apex)) return false;
  }
  return true;
}

std::array<double, 2> reach_of_texel(long long index, double size) {
  const auto at = static_cast<double>(index);
  const double begin = std::floor(at / size) * size;
  return {std::max(at - 0.5, begin), std::min(at + 1.5, begin + size)};
}

std::vector<double> moves_off_border(const UvTriangle& corner, std::size_t axis, double size) {
  const auto [low, high] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
  const double border = std::round(low / size);
  if (std::max(high - low, std::abs(low - border * size)) > 1e-9 * size) return {0};
  if (border == 0) return {0.25};
  if (border == 1) return {-0.25};
  return {-0.25, 0.25};
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
Array<T, 2> used_texels(const PaintedMesh& body) {
  if (body.layout.kind != TextureKind::atlas)
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

std::shared_ptr<const MipPyramid> pyramid_of(const PaintedMesh& body) {
  if (!is_filtered(body.layout)) return nullptr;
  return std::make_shared<const MipPyramid>(body.layout, used_texels_or_all<float>(body));
}

template decltype(used_texels<float>) used_texels<float>;
template decltype(used_texels<double>) used_texels<double>;
template decltype(used_texels_or_all<float>) used_texels_or_all<float>;
template decltype(used_texels_or_all<double>) used_texels_or_all<double>;

}  // namespace tapestry::raster

namespace tapestry::raster::detail {

std::array<double, 3> clamped_barycentric(std::array<double, 3> b) {
  double sum = 0;
  for (double& value : b) sum += value = std::max(value, 0.0);
  for (double& value : b) value = sum > 0 ? value / sum : 1.0 / 3;
  return b;
}

template <std::floating_point T>
void require_bakeable(const char* operation, const PaintedMesh& body, const Array<T, 2>& texels) {
  require_layout(operation, body);
  require_shape(operation, "texels", texels, {body.layout.texel_count(body.mesh), 3});
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
Array<T, 2> bake_atlas(const PaintedMesh& body, const Array<T, 2>& texels, const TextureLayout& to) {
  detail::require_bakeable("bake_atlas", body, texels);
  if (to.kind != TextureKind::atlas || to.height == 0 || to.width == 0 || !(to.u_extent > 0))
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
  if (to.kind != TextureKind::cube || to.texels_per_edge == 0 || to.texels_per_edge > 256)
    throw DomainError("bake_cube: expected the layout of a cube of 1 to 256 texels an edge");
  const SurfaceColour<T, PreparedUnlit> colour(body, texels, {});
  const std::size_t edge = to.texels_per_edge, count = edge * edge * edge;
  auto cube = filled<T, 2>({to.texel_count(body.mesh), 3}, unused);
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    for (std::size_t texel = 0; texel < count; ++texel) {
      const std::array<double, 3> at{static_cast<double>(texel / (edge * edge)),
                                     static_cast<double>(texel / edge % edge),
                                     static_cast<double>(texel % edge)};
      const auto value = colour.at(static_cast<std::int32_t>(face), detail::clamped_barycentric(at));
      for (std::size_t c = 0; c < 3; ++c) cube(face * count + texel, c) = static_cast<T>(value[c]);
    }
  }
  return cube;
}

template decltype(bake_atlas<float>) bake_atlas<float>;
template decltype(bake_atlas<double>) bake_atlas<double>;
template decltype(bake_cube<float>) bake_cube<float>;
template decltype(bake_cube<double>) bake_cube<double>;

}  // namespace tapestry::raster
