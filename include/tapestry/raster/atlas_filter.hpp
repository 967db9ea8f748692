#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tapestry/raster/footprint.hpp>
#include <tapestry/raster/mip_levels.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/texture_atlas.hpp>
#include <vector>

namespace tapestry::raster {

/// Looks up an atlas in the levels of its pyramid.
///
/// trilinear: the level is log₂ of the footprint's length in texels, between two pictures; up to one texel
/// the atlas itself. anisotropic: log₂ of its width, at as many places along it as it is longer than wide,
/// but at most layout.most_lookups, which then lie farther apart, and coarser levels fill the gaps.
///
/// Source: the rules of OpenGL 4.6, section 8.14.1; places and widths as in EXT_texture_filter_anisotropic.
class AtlasFilter {
 public:
  /// \param body  with a filtered atlas, see is_filtered(), and sound uvs
  explicit AtlasFilter(const PaintedMesh& body) : layout_(body.layout), levels_(mip_levels(body.layout)) {
    for (std::size_t face = 0; face < body.painted.size(); ++face)
      if (body.painted[face] != 0)
        for (const std::int32_t uv : body.mesh.face_uvs[face]) {
          const auto& [u, v] = body.mesh.uvs[static_cast<std::size_t>(uv)];
          repeats_ = repeats_ ||
                     detail::wrapped(u, layout_.u_extent) != std::clamp(u, 0.0, layout_.u_extent) ||
                     detail::wrapped(v, 1) != std::clamp(v, 0.0, 1.0);
        }
  }

  /// Calls visit(Tap), with weights that sum to 1.
  /// \param scale  of the footprint, at most 1
  template <class Visit>
  void visit_taps(const std::array<double, 2>& uv, const Footprint& footprint, double scale,
                  Visit visit) const {
    const std::array<double, 2> at{uv[0] / layout_.u_extent, uv[1]};
    const double length = footprint.length * scale;
    if (layout_.filter == TextureFilter::trilinear || !(length > 1))
      return visit_levels(at, {0, 0}, 1, length, visit);
    const double width = std::max(footprint.width * scale, 1.0);
    const double lookups =
        std::clamp(std::ceil(length / width), 1.0, static_cast<double>(layout_.most_lookups));
    const std::array<double, 2> step{footprint.along[0] * scale / lookups / layout_.u_extent,
                                     footprint.along[1] * scale / lookups};
    visit_levels(at, step, static_cast<std::size_t>(lookups), std::max(width, length / lookups), visit);
  }

 private:
  /// Lookups at places in a row around `at`, in units of the atlas, between the levels whose texels are
  /// `size` texels of the atlas.
  template <class Visit>
  void visit_levels(const std::array<double, 2>& at, const std::array<double, 2>& step, std::size_t lookups,
                    double size, Visit visit) const {
    const double top = static_cast<double>(levels_.size() - 1);
    const double level = size > 1 ? std::min(std::log2(size), top) : 0;
    const auto finer = static_cast<std::size_t>(level);
    const double share = level - static_cast<double>(finer), each = 1 / static_cast<double>(lookups);
    visit_level(levels_[finer], at, step, lookups, (1 - share) * each, visit);
    if (share > 0) visit_level(levels_[finer + 1], at, step, lookups, share * each, visit);
  }

  template <class Visit>
  void visit_level(const MipLevel& level, const std::array<double, 2>& at, const std::array<double, 2>& step,
                   std::size_t lookups, double weight, Visit visit) const {
    const double first = (1 - static_cast<double>(lookups)) / 2;
    for (std::size_t i = 0; i < lookups; ++i) {
      const double steps = first + static_cast<double>(i);
      visit_picture_taps(level.height, level.width, placed(at[0] + steps * step[0]),
                         placed(at[1] + steps * step[1]), [&](const Tap& tap) {
                           visit(Tap{level.first_texel + tap.texel, tap.weight * weight});
                         });
    }
  }

  /// A footprint does not reach over the border of an atlas that no face repeats.
  [[nodiscard]] double placed(double coordinate) const {
    return repeats_ ? detail::wrapped(coordinate, 1) : std::clamp(coordinate, 0.0, 1.0);
  }

  TextureLayout layout_;
  std::vector<MipLevel> levels_;
  bool repeats_ = false;
};

}  // namespace tapestry::raster
