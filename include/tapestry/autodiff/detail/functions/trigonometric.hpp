#pragma once
#include <tapestry/autodiff/detail/functions/hyperbolic.hpp>
#include <tapestry/autodiff/detail/functions/power.hpp>

namespace tapestry {
namespace detail {
struct Sin {
  static auto value(auto x) { return sin(x); }
  static auto partial(auto x, auto) { return cos(x); }
};
struct Cos {
  static auto value(auto x) { return cos(x); }
  static auto partial(auto x, auto) { return -sin(x); }
};
struct Tan {
  static auto value(auto x) { return tan(x); }
  static auto partial(auto, auto tan_x) { return 1 + tan_x * tan_x; }
};
struct Asin {
  static bool is_kink(auto x) { return x == 1 || x == -1; }
  static auto value(auto x) { return asin(x); }
  static auto partial(auto x, auto) { return 1 / std::sqrt((1 - x) * (1 + x)); }
  static auto curvature(auto x, auto, auto slope) { return x * slope * slope_of<Atanh>(x, slope); }
};
struct Acos {
  static bool is_kink(auto x) { return Asin::is_kink(x); }
  static auto value(auto x) { return acos(x); }
  static auto partial(auto x, auto acos_x) { return -slope_of<Asin>(x, acos_x); }
};
struct Atan {
  static auto value(auto x) { return atan(x); }
  static auto partial(auto x, auto) {
    if (abs(x) > Base<decltype(x)>(0x1p60F)) return 1 / x / x;  // 1 is lost beside x², and x² would overflow
    return 1 / (1 + x * x);
  }
};
/// x / (x² + y²), 0 at the origin and far away.
struct LegBySquaredRadius {
  template <std::floating_point T>
  static T value(T x, T y) {
    const T radius = std::hypot(x, y);
    if (radius == 0) return T(0);
    const T scale = scale_of_length(radius);
    if (scale == 1) return x / radius / radius;
    const T scaled = std::hypot(scale * x, scale * y);
    return std::isinf(scaled) ? T(0) : scale * x / scaled / scaled * scale;
  }
  static auto value(DualNumber auto x, auto y) { return dual_binary<LegBySquaredRadius, decltype(x)>(x, y); }
  /// (y − x) (y + x) by the fourth power of the radius.
  static auto partial_x(auto x, auto y, auto) {
    const auto radius = hypot(x, y);
    if (radius == 0 || isinf(radius)) return decltype(x)(0);
    return 4 * ((y / 2 - x / 2) / radius) * ((y / 2 + x / 2) / radius) / radius / radius;
  }
  static auto partial_y(auto x, auto y, auto) {
    const auto radius = hypot(x, y);
    if (radius == 0 || isinf(radius)) return decltype(x)(0);
    return -2 * (x / radius) * (y / radius) / radius / radius;
  }
};
struct Atan2 {
  static constexpr bool skips_zero = true;
  static auto value(auto y, auto x) {
    return value_at_kink(y == 0 && x == 0, decltype(x)(atan2(y, x)), y, x);
  }
  static auto partial_x(auto y, auto x, auto) {
    return slope_at_kink(y == 0 && x == 0, LegBySquaredRadius::value(x, y));
  }
  static auto partial_y(auto y, auto x, auto) {
    return slope_at_kink(y == 0 && x == 0, decltype(x)(-LegBySquaredRadius::value(y, x)));
  }
};
}  // namespace detail

[[nodiscard]] auto sin(const detail::Argument auto& x) { return detail::make_unary<detail::Sin>(x); }
[[nodiscard]] auto cos(const detail::Argument auto& x) { return detail::make_unary<detail::Cos>(x); }
[[nodiscard]] auto tan(const detail::Argument auto& x) { return detail::make_unary<detail::Tan>(x); }

/// At ±1 the derivative is +∞.
[[nodiscard]] auto asin(const detail::Argument auto& x) { return detail::make_unary<detail::Asin>(x); }

/// At ±1 the derivative is −∞.
[[nodiscard]] auto acos(const detail::Argument auto& x) { return detail::make_unary<detail::Acos>(x); }
[[nodiscard]] auto atan(const detail::Argument auto& x) { return detail::make_unary<detail::Atan>(x); }

/// Angle of the point (x, y). At the origin, and across the cut, where the angle jumps, the derivatives
/// are those of the smooth branch; at the origin itself they are taken as 0.
template <class Y, class X>
requires detail::Arguments<Y, X>
[[nodiscard]] auto atan2(const Y& y, const X& x) { return detail::make_binary<detail::Atan2>(y, x, "atan2"); }
}  // namespace tapestry
