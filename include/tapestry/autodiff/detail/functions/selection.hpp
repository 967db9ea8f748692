#pragma once
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Abs {
  static constexpr bool is_cheap = true;
  static constexpr bool skips_zero = true;
  static auto value(auto x) { return value_at_kink(x == 0, decltype(x)(abs(x)), x); }
  static auto partial(auto x, auto) { return slope_at_kink(x == 0, decltype(x)(sign(x))); }
};
/// Takes x or y with its derivative, as Choice::takes_x(x, y) decides, also at a tie.
template <class Choice>
struct Selection {
  static constexpr bool is_cheap = true;
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) {
    if constexpr (DualNumber<decltype(x)>)
      if (x == y) [[unlikely]]
        note_kink(false);
    return Choice::takes_x(x, y) ? x : y;
  }
  static auto partial_x(auto x, auto y, auto) { return decltype(x)(Choice::takes_x(x, y) ? 1 : 0); }
  static auto partial_y(auto x, auto y, auto) { return decltype(x)(Choice::takes_x(x, y) ? 0 : 1); }
  static auto pass_x(auto g, auto x, auto y) { return Choice::takes_x(x, y) ? g : decltype(g)(0); }
  static auto pass_y(auto g, auto x, auto y) { return Choice::takes_x(x, y) ? decltype(g)(0) : g; }
};
struct AtLeast : Selection<AtLeast> {
  static bool takes_x(auto x, auto y) { return either(x >= y, x != x); }
};
struct AtMost : Selection<AtMost> {
  static bool takes_x(auto x, auto y) { return either(x <= y, x != x); }
};
struct AtLeastNumber : Selection<AtLeastNumber> {
  static bool takes_x(auto x, auto y) { return either(x >= y, y != y); }
};
struct AtMostNumber : Selection<AtMostNumber> {
  static bool takes_x(auto x, auto y) { return either(x <= y, y != y); }
};
/// The same, but at a tie each side has one half of the derivative: in either order, max(x, y) + min(x, y)
/// has the derivatives of x + y.
template <class Operation, class Choice>
struct SharedSelection : Choice {
  template <class T>
  static T value(const T& x, const T& y) {
    if constexpr (DualNumber<T>) {
      if (x == y) [[unlikely]] {
        note_kink(false);
        return dual_binary<Operation, T>(x, y);
      }
    }
    return Choice::value(x, y);
  }
  static auto partial_x(auto x, auto y, auto) {
    return decltype(x)(Choice::takes_x(x, y) ? (x == y ? 0.5F : 1.0F) : 0.0F);
  }
  static auto partial_y(auto x, auto y, auto) {
    return decltype(x)(Choice::takes_x(x, y) ? (x == y ? 0.5F : 0.0F) : 1.0F);
  }
  static auto pass_x(auto g, auto x, auto y) { return x == y ? g / 2 : Choice::pass_x(g, x, y); }
  static auto pass_y(auto g, auto x, auto y) { return x == y ? g / 2 : Choice::pass_y(g, x, y); }
};
struct Max : SharedSelection<Max, AtLeast> {};
struct Min : SharedSelection<Min, AtMost> {};
struct Fmax : SharedSelection<Fmax, AtLeastNumber> {};
struct Fmin : SharedSelection<Fmin, AtMostNumber> {};
struct Fdim {
  static constexpr bool is_cheap = true;
  static constexpr bool skips_zero = true;
  static bool is_kink(auto x, auto y) { return x == y; }
  static auto value(std::floating_point auto x, auto y) { return x <= y ? decltype(x)(0) : x - y; }
  static auto value(DualNumber auto x, auto y) { return dual_binary<Fdim, decltype(x)>(x, y); }
  static auto partial_x(auto x, auto y, auto) { return decltype(x)(x < y ? 0 : 1); }
  static auto partial_y(auto x, auto y, auto) { return decltype(x)(x < y ? 0 : -1); }
};
struct Fmod {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return fmod(x, y); }
  static auto partial_x(auto x, auto, auto) { return decltype(x)(1); }
  static auto partial_y(auto x, auto y, auto rest) { return decltype(x)(-round((x - rest) / y)); }
};
struct Remainder {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return remainder(x, y); }
  static auto partial_x(auto x, auto y, auto rest) { return Fmod::partial_x(x, y, rest); }
  static auto partial_y(auto x, auto y, auto rest) { return Fmod::partial_y(x, y, rest); }
};
struct Copysign {
  static constexpr bool is_cheap = true;
  static constexpr bool skips_zero = true;
  static bool is_kink(auto x, auto y) { return x == 0 || y == 0; }
  static auto value(auto x, auto y) { return copysign(x, y); }
  static auto partial_x(auto x, auto y, auto) { return decltype(x)(signbit(x) == signbit(y) ? 1 : -1); }
  static auto partial_y(auto x, auto, auto) { return decltype(x)(0); }
};
}  // namespace detail

