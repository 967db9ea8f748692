#pragma once
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tapestry/autodiff/arrays/elementwise.hpp>
#include <tapestry/autodiff/arrays/expression/block_loop.hpp>
#include <type_traits>

namespace tapestry {

/// How arrays compute exp.
///   library  as std::exp, an element at a time
///   vector   a vector at a time, which takes an eighth of the time; relative error below 2 ε. Below −707.5,
///            of float below −86.8, it gives 0; infinities and NaN are as ever.
///
/// Fewer terms (error 4e-7) take 0.51 ns an element in place of 0.68 in double, and 0.25 in place of 0.27 in
/// float: too little for a third way.
enum class Exponential { library, vector };

namespace detail {

/// (exp r − 1 − r) / r² for |r| ≤ ln 2 / 2, interpolated at the Chebyshev nodes; behind each the largest
/// error of the whole, relative to exp r.
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
  static constexpr double least = -707.5, most = 709.782712893384;
};
template <>
struct ExponentialFormat<float> {
  using Bits = std::uint32_t;
  static constexpr int mantissa_bits = 23;
  static constexpr Bits bias = 127;
  static constexpr float round_to_integer = 0x1.8p23F;
  static constexpr float ln2_high = 0x1.62e400p-1F;
  static constexpr float ln2_low = 0x1.7f7d1cp-20F;
  static constexpr float least = -86.8F, most = 88.72283F;
};

/// terms[I] + terms[I + 1] · r + …
template <std::size_t I, class T, std::size_t Count>
[[nodiscard, gnu::always_inline]] inline T horner(const T (&terms)[Count], T r) {
  if constexpr (I + 1 == Count) {
    return terms[I];
  } else {
    return horner<I + 1>(terms, r) * r + terms[I];
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
  // 2^(k − 1), so that it is finite at the largest arguments; twice the power makes up for it.
  const T scale =
      std::bit_cast<T>((std::bit_cast<Bits>(shifted) + (Format::bias - 1)) << Format::mantissa_bits);
  const T result = (power + power) * scale;
  const T not_above = x > Format::most ? std::numeric_limits<T>::infinity() : result;
  return x < Format::least ? T(0) : not_above;
}

struct VectorExp {
  static constexpr bool is_cheap = true;
  template <class T>
  [[gnu::always_inline]] static T value(T x) {
    return vector_exp(x);
  }
  template <class T>
  [[gnu::always_inline]] static T partial(T, T exp_x) {
    return exp_x;
  }
};

/// to[i] = exp(from[i] − shift), for elements `step` apart.
template <Exponential Policy, class T>
void exponentials(const T* from, T* to, T shift, std::size_t count, std::size_t step) {
  if constexpr (Policy == Exponential::library) {
    for (std::size_t i = 0; i < count; ++i) to[i * step] = std::exp(from[i * step] - shift);
  } else if (step == 1) {
    struct Body {
      const T* from;
      T* to;
      T shift;
      [[gnu::always_inline]] void operator()(std::size_t i) const { to[i] = vector_exp(from[i] - shift); }
    };
    for_block(count, Body{from, to, shift});
  } else {
    for (std::size_t i = 0; i < count; ++i) to[i * step] = vector_exp(from[i * step] - shift);
  }
}
}  // namespace detail

/// exp of each element in the way that Policy says; the derivative is the value, error and all.
template <Exponential Policy, DifferentiableArray X>
[[nodiscard]] auto exp(const X& x) {
  if constexpr (Policy == Exponential::library) {
    return detail::array_unary<detail::Exp>(x);
  } else {
    return detail::array_unary<detail::VectorExp>(x);
  }
}

}  // namespace tapestry
