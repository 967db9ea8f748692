#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

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

}  // namespace tapestry::raster::detail
