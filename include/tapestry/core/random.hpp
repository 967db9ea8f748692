#pragma once
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/detail/supported_target.hpp>
#include <utility>

namespace tapestry {
/// Seeded random numbers, the same on every platform. The whole state is one 64-bit word, so a
/// checkpoint can hold it. Source: Steele, Lea, Flood, "Fast splittable pseudorandom number
/// generators" (2014), the SplitMix64 mixer.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  /// The generator's whole state.
  [[nodiscard]] std::uint64_t state() const { return state_; }

  /// 64 uniformly distributed bits.
  std::uint64_t bits() {
    state_ += 0x9E3779B97F4A7C15ULL;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27U)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31U);
  }

  /// Uniform in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11U) * 0x1.0p-53; }

  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  /// Uniform in 0 … count − 1; count must not be 0. Its bias, below count / 2⁶⁴, is not corrected.
  std::size_t index(std::size_t count) { return static_cast<std::size_t>(upper_half(bits(), count)); }

  /// True with the given probability.
  bool chance(double probability) { return uniform() < probability; }

  /// Normal with mean 0 and variance 1 (Box and Muller, the cosine half).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(6.283185307179586 * uniform());
  }

  /// A generator for a sub-task: the same parent state and stream give the same child.
  [[nodiscard]] Random fork(std::uint64_t stream) const {
    Random mixer(state_ ^ (stream * 0xD1342543DE82EF95ULL + 0x2545F4914F6CDD1DULL));
    return Random(mixer.bits());
  }

  /// Fisher-Yates shuffle of a random-access container.
  template <class Container>
  void shuffle(Container& items) {
    for (std::size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[index(i)]);
  }

 private:
  /// Bits 64 to 127 of a · b, by products of halves: not every machine has integers of 128 bits.
  [[nodiscard]] static std::uint64_t upper_half(std::uint64_t a, std::uint64_t b) {
    const std::uint64_t low_mask = 0xFFFFFFFFU;
    const std::uint64_t middle = (a >> 32U) * (b & low_mask) + ((a & low_mask) * (b & low_mask) >> 32U);
    const std::uint64_t other = (a & low_mask) * (b >> 32U) + (middle & low_mask);
    return (a >> 32U) * (b >> 32U) + (middle >> 32U) + (other >> 32U);
  }

  std::uint64_t state_;
};
}  // namespace tapestry
