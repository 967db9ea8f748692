#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/raster/texture_atlas.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <vector>

namespace tapestry::raster {

/// One picture of a pyramid.
struct MipLevel {
  std::size_t height;
  std::size_t width;
  std::size_t first_texel;  ///< index of its texel (0, 0) in the whole pyramid
};

/// The atlas itself, then pictures of half the height and width, rounded down, but of at least one texel, to
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

/// Texels that the operator of a view of this layout takes: those of the pyramid for a trilinear atlas, else
/// the texture's own.
[[nodiscard]] inline std::size_t stored_texel_count(const TextureLayout& layout, const geometry::Mesh& mesh) {
  if (layout.kind != TextureKind::atlas || layout.filter != TextureFilter::trilinear)
    return layout.texel_count(mesh);
  const MipLevel top = mip_levels(layout).back();
  return top.first_texel + 1;
}

namespace detail {

/// Calls visit(coarse, fine, weight) for every texel along an axis of the coarser picture and every texel of
/// the finer one that it covers; the weights of a coarse texel sum to 1.
template <class Visit>
void for_each_overlap(std::size_t coarse_size, std::size_t fine_size, Visit visit) {
  for (std::size_t coarse = 0; coarse < coarse_size; ++coarse) {
    // In units of 1 / coarse_size of a fine texel, so that all bounds are whole numbers.
    const std::size_t begin = coarse * fine_size, end = begin + fine_size;
    for (std::size_t fine = begin / coarse_size; fine * coarse_size < end; ++fine) {
      const std::size_t low = std::max(begin, fine * coarse_size);
      const std::size_t high = std::min(end, (fine + 1) * coarse_size);
      visit(coarse, fine, static_cast<double>(high - low) / static_cast<double>(fine_size));
    }
  }
}

/// Calls visit(coarse texel, fine texel, weight) for a level and the next finer one.
template <class Visit>
void for_each_mip_weight(const MipLevel& fine, const MipLevel& coarse, Visit visit) {
  for_each_overlap(coarse.height, fine.height, [&](std::size_t i, std::size_t y, double row_weight) {
    for_each_overlap(coarse.width, fine.width, [&](std::size_t j, std::size_t x, double column_weight) {
      visit(coarse.first_texel + i * coarse.width + j, fine.first_texel + y * fine.width + x,
            row_weight * column_weight);
    });
  });
}

}  // namespace detail

/// An atlas with all coarser pictures of it: every texel of a level is the mean of the finer level over its
/// own area, exactly so for odd sizes too.
///
/// \param texels  [height · width, 3]
/// \returns       [stored_texel_count, 3]: what render() takes for a trilinear layout
/// \throws ShapeError if texels does not fit the layout
template <std::floating_point T>
[[nodiscard]] Array<T, 2> mip_pyramid(const TextureLayout& layout, const Array<T, 2>& texels) {
  require_shape("mip_pyramid", "texels", texels, {layout.height * layout.width, 3});
  const auto levels = mip_levels(layout);
  auto pyramid = zeros<T, 2>({levels.back().first_texel + 1, 3});
  std::copy_n(texels.data(), texels.size(), pyramid.data());
  for (std::size_t level = 1; level < levels.size(); ++level) {
    detail::for_each_mip_weight(levels[level - 1], levels[level],
                                [&](std::size_t coarse, std::size_t fine, double weight) {
                                  for (std::size_t c = 0; c < 3; ++c)
                                    pyramid(coarse, c) += static_cast<T>(weight) * pyramid(fine, c);
                                });
  }
  return pyramid;
}

/// Adds the pullback of mip_pyramid() to texels_adjoint, [height · width, 3].
/// \param pyramid_adjoint  [stored_texel_count, 3]; taken by value, since coarse levels flow into finer ones
template <std::floating_point T>
void mip_pyramid_adjoint(const TextureLayout& layout, Array<T, 2> pyramid_adjoint,
                         Array<T, 2>& texels_adjoint) {
  const auto levels = mip_levels(layout);
  require_shape("mip_pyramid_adjoint", "pyramid_adjoint", pyramid_adjoint,
                {levels.back().first_texel + 1, 3});
  require_shape("mip_pyramid_adjoint", "texels_adjoint", texels_adjoint, {layout.height * layout.width, 3});
  for (std::size_t level = levels.size(); --level > 0;) {
    detail::for_each_mip_weight(
        levels[level - 1], levels[level], [&](std::size_t coarse, std::size_t fine, double weight) {
          for (std::size_t c = 0; c < 3; ++c)
            pyramid_adjoint(fine, c) += static_cast<T>(weight) * pyramid_adjoint(coarse, c);
        });
  }
  for (std::size_t i = 0; i < texels_adjoint.size(); ++i)
    texels_adjoint.data()[i] += pyramid_adjoint.data()[i];
}

/// Lookup between two levels of a pyramid: calls visit(Tap) up to eight times, with weights that sum to 1.
///
/// \param footprint_texels  width of the pixel's footprint in texels of the atlas, ρ. The level is log₂ ρ,
/// cut
///                          to the pyramid; up to one texel the atlas itself is looked up.
template <class Visit>
void visit_trilinear_taps(const TextureLayout& layout, const std::vector<MipLevel>& levels,
                          const std::array<double, 2>& uv, double footprint_texels, Visit visit) {
  const double top = static_cast<double>(levels.size() - 1);
  const double level = footprint_texels > 1 ? std::min(std::log2(footprint_texels), top) : 0;
  const auto finer = static_cast<std::size_t>(level);
  const auto visit_level = [&](std::size_t index, double share) {
    if (!(share > 0)) return;
    TextureLayout picture = layout;
    picture.height = levels[index].height;
    picture.width = levels[index].width;
    visit_atlas_taps(picture, uv, [&](const Tap& tap) {
      visit(Tap{levels[index].first_texel + tap.texel, tap.weight * share});
    });
  };
  const double share = level - static_cast<double>(finer);
  visit_level(finer, 1 - share);
  visit_level(std::min(finer + 1, levels.size() - 1), share);
}

}  // namespace tapestry::raster
