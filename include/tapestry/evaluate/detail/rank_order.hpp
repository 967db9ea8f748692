#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <numeric>
#include <vector>

namespace tapestry::evaluate::detail {

/// Sorts numbers of values by radix: by the values in single precision, whose order is that of the doubles,
/// in three rounds of 11 bits; then those by the doubles that are equal there.
class RankOrder {
 public:
  /// Numbers of the values, at most 2³², in ascending order; of equal values the first comes first.
  explicit RankOrder(const std::vector<double>& values) : entries_(values.size()) {
    std::array<std::array<std::size_t, buckets>, rounds> begins{};
    for (std::size_t i = 0; i < values.size(); ++i) {
      entries_[i] = {key_of(values[i]), static_cast<std::uint32_t>(i)};
      for (std::size_t round = 0; round < rounds; ++round) ++begins[round][digit(entries_[i], round)];
    }
    std::vector<Entry> sorted(entries_.size());
    for (std::size_t round = 0; round < rounds; ++round) {
      auto& next = begins[round];
      std::exclusive_scan(next.begin(), next.end(), next.begin(), std::size_t{0});
      for (const Entry& entry : entries_) sorted[next[digit(entry, round)]++] = entry;
      std::swap(entries_, sorted);
    }
    const auto is_before = [&](const Entry& a, const Entry& b) {
      return values[a.number] < values[b.number] ||
             (!(values[b.number] < values[a.number]) && a.number < b.number);
    };
    for (auto first = entries_.begin(); first != entries_.end();) {
      auto end = std::next(first);
      while (end != entries_.end() && end->key == first->key) ++end;
      if (end - first > 1) std::sort(first, end, is_before);
      first = end;
    }
  }

  [[nodiscard]] std::size_t operator[](std::size_t rank) const { return entries_[rank].number; }

 private:
  struct Entry {
    std::uint32_t key, number;
  };
  static constexpr std::size_t rounds = 3, bits = 11, buckets = std::size_t(1) << bits;

  static std::uint32_t key_of(double value) {
    const auto pattern = std::bit_cast<std::uint32_t>(static_cast<float>(value) + 0.0F);  // of -0 that of 0
    constexpr std::uint32_t sign = std::uint32_t(1) << 31U;
    return (pattern & sign) != 0 ? ~pattern : pattern | sign;
  }
  static std::size_t digit(const Entry& entry, std::size_t round) {
    return (entry.key >> (bits * round)) % buckets;
  }

  std::vector<Entry> entries_;
};

}  // namespace tapestry::evaluate::detail
