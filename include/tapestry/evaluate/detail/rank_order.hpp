#pragma once
#include <numeric>
#include <tapestry/core/platform/memory.hpp>

namespace tapestry::evaluate::detail {
/// Sorts numbers of values by radix, in three rounds of 11 bits.
class RankOrder {
 public:
  /// Numbers of the values, `count` at most 2³², in ascending order; of equal values the first comes first.
  RankOrder(const float* values, std::size_t count) : entries_(count) {
    std::array<std::array<std::size_t, buckets>, rounds> begins{};
    for (std::size_t i = 0; i < count; ++i) {
      entries_[i] = {key_of(values[i]), static_cast<std::uint32_t>(i)};
      for (std::size_t round = 0; round < rounds; ++round) ++begins[round][digit(entries_[i], round)];
    }
    Entries sorted(count);
    for (std::size_t round = 0; round < rounds; ++round) {
      auto& next = begins[round];
      std::exclusive_scan(next.begin(), next.end(), next.begin(), std::size_t{0});
      for (const Entry& entry : entries_) sorted[next[digit(entry, round)]++] = entry;
      std::swap(entries_, sorted);
    }
  }

  [[nodiscard]] std::size_t operator[](std::size_t rank) const { return entries_[rank].number; }

 private:
  struct Entry {
    std::uint32_t key, number;
  };
  using Entries = std::vector<Entry, platform::PageAllocator<Entry>>;
  static constexpr std::size_t rounds = 3, bits = 11, buckets = std::size_t(1) << bits;

  static std::uint32_t key_of(float value) {
    const auto pattern = std::bit_cast<std::uint32_t>(value + 0.0F);  // of -0 that of 0
    constexpr std::uint32_t sign = std::uint32_t(1) << 31U;
    return (pattern & sign) != 0 ? ~pattern : pattern | sign;
  }
  static std::size_t digit(const Entry& entry, std::size_t round) {
    return (entry.key >> (bits * round)) % buckets;
  }

  Entries entries_;
};
}  // namespace tapestry::evaluate::detail
