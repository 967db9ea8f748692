#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <type_traits>
#include <utility>

namespace tapestry {
namespace detail {

/// Σ term(i) in double: blocks of 512 terms in eight lanes, their sums compensated (Neumaier), always in
/// the same order. Relative error at most about 70 ε · Σ|term| / |Σ term|, however many the terms.
template <class Term>
[[nodiscard]] double blocked_sum(std::size_t count, Term term) {
  double total = 0;
  double lost = 0;
  for (std::size_t first = 0; first < count; first += 512) {
    const std::size_t last = std::min(count, first + 512);
    double lanes[8] = {};
    std::size_t i = first;
    for (; i + 8 <= last; i += 8)
      for (std::size_t lane = 0; lane < 8; ++lane) lanes[lane] += static_cast<double>(term(i + lane));
    for (; i < last; ++i) lanes[0] += static_cast<double>(term(i));
    double block = 0;
    for (const double lane : lanes) block += lane;
    const double sum = total + block;
    if (std::isfinite(sum))
      lost += std::abs(total) >= std::abs(block) ? (total - sum) + block : (block - sum) + total;
    total = sum;
  }
  return total + lost;
}
}  // namespace detail

/// Σ of all elements, added in double; 0 for none.
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> sum(const ArrayVariable<T, Rank>& x) {
  const T* const elements = x.value().data();
  const double total = detail::blocked_sum(x.size(), [=](std::size_t i) { return elements[i]; });
  const auto pullback = [](T value_adjoint, Array<T, Rank>* x_adjoint) {
    for (T& element : x_adjoint->storage()) element += value_adjoint;
  };
  return record_scalar(static_cast<T>(total), pullback, x);
}

/// The mean of all elements; NaN for none.
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> mean(const ArrayVariable<T, Rank>& x) {
  return sum(x) / static_cast<T>(x.size());
}

/// Σ x·y over all elements, added in double. \throws ShapeError if extents differ
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> dot(const ArrayVariable<T, Rank>& x,
                              const std::type_identity_t<ArrayVariable<T, Rank>>& y) {
  require_shape("dot", "right operand", y.value(), x.shape());
  const T* const a = x.value().data();
  const T* const b = y.value().data();
  const double total = detail::blocked_sum(
      x.size(), [=](std::size_t i) { return static_cast<double>(a[i]) * static_cast<double>(b[i]); });
  const auto pullback = [kept_x = x.shared_value(), kept_y = y.shared_value()](
                            T value_adjoint, Array<T, Rank>* x_adjoint, Array<T, Rank>* y_adjoint) {
    const auto add = [value_adjoint](Array<T, Rank>* adjoint, const Array<T, Rank>& other) {
      if (adjoint == nullptr) return;
      for (std::size_t i = 0; i < other.size(); ++i) adjoint->data()[i] += value_adjoint * other.data()[i];
    };
    add(x_adjoint, *kept_y);
    add(y_adjoint, *kept_x);
  };
  return record_scalar(static_cast<T>(total), pullback, x, y);
}

/// log Σ exp x over all elements, without overflow; −∞ for none. The derivatives are the softmax of x; where
/// the maximum is infinite, the elements equal to it share 1 equally.
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> logsumexp(const ArrayVariable<T, Rank>& x) {
  T top = -std::numeric_limits<T>::infinity();
  for (const T element : x.value().storage()) top = element > top || std::isnan(element) ? element : top;
  Array<T, Rank> weights(x.shape());
  const T* const elements = x.value().data();
  for (std::size_t i = 0; i < x.size(); ++i)
    weights.data()[i] = elements[i] == top ? T(1) : std::isinf(top) ? T(0) : std::exp(elements[i] - top);
  const double total = detail::blocked_sum(x.size(), [&](std::size_t i) { return weights.data()[i]; });
  for (T& weight : weights.storage()) weight = static_cast<T>(static_cast<double>(weight) / total);
  const T value = std::isinf(top) ? top : top + static_cast<T>(std::log(total));
  auto pullback = [softmax = std::move(weights)](T value_adjoint, Array<T, Rank>* x_adjoint) {
    for (std::size_t i = 0; i < softmax.size(); ++i)
      x_adjoint->data()[i] += value_adjoint * softmax.data()[i];
  };
  return record_scalar(value, std::move(pullback), x);
}

/// One element as a scalar. \throws ShapeError if the index lies outside
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> element(const ArrayVariable<T, Rank>& x, const Extents<Rank>& index) {
  std::size_t place = 0;
  for (std::size_t axis = 0; axis < Rank; ++axis) {
    if (index[axis] >= x.shape()[axis])
      throw ShapeError("element: index " + detail::to_text(index) + " lies outside " +
                       detail::to_text(x.shape()));
    place = place * x.shape()[axis] + index[axis];
  }
  const auto pullback = [place](T value_adjoint, Array<T, Rank>* x_adjoint) {
    x_adjoint->data()[place] += value_adjoint;
  };
  return record_scalar(x.value().data()[place], pullback, x);
}

/// The same elements in row-major order under other extents. \throws ShapeError if their number differs
template <std::size_t NewRank, class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, NewRank> reshape(const ArrayVariable<T, Rank>& x,
                                                const Extents<NewRank>& extents) {
  Array<T, NewRank> value(extents);
  if (value.size() != x.size())
    throw ShapeError("reshape: " + detail::to_text(x.shape()) + " does not fit " + detail::to_text(extents));
  std::copy_n(x.value().data(), x.size(), value.data());
  const auto pullback = [](const Array<T, NewRank>& value_adjoint, Array<T, Rank>* x_adjoint) {
    for (std::size_t i = 0; i < value_adjoint.size(); ++i) x_adjoint->data()[i] += value_adjoint.data()[i];
  };
  return record_array(std::move(value), pullback, x);
}

}  // namespace tapestry
