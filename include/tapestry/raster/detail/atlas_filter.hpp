#pragma once
#include <tapestry/raster/detail/raster_kernels.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::raster {
/// Steps in an atlas for a step of a column and of a row in the picture, in texels, rows downwards: {columns,
/// rows} for the first, then for the second. A pixel's circle becomes an ellipse there, its footprint.
using AtlasSteps = std::array<double, 4>;

/// Map from the points of a face to their places in an atlas, and to the footprint of a pixel there.
///
/// With c_k = q_{k+1} × q_{k+2}, C = Σ c_k, D = q₀·c₀ and the depth z = Σ b_k z_k of a point,
///   ∂b_k/∂column = z · 2·tan_half_fov_x/width · (c_k − b_k·C)_x / D,
/// and for rows the same with y. All zero for a face that is seen edge-on.
class FaceInAtlas {
 public:
  /// \param corners_view  q₀, q₁, q₂
  /// \param corner_uvs    uvs of these corners
  FaceInAtlas(const std::array<geometry::Vector3, 3>& corners_view,
              const std::array<std::array<double, 2>, 3>& corner_uvs, const TextureLayout& layout,
              const geometry::Camera& camera, double height, double width)
      : size_{static_cast<double>(layout.width), static_cast<double>(layout.height)} {
    std::array<geometry::Vector3, 3> c{};
    geometry::Vector3 total{};
    for (std::size_t k = 0; k < 3; ++k) {
      c[k] = geometry::cross(corners_view[(k + 1) % 3], corners_view[(k + 2) % 3]);
      total = geometry::add(total, c[k]);
      depth_[k] = corners_view[k][2];
      place_[k] = {corner_uvs[k][0] / layout.u_extent, 1 - corner_uvs[k][1]};
    }
    const double inverse = 1 / geometry::dot(corners_view[0], c[0]);
    if (!std::isfinite(inverse)) return;
    const std::array<double, 2> pixel{2 * camera.tan_half_fov_x / width * inverse,
                                      2 * camera.tan_half_fov_y / height * inverse};
    for (std::size_t way = 0; way < 2; ++way) {
      turn_[way] = pixel[way] * total[way];
      for (std::size_t axis = 0; axis < 2; ++axis)  // relative to a corner: the sums of c_k leave it out
        steps_[2 * way + axis] = pixel[way] * size_[axis] *
                                 ((place_[1][axis] - place_[0][axis]) * c[1][way] +
                                  (place_[2][axis] - place_[0][axis]) * c[2][way]);
    }
  }

  /// {column, row} of a point, in units of the atlas, row 0 on top.
  /// \param b  its barycentric coordinates
  [[nodiscard]] std::array<double, 2> place(const std::array<double, 3>& b) const {
    std::array<double, 2> sum{0, 0};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 2; ++axis) sum[axis] += b[k] * place_[k][axis];
    return sum;
  }

  /// \param b      a point's barycentric coordinates
  /// \param scale  of the pixel
  [[nodiscard]] AtlasSteps steps(const std::array<double, 3>& b, double scale = 1) const {
    const double z = (b[0] * depth_[0] + b[1] * depth_[1] + b[2] * depth_[2]) * scale;
    AtlasSteps steps{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double away = size_[axis] * (b[1] * (place_[1][axis] - place_[0][axis]) +
                                         b[2] * (place_[2][axis] - place_[0][axis]));
      for (std::size_t way = 0; way < 2; ++way)
        steps[2 * way + axis] = z * (steps_[2 * way + axis] - away * turn_[way]);
    }
    return steps;
  }

 private:
  std::array<double, 2> size_;
  std::array<std::array<double, 2>, 3> place_{};
  std::array<double, 3> depth_{};
  AtlasSteps steps_{0, 0, 0, 0};      ///< at the first corner, to a depth of 1
  std::array<double, 2> turn_{0, 0};  ///< change of the steps over the face
};

/// Looks up an atlas in the levels of its pyramid.
///
/// trilinear: between the two levels around log₂ of the footprint's length in texels; up to one texel the
/// atlas itself. anisotropic: at the level log₂ of its width, at several places along its length. Their
/// number is length / width, but at most layout.most_lookups; beyond that the places lie farther apart, and
/// coarser levels fill the gaps. A footprint's length and width are the singular values of the map
/// AtlasSteps.
///
/// Source: the rules of OpenGL 4.6, section 8.14.1; places and widths as in EXT_texture_filter_anisotropic.
class AtlasFilter {
 public:
  /// \param body  with a filtered atlas, see is_filtered(), and sound uvs
  explicit AtlasFilter(const PaintedMesh& body) : levels_(mip_levels(body.layout)) {
    const TextureLayout& layout = body.layout;
    rule_ = {{static_cast<double>(layout.width), static_cast<double>(layout.height)},
             layout.filter == TextureFilter::trilinear ? 1 : static_cast<double>(layout.most_lookups),
             static_cast<double>(levels_.size() - 1)};
    for (std::size_t face = 0; face < body.painted.size(); ++face)
      if (body.painted[face] != 0)
        for (const std::int32_t uv : body.mesh.face_uvs[face]) {
          const auto& [u, v] = body.mesh.uvs[static_cast<std::size_t>(uv)];
          repeats_ = repeats_ || detail::is_outside(u, layout.u_extent) || detail::is_outside(v, 1);
        }
  }

