#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/mip_levels.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
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

}  // namespace tapestry::raster
