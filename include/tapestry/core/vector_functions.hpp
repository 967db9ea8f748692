#pragma once
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <tapestry/core/vector_exp.hpp>

namespace tapestry::detail {

// Functions of double without a branch, a table or a fused product: loops of them are loops of vectors, and
// have the same bits whatever the vectors' length. Unlike vector_exp() they are right for all arguments:
// denormal numbers, overflow, infinities and NaN come out as from the C library, and −0 keeps its sign.
// Errors are in units of the last place, by long double.

/// exp x = first · second · (1 + rest): two powers of 2, whose product may be no normal number, and
/// exp r − 1 for |r| ≤ ln 2 / 2.
struct SplitExponential {
  double rest, first, second;

  [[gnu::always_inline]] explicit SplitExponential(double x) {
    using Format = ExponentialFormat<double>;
    constexpr double least = -746, most = 710;  // 0 and infinity from there on
    const double below = x > most ? most : x;
    const double within = below < least ? least : below;
    const double whole = within * 1.4426950408889634 + Format::round_to_integer;
    const double k = whole - Format::round_to_integer;
    const double half = k * 0.5 + Format::round_to_integer;
    const double other_half = (k - (half - Format::round_to_integer)) + Format::round_to_integer;
    const double high = within - k * Format::ln2_high;
    const double low = k * Format::ln2_low;
    const double r = high - low;
    rest = high - (low - r * r * horner<0>(ExponentialTerms<double>::terms, r));
    first = power_of_two(half);
    second = power_of_two(other_half);
  }

 private:
  /// \param whole  an integer, with Format::round_to_integer added
  [[nodiscard, gnu::always_inline]] static double power_of_two(double whole) {
    using Format = ExponentialFormat<double>;
    return std::bit_cast<double>((std::bit_cast<std::uint64_t>(whole) + Format::bias)
                                 << Format::mantissa_bits);
  }
};

/// exp x, to 1.0.
[[nodiscard, gnu::always_inline]] inline double branchless_exp(double x) {
  const SplitExponential e(x);
  return (1 + e.rest) * e.first * e.second;
}

/// To 2.5: tanh x = (1 − e) / (1 + e), e = exp(−2 |x|); from ½ on, 1 − 2 e / (1 + e).
[[nodiscard, gnu::always_inline]] inline double branchless_tanh(double x) {
  const SplitExponential exponential(-2 * std::abs(x));
  const double power = exponential.first * exponential.second;
  const double e = (1 + exponential.rest) * power;
  const double one_less = (1 - power) - exponential.rest * power;
  const bool is_large = e < 1.0 / 3;
  const double ratio = (is_large ? e + e : one_less) / (1 + e);
  return std::copysign(is_large ? 1 - ratio : ratio, x);
}

/// log(2^exponent · x) + rest, where x = 2^k · m, ½ ≤ m² < 2, is of the normal range.
[[nodiscard, gnu::always_inline]] inline double log_of_normal(double x, double exponent, double rest) {
  // log m = 2 artanh s, s = (m − 1) / (m + 1), as 2 s + s · z · (2/3 + 2/5 z + …), z = s²; interpolated at
  // the Chebyshev nodes, with an error of 4.3e-18 of the whole.
  constexpr double terms[] = {0x1.5555555555558p-1, 0x1.99999999952e2p-2, 0x1.2492492df148dp-2,
                              0x1.c71c62e5800a1p-3, 0x1.7462b4ab2ef6bp-3, 0x1.39fe606542ddep-3,
                              0x1.2b584aae78a57p-3};
  using Format = ExponentialFormat<double>;
  constexpr std::uint64_t one = std::bit_cast<std::uint64_t>(1.0);
  constexpr std::uint64_t root_of_half = 0x3fe6a09e00000000;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) + (one - root_of_half);
  const std::uint64_t mantissa = bits & ((std::uint64_t(1) << Format::mantissa_bits) - 1);
  const double m = std::bit_cast<double>(mantissa + root_of_half);
  constexpr double two_52 = 0x1p52;  // its last bits count ones
  const double k =
      std::bit_cast<double>((bits >> Format::mantissa_bits) | std::bit_cast<std::uint64_t>(two_52)) -
      (two_52 + static_cast<double>(Format::bias)) + exponent;
  const double f = m - 1;
  const double half_square = 0.5 * f * f;
  const double s = f / (2 + f);
  const double z = s * s;
  // 2 s = f − s f, and s f = f²/2 − s f²/2: what is added to f, the largest, is small.
  const double tail = s * (half_square + z * horner<0>(terms, z)) + (k * Format::ln2_low + rest);
  return k * Format::ln2_high + (f - (half_square - tail));
}

/// log x, to 0.9: −∞ at 0, and NaN below.
[[nodiscard, gnu::always_inline]] inline double branchless_log(double x) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double scaled = x * 0x1p54;
  const bool is_small = x < std::numeric_limits<double>::min();
  const double result = log_of_normal(is_small ? scaled : x, is_small ? -54.0 : 0.0, 0);
  const double not_positive = x == 0 ? -infinity : std::numeric_limits<double>::quiet_NaN();
  const double positive = x < infinity ? result : infinity;
  return x > 0 ? positive : not_positive;
}

/// log(1 + x), to 0.9.
[[nodiscard, gnu::always_inline]] inline double branchless_log1p(double x) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double u = 1 + x;
  const double lost = (x - (u - 1)) / u;
  const double result = log_of_normal(u, 0, lost);
  const double not_positive = u == 0 ? -infinity : std::numeric_limits<double>::quiet_NaN();
  const double positive = u < infinity ? result : infinity;
  const double of_all = u > 0 ? positive : not_positive;
  return x == 0 ? x : of_all;
}

}  // namespace tapestry::detail
