#pragma once
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <tapestry/autodiff/variable.hpp>
#include <vector>

namespace tapestry {

/// Contiguous variables: std::vector, std::array or std::span of Variable<T>.
template <class R>
concept VariableRange = ScalarExpression<typename R::value_type> && requires(const R& range) {
  std::span<const typename R::value_type>(range.data(), range.size());
};

namespace detail {
template <VariableRange R>
[[nodiscard]] auto record_range(typename R::value_type::value_type value, const R& variables,
                                const std::vector<typename R::value_type::value_type>& partials) {
  using T = typename R::value_type::value_type;
  return record_partials<T>(value, std::span<const Variable<T>>(variables.data(), variables.size()),
                            partials);
}
}  // namespace detail

/// Σ xᵢ, added in double, as one statement; 0 for none.
template <VariableRange R>
[[nodiscard]] auto sum(const R& x) {
  using T = typename R::value_type::value_type;
  double total = 0;
  for (const auto& term : x) total += static_cast<double>(term.value());
  return detail::record_range(static_cast<T>(total), x, std::vector<T>(x.size(), T(1)));
}

/// log Σ exp xᵢ as one statement, without overflow; −∞, and passive, for none. The derivatives are the
/// softmax of x; where the maximum is infinite, the entries equal to it share 1 equally.
template <VariableRange R>
[[nodiscard]] auto logsumexp(const R& x) {
  using T = typename R::value_type::value_type;
  T top = -std::numeric_limits<T>::infinity();
  for (const auto& entry : x) top = entry.value() > top || std::isnan(entry.value()) ? entry.value() : top;
  std::vector<T> weights;
  weights.reserve(x.size());
  double total = 0;
  for (const auto& entry : x) {
    weights.push_back(entry.value() == top ? T(1) : std::isinf(top) ? T(0) : std::exp(entry.value() - top));
    total += static_cast<double>(weights.back());
  }
  for (T& weight : weights) weight = static_cast<T>(static_cast<double>(weight) / total);
  const T value = std::isinf(top) ? top : top + static_cast<T>(std::log(total));
  return detail::record_range(value, x, weights);
}

}  // namespace tapestry
