#pragma once
#include <array>
#include <cstddef>
#include <tapestry/raster/mip_levels.hpp>

namespace tapestry::raster {

/// Fragments that a filtered atlas is looked up for, in separate arrays.
struct LookupBatch {
  static constexpr std::size_t size = 32;
  using Numbers = std::array<double, size>;
  alignas(64) std::array<Numbers, 4> steps;    ///< AtlasSteps
  alignas(64) std::array<Numbers, 2> place;    ///< {column, row}, in units of the atlas
  alignas(64) std::array<Numbers, 2> between;  ///< two neighbouring lookups of a fragment, likewise
  alignas(64) Numbers lookups;                 ///< how many; 0: not to be looked up
  alignas(64) Numbers level;                   ///< of the pyramid: whole, or between two
};

/// How lookups are chosen.
struct LookupRule {
  std::array<double, 2> atlas_size;  ///< columns, rows
  double most_lookups;               ///< of a fragment; 1: trilinear
  double top_level;
};

/// What fragments are looked up in.
struct PyramidTexels {
  const MipLevel* levels;  ///< from the atlas itself up
  const float* texels;     ///< [texel_count, 3]
};

}  // namespace tapestry::raster
