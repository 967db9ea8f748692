#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/used_texels.hpp>
#include <vector>

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
