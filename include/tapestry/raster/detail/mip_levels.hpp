#pragma once
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {
/// One picture of a pyramid.
struct MipLevel {
  std::size_t height;
  std::size_t width;
  std::size_t first_texel;  ///< index of its texel (0, 0) in the whole pyramid
};

/// The atlas itself, then pictures of half the height and width each, rounded down but at least one texel, to
/// the single texel at the top.
[[nodiscard]] inline std::vector<MipLevel> mip_levels(const TextureLayout& layout) {
  std::vector<MipLevel> levels{{layout.height, layout.width, 0}};
  while (levels.back().height > 1 || levels.back().width > 1) {
    const MipLevel& finer = levels.back();
    levels.push_back({std::max<std::size_t>(finer.height / 2, 1), std::max<std::size_t>(finer.width / 2, 1),
                      finer.first_texel + finer.height * finer.width});
  }
  return levels;
}

/// Whether a texture is looked up in the levels of a pyramid.
[[nodiscard]] inline bool is_filtered(const TextureLayout& layout) {
  return layout.traits().is_picture && layout.filter != TextureFilter::bilinear;
}

/// Number of texels that operators of this layout take: the pyramid's for a filtered
/// atlas, else the texture's own.
[[nodiscard]] inline std::size_t stored_texel_count(const TextureLayout& layout, const geometry::Mesh& mesh) {
  return is_filtered(layout) ? mip_levels(layout).back().first_texel + 1 : layout.texel_count(mesh);
}

/// A batch of fragments for lookups in a filtered atlas, in separate arrays.
struct LookupBatch {
  static constexpr std::size_t size = 32;
  using Numbers = std::array<double, size>;
  alignas(64) std::array<Numbers, 4> steps;    ///< AtlasSteps
  alignas(64) std::array<Numbers, 2> place;    ///< {column, row}, in units of the atlas
  alignas(64) std::array<Numbers, 2> between;  ///< two neighbouring lookups of a fragment, likewise
  alignas(64) Numbers lookups;                 ///< number of lookups; 0: none
  alignas(64) Numbers level;                   ///< level of the pyramid: whole, or between two
};

/// Rule for choosing lookups.
struct LookupRule {
  std::array<double, 2> atlas_size;  ///< columns, rows
  double most_lookups;               ///< most lookups for a fragment; 1: trilinear
  double top_level;
};

/// The levels and texels that fragments are looked up in.
struct PyramidTexels {
  const MipLevel* levels;  ///< from the atlas itself up
  const float* texels;     ///< [texel_count, 3]
};
}  // namespace tapestry::raster
