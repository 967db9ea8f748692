#pragma once
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <tapestry/autodiff/functions/scalar_functions.hpp>
#include <tapestry/autodiff/tape/formula.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <type_traits>
#include <vector>

namespace tapestry {

/// Contiguous variables: std::vector, std::array or std::span of Variable<T>.
template <class R>
concept VariableRange = ScalarExpression<typename R::value_type> && requires(const R& range) {
  std::span<const typename R::value_type>(range.data(), range.size());
};

namespace detail {
template <VariableRange R>
using RangeScalar = typename R::value_type::value_type;

/// Type in which sums of T are computed.
template <class T>
using Wide = std::conditional_t<std::is_same_v<T, float>, double, T>;

template <VariableRange R>
[[nodiscard]] auto record_range(const RangeScalar<R>& value, const R& variables,
                                const std::vector<RangeScalar<R>>& partials) {
  using T = RangeScalar<R>;
  return record_partials<T>(value, std::span<const Variable<T>>(variables.data(), variables.size()),
                            partials);
}

/// The largest value beneath the range, a NaN if there is one, −∞ of none.
template <VariableRange R>
[[nodiscard]] auto largest_of(const R& x) {
  using B = Base<RangeScalar<R>>;
  B top = -std::numeric_limits<B>::infinity();
  for (const auto& entry : x) {
    const B value = base_value(entry);
    top = value > top || std::isnan(value) ? value : top;
  }
  return top;
}

/// exp(xᵢ − top), and their sum. Where top is infinite, the entries equal to it weigh 1 and the others 0.
template <class T>
struct SoftmaxWeights {
  std::vector<T> weights;
  Wide<T> total = 0;
};
template <VariableRange R>
[[nodiscard]] auto softmax_weights(const R& x, Base<RangeScalar<R>> top) {
  using T = RangeScalar<R>;
  SoftmaxWeights<T> result;
  result.weights.reserve(x.size());
  for (const auto& entry : x) {
    const T value = entry.value();
    result.weights.push_back(std::isinf(top) ? T(value == top ? 1 : 0) : exp(value - top));
    result.total += static_cast<Wide<T>>(result.weights.back());
  }
  for (T& weight : result.weights) weight = static_cast<T>(static_cast<Wide<T>>(weight) / result.total);
  return result;
}
}  // namespace detail

/// Σ xᵢ, in double when T is float, as one statement; 0 for none.
template <VariableRange R>
[[nodiscard]] auto sum(const R& x) {
  using T = detail::RangeScalar<R>;
  detail::Wide<T> total = 0;
  for (const auto& term : x) total += static_cast<detail::Wide<T>>(term.value());
  return detail::record_range(static_cast<T>(total), x, std::vector<T>(x.size(), T(1)));
}

/// Σ xᵢ·yᵢ, in double when T is float, as one statement; 0 for none.
/// \throws DomainError if there are not as many xᵢ as yᵢ
template <VariableRange R>
[[nodiscard]] auto dot(const R& x, const R& y) {
  using T = detail::RangeScalar<R>;
  if (x.size() != y.size())
    throw DomainError("dot: " + std::to_string(y.size()) + " entries on the right for " +
                      std::to_string(x.size()) + " on the left");
  std::vector<Variable<T>> operands(x.begin(), x.end());
  operands.insert(operands.end(), y.begin(), y.end());
  std::vector<T> partials;
  detail::Wide<T> total = 0;
  for (const auto& other : y) partials.push_back(other.value());
  for (std::size_t i = 0; i < x.size(); ++i) {
    partials.push_back(x[i].value());
    total += static_cast<detail::Wide<T>>(x[i].value()) * static_cast<detail::Wide<T>>(y[i].value());
  }
  return detail::record_range(static_cast<T>(total), operands, partials);
}

/// Euclidean length √Σ xᵢ² as one statement, without overflow or underflow of the squares; 0 for none. At the
/// origin all derivatives are 0, a subgradient; an infinite entry has the derivative ±1.
template <VariableRange R>
[[nodiscard]] auto norm(const R& x) {
  using T = detail::RangeScalar<R>;
  detail::Base<T> largest = 0;
  for (const auto& entry : x) {
    const auto size = std::abs(detail::base_value(entry));
    largest = size > largest || std::isnan(size) ? size : largest;
  }
  std::vector<T> partials(x.size(), T(0));
  if (largest == 0) return detail::record_range(T(0), x, partials);
  if (std::isinf(largest)) {
    for (std::size_t i = 0; i < x.size(); ++i)
      if (std::isinf(detail::base_value(x[i]))) partials[i] = T(sign(detail::base_value(x[i])));
    return detail::record_range(T(largest), x, partials);
  }
  detail::Wide<T> total = 0;
  int exponent = 0;
  std::frexp(largest, &exponent);
  const auto down = std::ldexp(detail::Base<T>(1), -exponent / 2),
             up = std::ldexp(detail::Base<T>(1), exponent / 2);
  const auto scaled = [&](const auto& entry) {
    return static_cast<detail::Wide<T>>(entry.value() * down * down);
  };
  for (const auto& entry : x) total += scaled(entry) * scaled(entry);
  using detail::sqrt;
  const detail::Wide<T> length = sqrt(total);
  for (std::size_t i = 0; i < x.size(); ++i) partials[i] = static_cast<T>(scaled(x[i]) / length);
  return detail::record_range(static_cast<T>(length * up * up), x, partials);
}

/// log Σ exp xᵢ as one statement, without overflow; −∞, and passive, for none. The derivatives are the
/// softmax of x; where the maximum is infinite, the entries equal to it share 1 equally.
template <VariableRange R>
[[nodiscard]] auto logsumexp(const R& x) {
  using T = detail::RangeScalar<R>;
  using detail::log;
  const auto top = detail::largest_of(x);
  const auto softmax = detail::softmax_weights(x, top);
  const T value = std::isinf(top) ? T(top) : top + static_cast<T>(log(softmax.total));
  return detail::record_range(value, x, softmax.weights);
}

/// exp xᵢ / Σ exp xⱼ, without overflow, one statement an entry: the derivative of entry i by xⱼ is
/// yᵢ·(δᵢⱼ − yⱼ), where 1 − yᵢ is the sum of the others, so that it keeps its digits as yᵢ nears 1. Where the
/// maximum is infinite, the entries equal to it share 1 equally.
template <VariableRange R>
[[nodiscard]] auto softmax(const R& x) {
  using T = detail::RangeScalar<R>;
  const std::vector<T> y = detail::softmax_weights(x, detail::largest_of(x)).weights;
  std::vector<Variable<T>> results;
  results.reserve(y.size());
  std::vector<T> partials(y.size());
  for (std::size_t i = 0; i < y.size(); ++i) {
    detail::Wide<T> others = 0;
    for (std::size_t j = 0; j < y.size(); ++j) {
      partials[j] = -y[i] * y[j];
      if (j != i) others += static_cast<detail::Wide<T>>(y[j]);
    }
    partials[i] = y[i] * static_cast<T>(others);
    results.push_back(detail::record_range(y[i], x, partials));
  }
  return results;
}

}  // namespace tapestry
