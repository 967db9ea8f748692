#pragma once
#include <tapestry/raster/detail/texture_kinds.hpp>
#include <tapestry/raster/fragments.hpp>

namespace tapestry::raster::detail {
/// Sums of one band of rows for each face that it shows, in the order in which the faces are first met; found
/// by a hash table with open addressing, at most half full.
/// \tparam Moments  sums, 0 at first, with a member `face`
template <class Moments>
class BandMoments {
 public:
  [[nodiscard]] Moments& of(std::int32_t face) { return moments_[place_of(face)]; }
  /// Place of a face's sums in all().
  [[nodiscard]] std::size_t place_of(std::int32_t face) {
    if (face != last_face_) {
      last_face_ = face;
      last_ = slot_of(face);
    }
    return last_;
  }
  /// Removes all, and keeps the memory of a few thousand faces.
  void clear() {
    constexpr std::size_t most = 8192;
    if (table_.size() > most) *this = {};
    moments_.clear();
    std::fill(table_.begin(), table_.end(), 0);
    last_face_ = -1;
  }
  [[nodiscard]] const std::vector<Moments>& all() const { return moments_; }
  [[nodiscard]] std::vector<Moments>& all() { return moments_; }

 private:
  [[nodiscard]] std::uint32_t& slot_for(std::int32_t face) {
    std::size_t at = ((static_cast<std::uint32_t>(face) * 0x9E3779B1U) >> 7U) & (table_.size() - 1);
    while (table_[at] != 0 && moments_[table_[at] - 1].face != face) at = (at + 1) & (table_.size() - 1);
    return table_[at];
  }

  [[nodiscard]] std::size_t slot_of(std::int32_t face) {
    if (2 * moments_.size() >= table_.size()) {
      table_.assign(std::max<std::size_t>(256, 4 * table_.size()), 0);
      for (std::uint32_t i = 0; i < moments_.size(); ++i) slot_for(moments_[i].face) = i + 1;
    }
    std::uint32_t& slot = slot_for(face);
    if (slot == 0) {
      moments_.push_back({.face = face});
      slot = static_cast<std::uint32_t>(moments_.size());
    }
    return slot - 1;
  }

  std::vector<Moments> moments_;
  std::vector<std::uint32_t> table_;  // place in moments_ plus 1; 0 where empty
  std::int32_t last_face_ = -1;
  std::size_t last_ = 0;
};

/// Sums over fragments of a face, σ_j being ∂colour/∂b_j times the adjoint of the colour.
struct FaceMoments {
  std::int32_t face;
  double light = 0;                              ///< derivative with respect to its light
  std::array<std::array<double, 3>, 3> first{};  ///< Σ b_k·σ_j, [k][j]
  std::array<double, 3> second{};                ///< Σ b_k·(Σ_j σ_j·b_j)
  std::array<double, 3> place{};                 ///< Σ coverage·b

  /// Sets the place, and adds to the derivatives, for σ_j = Σ_c value_c·slope[c][j] and a colour of
  /// Σ_k b_k·tint[c][k] before the light, from the sums of RasterKernels::add_moments().
  void set(const std::array<std::array<double, 8>, 4>& sums, const ColourSlope<3>& slope,
           const ColourSlope<3>& tint) {
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& [whole, x, y, xx, xy, yy, unused_6, unused_7] = sums[c];
      const double z = whole - x - y, xz = x - xx - xy, yz = y - xy - yy, zz = z - xz - yz;
      const std::array<std::array<double, 3>, 3> product{{{xx, xy, xz}, {xy, yy, yz}, {xz, yz, zz}}};
      const std::array<double, 3> single{x, y, z};
      light += x * tint[c][0] + y * tint[c][1] + z * tint[c][2];
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t j = 0; j < 3; ++j) {
          first[k][j] += single[k] * slope[c][j];
          second[k] += product[k][j] * slope[c][j];
        }
    }
    place = {sums[3][1], sums[3][2], sums[3][0] - sums[3][1] - sums[3][2]};
  }

  /// Multiplies the sums that are derivatives.
  void scale(double factor) {
    light *= factor;
    for (std::size_t k = 0; k < 3; ++k) {
      for (double& sum : first[k]) sum *= factor;
      second[k] *= factor;
    }
  }
};

class MomentSums {
 public:
  /// Removes all, and keeps at most 2 MiB of memory.
  void clear() {
    constexpr std::size_t most = 8192;  // faces
    faces_.clear();
    sums_.clear();
    if (sums_.capacity() > most) sums_.shrink_to_fit();
    batch_.size = 0;
    face_ = -1;
  }

  [[nodiscard]] std::size_t face_count() const { return sums_.size(); }

  /// Adds the contribution of one fragment; its light's part only if the face turns in it.
  /// \param adjoint  of the pixel's three values
  template <std::floating_point T, class Colour>
  void add(const Colour& colour, const Fragment& fragment, const T* adjoint, bool is_turning) {
    if (batch_.size == MomentBatch::most) add_batch();
    if (fragment.face != face_) begin(colour, fragment.face);
    const std::size_t i = batch_.size++;
    const std::array<double, 3>& b = fragment.barycentric;
    std::array<double, 3> weight;
    for (std::size_t c = 0; c < 3; ++c) weight[c] = fragment.coverage * static_cast<double>(adjoint[c]);
    if (is_turning && !is_flat_) {  // else visit() finds the light's part
      const auto tinted = colour.tinted(fragment.face, b);
      for (std::size_t c = 0; c < 3; ++c) faces_.all()[place_].light += weight[c] * tinted[c];
    }
    if (!is_flat_) weight = colour.slope_adjoint(fragment.face, b, weight);
    batch_.slot[i] = static_cast<std::uint32_t>(place_);
    batch_.value[i] = {weight[0], weight[1], weight[2], fragment.coverage};
    batch_.barycentric[i] = {b[0], b[1]};
  }

  /// Calls use(moments) for each face, in the order in which the faces were first met.
  template <class Colour, class Use>
  void visit(const Colour& colour, bool is_turning, Use use) {
    constexpr ColourSlope<3> unit{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    add_batch();
    for (std::size_t i = 0; i < sums_.size(); ++i) {
      const auto& [face, light] = faces_.all()[i];
      FaceMoments moments{face, light};
      const bool is_flat = colour.has_constant_slope(face);
      ColourSlope<3> tint{};
      for (std::size_t k = 0; is_turning && is_flat && k < 3; ++k) {
        const auto at_corner = colour.tinted(face, unit[k]);
        for (std::size_t c = 0; c < 3; ++c) tint[c][k] = at_corner[c];
      }
      moments.set(sums_[i], is_flat ? colour.slope(face, {}) : unit, tint);
      use(moments);
    }
  }

 private:
  struct FaceLight {
    std::int32_t face;
    double light = 0;
  };

  template <class Colour>
  void begin(const Colour& colour, std::int32_t face) {
    face_ = face;
    place_ = faces_.place_of(face);
    is_flat_ = colour.has_constant_slope(face);
    if (place_ == sums_.size()) sums_.push_back({});
  }

  void add_batch() {
    raster_kernels().add_moments(batch_, sums_.data());
    batch_.size = 0;
  }

  std::int32_t face_ = -1;  // of the last fragment
  std::size_t place_ = 0;
  bool is_flat_ = false;  // whether its colour has one slope; values are then adjoints of colours, not σ
  BandMoments<FaceLight> faces_;
  std::vector<std::array<std::array<double, 8>, 4>> sums_;
  MomentBatch batch_;
};
}  // namespace tapestry::raster::detail
