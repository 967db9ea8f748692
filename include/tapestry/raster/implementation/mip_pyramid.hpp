#pragma once
#include <tapestry/raster/detail/surface.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::raster {
namespace detail {
std::vector<MipOverlap> mip_overlaps(std::size_t coarse_size, std::size_t fine_size) {
  std::vector<MipOverlap> overlaps;
  overlaps.reserve(coarse_size);
  for (std::size_t coarse = 0; coarse < coarse_size; ++coarse) {
    // Bounds count units of 1 / coarse_size of a fine texel: they are whole numbers.
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

MipStep::MipStep(const MipLevel& finer, const MipLevel& coarser)
    : fine(finer),
      coarse(coarser),
      rows(mip_overlaps(coarser.height, finer.height)),
      columns(mip_overlaps(coarser.width, finer.width)) {
  for (const MipOverlap& row : rows) {
    first_part.push_back(parts.size());
    for (const MipOverlap& column : columns)
      for (std::size_t y = 0; y < row.count; ++y)
        for (std::size_t x = 0; x < column.count; ++x) parts.push_back(row.weights[y] * column.weights[x]);
  }
}

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

std::array<double, 3> clamped_barycentric(std::array<double, 3> b) {
  double sum = 0;
  for (double& value : b) sum += value = std::max(value, 0.0);
  for (double& value : b) value = sum > 0 ? value / sum : 1.0 / 3;
  return b;
}
}  // namespace detail

MipPyramid::MipPyramid(const TextureLayout& layout) : layout_(layout) {
  const auto levels = mip_levels(layout);
  for (std::size_t level = 1; level < levels.size(); ++level)
    steps_.emplace_back(levels[level - 1], levels[level]);
  texel_count_ = levels.back().first_texel + 1;
}

std::shared_ptr<const MipPyramid> pyramid_of(const PaintedMesh& body) {
  if (!is_filtered(body.layout)) return nullptr;
  return std::make_shared<const MipPyramid>(body.layout, used_texels_or_all<float>(body));
}
}  // namespace tapestry::raster