  /// Calls visit(Tap), with weights that sum to 1.
  /// \param place  {column, row}, in units of the atlas
  template <class Visit>
  void visit_taps(const std::array<double, 2>& place, const AtlasSteps& steps, Visit visit) const {
    LookupBatch batch;
    for (std::size_t i = 0; i < steps.size(); ++i) batch.steps[i][0] = steps[i];
    for (std::size_t axis = 0; axis < 2; ++axis) batch.place[axis][0] = place[axis];
    choose(batch, 1);
    visit_chosen(batch, 0, visit);
  }

  /// Computes level and lookups of fragments.
  /// \param batch  with their places and steps
  /// \param count  at most LookupBatch::size
  void choose(LookupBatch& batch, std::size_t count) const {
    constexpr std::size_t widest = 8;  // vector of any instruction set
    for (auto& steps : batch.steps)
      std::fill_n(steps.begin() + static_cast<std::ptrdiff_t>(count), (widest - count % widest) % widest,
                  0.0);
    raster_kernels().choose_lookups(rule_, batch, count);
  }

  /// Calls visit(Tap) for a fragment after choose() for it.
  template <class Visit>
  void visit_chosen(const LookupBatch& batch, std::size_t i, Visit visit) const {
    const auto finer = static_cast<std::size_t>(batch.level[i]);
    const double share = batch.level[i] - static_cast<double>(finer), each = 1 / batch.lookups[i];
    visit_level(levels_[finer], batch, i, (1 - share) * each, visit);
    if (share > 0) visit_level(levels_[finer + 1], batch, i, share * each, visit);
  }

  /// {red, green, blue} of each fragment of a batch.
  using Colours = std::array<std::array<float, 3>, LookupBatch::size>;

  /// Colours of fragments.
  /// \param batch   with their places and steps
  /// \param count   at most LookupBatch::size
  /// \param texels  of the pyramid, [texel_count, 3]
  void look_up(LookupBatch& batch, std::size_t count, const float* texels, Colours& colours) const {
    choose(batch, count);
    std::array<double, LookupBatch::size> lookups;
    std::copy_n(batch.lookups.begin(), count, lookups.begin());
    for (std::size_t i = 0; i < count; ++i)
      if (!is_plain(batch, i)) batch.lookups[i] = 0;
    std::array<float, 8 * LookupBatch::size> sums;
    raster_kernels().look_up({levels_.data(), texels}, batch, count, sums.data());
    for (std::size_t i = 0; i < count; ++i) {
      const float* const sum = sums.data() + 8 * i;
      auto& colour = colours[i];
      for (std::size_t c = 0; c < 3; ++c) colour[c] = sum[c] + sum[c + 3];
      // A NaN texel counts only if its weight is not 0.
      if (batch.lookups[i] > 0 && std::isfinite(colour[0] + colour[1] + colour[2])) continue;
      batch.lookups[i] = lookups[i];
      colour = {0, 0, 0};
      visit_chosen(batch, i, [&](const Tap& tap) {
        for (std::size_t c = 0; c < 3; ++c)
          colour[c] += static_cast<float>(tap.weight) * texels[3 * tap.texel + c];
      });
    }
  }

 private:
  /// Whether the kernel can look up a fragment: the levels must be small enough and below the two highest,
  /// which the kernel would read past, and no step may cross the border of an atlas that faces repeat. Also
  /// moves the fragment's place into the atlas.
  [[nodiscard]] bool is_plain(LookupBatch& batch, std::size_t i) const {
    if (!(batch.level[i] < rule_.top_level - 2) ||
        levels_.back().first_texel > std::numeric_limits<std::int32_t>::max() / 3)
      return false;
    if (!repeats_) return true;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      double& place = batch.place[axis][i];
      place = axis == 0 ? detail::wrapped(place, 1) : 1 - detail::wrapped(1 - place, 1);
      const double reach = std::abs(batch.between[axis][i]) * (batch.lookups[i] - 1) / 2;
      if (!(place - reach >= 0 && place + reach <= 1)) return false;
    }
    return true;
  }

  template <class Visit>
  void visit_level(const MipLevel& level, const LookupBatch& batch, std::size_t fragment, double weight,
                   Visit visit) const {
    const double lookups = batch.lookups[fragment];
    for (double steps = (1 - lookups) / 2; steps < lookups / 2; ++steps)
      visit_picture_taps(
          level.height, level.width, placed(batch.place[0][fragment] + steps * batch.between[0][fragment]),
          placed(1 - batch.place[1][fragment] - steps * batch.between[1][fragment]), [&](const Tap& tap) {
            visit(Tap{level.first_texel + tap.texel, tap.weight * weight});
          });
  }

  /// Clips a coordinate to the atlas if no face repeats it: a footprint does not reach over its border.
  [[nodiscard]] double placed(double coordinate) const {
    return repeats_ ? detail::wrapped(coordinate, 1) : std::clamp(coordinate, 0.0, 1.0);
  }

  LookupRule rule_;
  std::vector<MipLevel> levels_;
  bool repeats_ = false;
};
}  // namespace tapestry::raster