/// |x|; its derivative at 0 is taken as 0.
[[nodiscard]] auto abs(const detail::Argument auto& x) { return detail::make_unary<detail::Abs>(x); }
[[nodiscard]] auto fabs(const detail::Argument auto& x) { return detail::make_unary<detail::Abs>(x); }

/// The larger one, and its derivative. At a tie each has one half of it. A NaN on either side gives NaN. The
/// argument not taken receives no gradient, whatever is upstream. std::max takes two variables, but not a
/// variable and a number: write max(x, 0.0) and clamp(x, 0.0, 1.0) without std::.
template <int = 0, class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto max(const X& x, const Y& y) { return detail::make_binary<detail::Max>(x, y, "max"); }

/// The smaller one; otherwise as max().
template <int = 0, class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto min(const X& x, const Y& y) { return detail::make_binary<detail::Min>(x, y, "min"); }

/// Like max(), but a NaN on one side returns the other.
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto fmax(const X& x, const Y& y) { return detail::make_binary<detail::Fmax>(x, y, "fmax"); }

/// Like min(), but a NaN on one side returns the other.
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto fmin(const X& x, const Y& y) { return detail::make_binary<detail::Fmin>(x, y, "fmin"); }

/// x held within [low, high]. A NaN stays NaN. The derivative by x is 1 on the closed interval and
/// for a NaN, and 0 outside.
template <int = 0, Differentiable X, Number N>
[[nodiscard]] auto clamp(const X& x, N low, N high) {
  return detail::make_binary<detail::AtMost>(detail::make_binary<detail::AtLeast>(x, low), high);
}

/// max(x − y, 0), and 0 of two equal infinities; at x = y it has the derivatives of x − y.
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto fdim(const X& x, const Y& y) { return detail::make_binary<detail::Fdim>(x, y, "fdim"); }

/// Like std::fmod; the derivatives are those between its jumps: 1, and −trunc(x / y).
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto fmod(const X& x, const Y& y) { return detail::make_binary<detail::Fmod>(x, y, "fmod"); }

/// Like std::remainder; the derivatives are those between its jumps: 1, and −(the integer nearest to x / y).
template <class X, detail::Arguments<X> Y>
[[nodiscard]] auto remainder(const X& x, const Y& y) {
  return detail::make_binary<detail::Remainder>(x, y, "remainder");
}

/// |x| with the sign of y, −0 being negative. The derivative by x is 1 where the signs agree and −1 where
/// they do not; the derivative by y, between its jumps, is 0.
template <class X, detail::Arguments<X> Y>
[[nodiscard]] auto copysign(const X& x, const Y& y) {
  return detail::make_binary<detail::Copysign>(x, y, "copysign");
}

/// Functions constant between jumps have no derivative to record and return a plain number.
template <int = 0, Differentiable X>
[[nodiscard]] auto sign(const X& x) {
  return sign(detail::base_value(x));
}
[[nodiscard]] auto floor(const Differentiable auto& x) { return std::floor(detail::base_value(x)); }
[[nodiscard]] auto ceil(const Differentiable auto& x) { return std::ceil(detail::base_value(x)); }
[[nodiscard]] auto round(const Differentiable auto& x) { return std::round(detail::base_value(x)); }
[[nodiscard]] auto rint(const Differentiable auto& x) { return std::rint(detail::base_value(x)); }
[[nodiscard]] auto nearbyint(const Differentiable auto& x) { return std::nearbyint(detail::base_value(x)); }
[[nodiscard]] auto trunc(const Differentiable auto& x) { return std::trunc(detail::base_value(x)); }

[[nodiscard]] bool isfinite(const Differentiable auto& x) { return std::isfinite(detail::base_value(x)); }
[[nodiscard]] bool isinf(const Differentiable auto& x) { return std::isinf(detail::base_value(x)); }
[[nodiscard]] bool isnan(const Differentiable auto& x) { return std::isnan(detail::base_value(x)); }
[[nodiscard]] bool signbit(const Differentiable auto& x) { return std::signbit(detail::base_value(x)); }
}  // namespace tapestry
