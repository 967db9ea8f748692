#pragma once
#include <tapestry/autodiff/detail/arrays/elementwise.hpp>
#include <tapestry/core/vector_exp.hpp>

namespace tapestry {
/// How arrays compute exp:
///   library  as std::exp, an element at a time
///   vector   a vector at a time, which takes an eighth of the time; relative error below 2 ε. It gives 0
///   below −707.5, in float below −86.8; infinities and NaN are as in std::exp.
///
/// Fewer terms (error 4e-7) take 0.51 ns an element instead of 0.68 in double, and 0.25 instead of 0.27 in
/// float: too small a gain for a third policy.
enum class Exponential { library, vector };

namespace detail {
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

/// exp of each element, computed as Policy states; the derivative is the value, with its error.
template <Exponential Policy, DifferentiableArray X>
[[nodiscard]] auto exp(const X& x) {
  if constexpr (Policy == Exponential::library) {
    return detail::array_unary<detail::Exp>(x);
  } else {
    return detail::array_unary<detail::VectorExp>(x);
  }
}
}  // namespace tapestry
