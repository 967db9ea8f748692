#pragma once
#include <tapestry/autodiff/detail/functions/exponential.hpp>
#include <tapestry/autodiff/detail/functions/power.hpp>
#include <tapestry/autodiff/detail/functions/selection.hpp>
#include <tapestry/autodiff/variable.hpp>

namespace tapestry {
namespace detail {
template <class R>
concept HasShape = requires(const R& range) {
  range.shape();
};
template <class R>
concept Contiguous = requires(const R& range) {
  std::span<const typename R::value_type>(range.data(), range.size());
};
/// Numbers along one axis: arrays of them, which have a shape, have reductions of their own.
template <class R>
concept PlainRange = std::floating_point<typename R::value_type> && !HasShape<R>;
}  // namespace detail

/// Contiguous scalars along one axis: std::vector, std::array, std::span or Array of variables, duals, or any
/// other scalar that a function is differentiated with; of plain numbers the first three.
template <class R>
concept ScalarRange = detail::Contiguous<R> &&
    (Differentiable<typename R::value_type> || detail::PlainRange<R>);

namespace detail {
/// Whether a scalar is made of its value and of numbers that are its partial derivatives. Others record the
/// operations themselves.
template <class S>
inline constexpr bool takes_partials = std::floating_point<S>;
template <class T>
inline constexpr bool takes_partials<Variable<T>> = true;
template <class T, std::size_t N, class Tag>
inline constexpr bool takes_partials<Dual<T, N, Tag>> = true;

template <class S>
struct ValueOf {
  using type = S;
};
template <Differentiable S>
struct ValueOf<S> {
  using type = typename S::value_type;
};
template <ScalarRange R>
using RangeScalar = typename ValueOf<typename R::value_type>::type;

template <class S>
[[nodiscard]] typename ValueOf<S>::type entry_value(const S& entry) {
  if constexpr (std::floating_point<S>) {
    return entry;
  } else {
    return entry.value();
  }
}

template <class T>
using Wide = std::conditional_t<std::is_same_v<T, float>, double, T>;

/// Makes a scalar of this value, with these partial derivatives by the entries of x.
template <std::floating_point T>
[[nodiscard]] T with_partials(const T& value, std::span<const T>, const std::vector<T>&) {
  return value;
}
template <class T>
[[nodiscard]] Variable<T> with_partials(const T& value, std::span<const Variable<T>> x,
                                        const std::vector<T>& partials) {
  return record_partials<T>(value, x, partials);
}
template <class T, std::size_t N, class Tag>
[[nodiscard]] Dual<T, N, Tag> with_partials(const T& value, std::span<const Dual<T, N, Tag>> x,
                                            const std::vector<T>& partials) {
  std::array<T, N> tangents{};
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t k = 0; k < N; ++k) tangents[k] += chain(x[i].tangent(k), partials[i]);
  return {value, tangents};
}
template <ScalarRange R>
[[nodiscard]] auto of_range(const RangeScalar<R>& value, const R& x,
                            const std::vector<RangeScalar<R>>& partials) {
  return with_partials(value, std::span<const typename R::value_type>(x.data(), x.size()), partials);
}

/// The largest value beneath the range, NaN if one is NaN, −∞ if it is empty.
template <ScalarRange R>
[[nodiscard]] auto largest_of(const R& x) {
  using B = Base<RangeScalar<R>>;
  B top = -std::numeric_limits<B>::infinity();
  for (const auto& entry : x) {
    const B value = value_of<B>(entry);
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
template <ScalarRange R>
[[nodiscard]] auto softmax_weights(const R& x, Base<RangeScalar<R>> top) {
  using T = RangeScalar<R>;
  SoftmaxWeights<T> result;
  result.weights.reserve(x.size());
  for (const auto& entry : x) {
    const T value = entry_value(entry);
    result.weights.push_back(std::isinf(top) ? T(value == top ? 1 : 0) : exp(value - top));
    result.total += static_cast<Wide<T>>(result.weights.back());
  }
  for (T& weight : result.weights) weight = static_cast<T>(static_cast<Wide<T>>(weight) / result.total);
  return result;
}

/// Length of a vector, with its partial derivatives, where the largest entry is finite and not 0.
template <class T>
struct LengthAndDirection {
  T length;
  std::vector<T> direction;
};
template <ScalarRange R>
[[nodiscard]] auto length_and_direction(const R& x, Base<RangeScalar<R>> largest) {
  using T = RangeScalar<R>;
  int exponent = 0;
  std::frexp(largest, &exponent);
  const auto down = std::ldexp(Base<T>(1), -exponent / 2), up = std::ldexp(Base<T>(1), exponent / 2);
  std::vector<Wide<T>> scaled;
  Wide<T> total = 0;
  for (const auto& entry : x) {
    scaled.push_back(static_cast<Wide<T>>(entry_value(entry) * down * down));
    total += scaled.back() * scaled.back();
  }
  using detail::sqrt;
  const Wide<T> length = sqrt(total);
  const auto wide_up = static_cast<Wide<T>>(up);
  LengthAndDirection<T> result{static_cast<T>(length * wide_up * wide_up), {}};
  for (const auto& entry : scaled) result.direction.push_back(static_cast<T>(entry / length));
  return result;
}
}  // namespace detail

/// Σ xᵢ, in double when T is float, as one statement; 0 for none.
template <ScalarRange R>
[[nodiscard]] auto sum(const R& x) {
  using S = typename R::value_type;
  if constexpr (detail::takes_partials<S>) {
    using T = detail::RangeScalar<R>;
    detail::Wide<T> total = 0;
    for (const auto& term : x) total += static_cast<detail::Wide<T>>(detail::entry_value(term));
    return detail::of_range(static_cast<T>(total), x, std::vector<T>(x.size(), T(1)));
  } else {
    S total(0);
    for (const S& term : x) total += term;
    return total;
  }
}

/// Σ xᵢ·yᵢ, in double when T is float, as one statement; 0 for none.
/// \throws DomainError if x and y differ in size
template <ScalarRange R>
[[nodiscard]] auto dot(const R& x, const R& y) {
  using S = typename R::value_type;
  if (x.size() != y.size())
    throw DomainError({"dot: ", y.size(), " entries on the right for ", x.size(), " on the left"});
  if constexpr (detail::takes_partials<S>) {
    using T = detail::RangeScalar<R>;
    std::vector<S> operands(x.begin(), x.end());
    operands.insert(operands.end(), y.begin(), y.end());
    std::vector<T> partials;
    for (const auto* from : {&y, &x})
      for (const auto& entry : *from) partials.push_back(detail::entry_value(entry));
    detail::Wide<T> total = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
      total +=
          static_cast<detail::Wide<T>>(partials[i]) * static_cast<detail::Wide<T>>(partials[x.size() + i]);
    return detail::of_range(static_cast<T>(total), operands, partials);
  } else {
    S total(0);
    for (std::size_t i = 0; i < x.size(); ++i) total += x[i] * y[i];
    return total;
  }
}

/// Euclidean length √Σ xᵢ² as one statement, without overflow or underflow of the squares; 0 for none. At the
/// origin all derivatives are 0, a subgradient; an infinite entry has the derivative ±1.
template <ScalarRange R>
[[nodiscard]] auto norm(const R& x) {
  using S = typename R::value_type;
  if constexpr (detail::takes_partials<S>) {
    using T = detail::RangeScalar<R>;
    using B = detail::Base<T>;
    B largest = 0;
    for (const auto& entry : x) {
      const B size = std::abs(detail::value_of<B>(entry));
      largest = size > largest || std::isnan(size) ? size : largest;
    }
    if (largest != 0 && !std::isinf(largest)) {
      const auto [length, direction] = detail::length_and_direction(x, largest);
      return detail::of_range(length, x, direction);
    }
    using detail::abs;
    T value(0);
    std::vector<T> partials(x.size(), T(0));
    for (std::size_t i = 0; i < x.size(); ++i) {
      const T entry = detail::entry_value(x[i]);
      if (largest != 0 && !std::isinf(detail::value_of<B>(entry))) continue;
      partials[i] = detail::slope_at_kink(largest == 0, T(sign(detail::value_of<B>(entry))));
      value += detail::value_at_kink(largest == 0, T(abs(entry)), entry);
    }
    return detail::of_range(value, x, partials);
  } else {
    S length(0);
    for (const S& entry : x) length = hypot(length, entry);
    return length;
  }
}

/// log Σ exp xᵢ as one statement, without overflow; −∞, and passive, for none. The derivatives are the
/// softmax of x; where the maximum is infinite, the entries equal to it share 1 equally.
template <ScalarRange R>
[[nodiscard]] auto logsumexp(const R& x) {
  using S = typename R::value_type;
  using T = detail::RangeScalar<R>;
  const auto top = detail::largest_of(x);
  if constexpr (detail::takes_partials<S>) {
    using detail::log;
    const auto softmax = detail::softmax_weights(x, top);
    T value(top);
    if (!std::isinf(top)) {
      value += static_cast<T>(log(softmax.total));
    } else if (x.size() > 0) {
      value = T(0);
      for (std::size_t i = 0; i < x.size(); ++i)
        if (softmax.weights[i] != 0) value += softmax.weights[i] * detail::entry_value(x[i]);
    }
    return detail::of_range(value, x, softmax.weights);
  } else {
    if (x.size() == 0) return S(top);
    S total = x[0];
    for (std::size_t i = 1; i < x.size(); ++i) total = logsumexp(total, x[i]);
    return total;
  }
}

/// exp xᵢ / Σ exp xⱼ, without overflow, one statement an entry: the derivative of entry i by xⱼ is
/// yᵢ·(δᵢⱼ − yⱼ), where 1 − yᵢ is the sum of the others, so that it keeps its digits as yᵢ nears 1. Where the
/// maximum is infinite, the entries equal to it share 1 equally; where it is +∞, they are NaN for scalars
/// that record the operations themselves, as in hessian_pattern().
template <ScalarRange R>
[[nodiscard]] auto softmax(const R& x) {
  using S = typename R::value_type;
  std::vector<S> results;
  results.reserve(x.size());
  if constexpr (detail::takes_partials<S>) {
    using T = detail::RangeScalar<R>;
    const std::vector<T> y = detail::softmax_weights(x, detail::largest_of(x)).weights;
    std::vector<T> partials(y.size());
    for (std::size_t i = 0; i < y.size(); ++i) {
      detail::Wide<T> others = 0;
      for (std::size_t j = 0; j < y.size(); ++j) {
        partials[j] = -y[i] * y[j];
        if (j != i) others += static_cast<detail::Wide<T>>(y[j]);
      }
      partials[i] = y[i] * static_cast<T>(others);
      results.push_back(detail::of_range(y[i], x, partials));
    }
  } else {
    const S total = logsumexp(x);
    for (const S& entry : x) results.push_back(S(exp(entry - total)));
  }
  return results;
}
}  // namespace tapestry
