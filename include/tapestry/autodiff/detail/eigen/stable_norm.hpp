#pragma once
#include <Eigen/Core>
#include <tapestry/autodiff/functions.hpp>

namespace tapestry {
namespace detail {
/// The power of two below a number, so that its inverse is finite; the largest for ∞ and NaN, the least for
/// 0.
template <class B>
[[nodiscard]] B power_below(B number) {
  using Limits = std::numeric_limits<B>;
  const int most = Limits::max_exponent - 1;
  return std::ldexp(B(1), std::isfinite(number)
                              ? std::clamp(number > 0 ? std::ilogb(number) : -most, 1 - most, most)
                              : most);
}
}  // namespace detail

/// A step of Eigen's stableNorm(), which calls it unqualified: adds the entries of a vector to a sum of
/// squares, both divided by a scale. The scale is a number. Eigen's own has derivatives, which cancel in the
/// norm, except where the square of a scale is not finite.
///
///   |x| = scale · √ssq,   ssq = Σ (xᵢ / scale)²
///
/// \param scale  a power of two no smaller than the largest entry's, or 0 before the first that is not 0
template <class Vector, Differentiable S>
void stable_norm_impl_inner_step(const Vector& vec, S& ssq, S& scale, S& inverse_scale) {
  using B = decltype(detail::base_value(scale));
  const auto entries = vec.eval();
  B largest = 0;
  for (Eigen::Index i = 0; i < entries.size(); ++i) {
    const B entry = std::abs(detail::base_value(entries.coeff(i)));
    if (!(entry <= largest)) largest = std::isnan(largest) ? largest : entry;
  }
  if (largest == 0) return;  // value and, as for norm(), slope stay
  const B before = detail::base_value(scale), own = detail::power_below(largest);
  if (own > before) {
    ssq *= (before / own) * (before / own);
    scale = S(own);
    inverse_scale = S(1 / own);
  }
  for (Eigen::Index i = 0; i < entries.size(); ++i) {
    const S entry = entries.coeff(i) * detail::base_value(inverse_scale);
    ssq += entry * entry;
  }
}
}  // namespace tapestry
