#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace tapestry::detail {
/// (exp r − 1 − r) / r² for |r| ≤ ln 2 / 2, interpolated at the Chebyshev nodes; behind each the largest
/// error relative to exp r.
template <class T>
struct ExponentialTerms;
template <>
struct ExponentialTerms<double> {  // 1.7e-17
  static constexpr double terms[] = {0x1.0000000000001p-1,  0x1.5555555555556p-3,  0x1.5555555553d63p-5,
                                     0x1.11111111109b3p-7,  0x1.6c16c1788bd90p-10, 0x1.a01a01a7c41d5p-13,
                                     0x1.a019b90d2ae7ap-16, 0x1.71de0dae63bb3p-19, 0x1.289185613a3d6p-22,
                                     0x1.af38a9b0ec855p-26};
};
template <>
struct ExponentialTerms<float> {  // 1.0e-8
  static constexpr float terms[] = {0x1.000000p-1F, 0x1.5554dcp-3F, 0x1.55551ap-5F, 0x1.120b6ep-7F,
                                    0x1.6d1109p-10F};
};

template <class T>
struct ExponentialFormat;
template <>
struct ExponentialFormat<double> {
  using Bits = std::uint64_t;
  static constexpr int mantissa_bits = 52;
  static constexpr Bits bias = 1023;
  static constexpr double round_to_integer = 0x1.8p52;      // added, it leaves an integer in the last bits
  static constexpr double ln2_high = 0x1.62e42fee00000p-1;  // with zeros for the integer's digits
  static constexpr double ln2_low = 0x1.a39ef35793c76p-33;
  static constexpr double least = -707.5, most = 709.782712893384, largest_finite = 709.0;
};
template <>
struct ExponentialFormat<float> {
  using Bits = std::uint32_t;
  static constexpr int mantissa_bits = 23;
  static constexpr Bits bias = 127;
  static constexpr float round_to_integer = 0x1.8p23F;
  static constexpr float ln2_high = 0x1.62e400p-1F;
  static constexpr float ln2_low = 0x1.7f7d1cp-20F;
  static constexpr float least = -86.8F, most = 88.72283F, largest_finite = 88.0F;
};

/// terms[Term] + terms[Term + 1] · r + …
template <std::size_t Term, class T, std::size_t Count>
[[nodiscard, gnu::always_inline]] inline T horner(const T (&terms)[Count], T r) {
  if constexpr (Term + 1 == Count) {
    return terms[Term];
  } else {
    return horner<Term + 1>(terms, r) * r + terms[Term];
  }
}

/// exp x without a branch, so that loops of it are loops of vectors: x = k · ln 2 + r, exp x = 2^k · exp r.
template <class T>
[[nodiscard, gnu::always_inline]] inline T vector_exp(T x) {
  using Format = ExponentialFormat<T>;
  using Bits = typename Format::Bits;
  const auto& terms = ExponentialTerms<T>::terms;
  const T below = x > Format::most ? Format::most : x;
  const T within = below < Format::least ? Format::least : below;
  const T shifted = within * static_cast<T>(1.4426950408889634) + Format::round_to_integer;
  const T k = shifted - Format::round_to_integer;
  const T r = (within - k * Format::ln2_high) - k * Format::ln2_low;
  const T tail = horner<0>(terms, r);
  const T power = T(1) + (r + r * r * tail);
  // 2^(k − 1), so that it is finite at the largest arguments; doubling the power corrects that.
  const T scale =
      std::bit_cast<T>((std::bit_cast<Bits>(shifted) + (Format::bias - 1)) << Format::mantissa_bits);
  const T result = (power + power) * scale;
  const T not_above = x > Format::most ? std::numeric_limits<T>::infinity() : result;
  return x < Format::least ? T(0) : not_above;
}

/// log x of a normal number without a branch: x = 2^k · m with m from √½ to √2, and log m = 2 artanh s with
/// s = (m − 1)/(m + 1), by its series. Errs by 1e-7 of the larger of 1 and log x.
[[nodiscard, gnu::always_inline]] inline float vector_log(float x) {
  using Format = ExponentialFormat<float>;
  constexpr std::uint32_t root_half = 0x3F3504F3U, one = 0x3F800000U, mantissa = 0x7FFFFFU;
  constexpr float terms[] = {1.0F / 3, 1.0F / 5, 1.0F / 7, 1.0F / 9};
  const std::uint32_t pattern = std::bit_cast<std::uint32_t>(x) + (one - root_half);
  const auto k = static_cast<float>(static_cast<std::int32_t>(pattern >> 23U) - 127);
  const auto m = std::bit_cast<float>((pattern & mantissa) + root_half);
  const float s = (m - 1) / (m + 1), square = s * s;
  return k * Format::ln2_high + (k * Format::ln2_low + 2 * (s + s * square * horner<0>(terms, square)));
}

/// |x|.
template <class T>
[[nodiscard, gnu::always_inline]] inline T magnitude(T x) {
  return x < 0 ? -x : x;
}

/// σ(x) = 1/(1 + e^−x), without overflow at either end.
template <class T>
[[nodiscard, gnu::always_inline]] inline T vector_sigmoid(T x) {
  const T e = vector_exp(-magnitude(x));
  return (x < 0 ? e : T(1)) / (1 + e);
}

/// σ(x) · σ(−x). Computed from σ(x) alone, it would lose all digits where σ(x) is close to 1.
template <class T>
[[nodiscard, gnu::always_inline]] inline T vector_sigmoid_slope(T x) {
  const T e = vector_exp(-magnitude(x));
  return e / ((1 + e) * (1 + e));
}
}  // namespace tapestry::detail
