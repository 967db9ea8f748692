#pragma once
#include <tapestry/autodiff/detail/arrays/exponential.hpp>

namespace tapestry {
/// Σ of all elements, added in double; 0 for none. A formula is summed in the pass that computes it.
template <DifferentiableArray X>
[[nodiscard]] auto sum(const X& x) {
  return detail::evaluate_sum(detail::to_node(x));
}

/// The mean of all elements; NaN for none.
template <DifferentiableArray X>
[[nodiscard]] auto mean(const X& x) {
  using T = detail::ArrayScalarType<X>;
  return Variable<T>(sum(x) / static_cast<detail::Base<T>>(detail::count_of(x.shape())));
}

/// Σ x·y over all elements, added in double. \throws ShapeError if extents do not go together
template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto dot(const X& x, const Y& y) {
  return detail::evaluate_sum(detail::array_binary<detail::Times>("dot", x, y));
}

namespace detail {
/// An array of a variable's extents, with elements of any value.
template <class T, std::size_t Rank>
[[nodiscard]] std::shared_ptr<Array<T, Rank>> array_like(const ArrayVariable<T, Rank>& x) {
  return std::make_shared<Array<T, Rank>>(x.shape());
}

/// Axes of an array as [outer, count, inner] around one of them.
struct AxisLayout {
  std::size_t outer = 1;
  std::size_t count = 1;
  std::size_t inner = 1;
};
template <std::size_t Rank>
[[nodiscard]] AxisLayout layout_around(const char* operation, const Extents<Rank>& extents,
                                       std::size_t axis) {
  if (axis >= Rank) throw ShapeError({operation, ": axis ", axis, " of ", extents});
  AxisLayout layout;
  for (std::size_t a = 0; a < Rank; ++a)
    (a < axis ? layout.outer : a == axis ? layout.count : layout.inner) *= extents[a];
  return layout;
}
template <std::size_t Rank>
[[nodiscard]] Extents<Rank - 1> without_axis(const Extents<Rank>& extents, std::size_t axis) {
  Extents<Rank - 1> rest{};
  for (std::size_t a = 0; a + 1 < Rank; ++a) rest[a] = extents[a < axis ? a : a + 1];
  return rest;
}

/// The largest of `count` elements: NaN if one is NaN, −∞ if count is 0.
template <class T>
[[nodiscard]] T largest_of_line(const T* line, std::size_t count, std::size_t step) {
  T top = -std::numeric_limits<T>::infinity();
  bool is_nan = false;
  for (std::size_t i = 0; i < count; ++i) {
    const T element = line[i * step];
    top = top < element ? element : top;
    is_nan = is_nan || std::isnan(element);
  }
  return is_nan ? std::numeric_limits<T>::quiet_NaN() : top;
}

/// weights[i] = exp(line[i] − largest) / Σ …, and log Σ exp. Where the largest is infinite, those equal to it
/// share 1 equally.
template <Exponential Policy, class T>
[[nodiscard]] T softmax_line(const T* line, T* weights, std::size_t count, std::size_t step) {
  const T top = largest_of_line(line, count, step);
  CompensatedSum sum;
  if (std::isinf(top)) {
    for (std::size_t i = 0; i < count; ++i) weights[i * step] = line[i * step] == top ? T(1) : T(0);
  } else {
    exponentials<Policy>(line, weights, top, count, step);
  }
  sum.add(count, [=](std::size_t i) { return weights[i * step]; });
  const auto share = static_cast<T>(1 / sum.total());
  for (std::size_t i = 0; i < count; ++i) weights[i * step] *= share;
  return std::isinf(top) ? top : top + static_cast<T>(std::log(sum.total()));
}

/// Calls visit(first element of a line, its number), for the lines along an axis.
template <class Visit>
void for_each_line(const AxisLayout& layout, Visit visit) {
  for (std::size_t o = 0; o < layout.outer; ++o)
    for (std::size_t k = 0; k < layout.inner; ++k)
      visit(o * layout.count * layout.inner + k, o * layout.inner + k);
}

/// x̄ᵢ += yᵢ·(ḡᵢ − Σ ḡⱼ·yⱼ) of a line of the softmax y, summed in double. The ḡ of the largest yₘ is
/// subtracted from all, so that 1 − yₘ keeps its digits as yₘ nears 1.
template <class T>
void pull_back_softmax_line(const T* g, const T* y, T* x_adjoint, std::size_t count, std::size_t step) {
  std::size_t top = 0;
  for (std::size_t i = 1; i < count; ++i)
    if (y[i * step] > y[top * step]) top = i;
  const auto beyond_top = [=](std::size_t i) {
    return i == top ? 0 : static_cast<double>(g[i * step]) - static_cast<double>(g[top * step]);
  };
  double mean = 0;
  for (std::size_t i = 0; i < count; ++i) mean += chain(beyond_top(i), static_cast<double>(y[i * step]));
  for (std::size_t i = 0; i < count; ++i)
    x_adjoint[i * step] += chain(static_cast<T>(beyond_top(i) - mean), y[i * step]);
}

/// Whether a is better than b; a NaN is the best of all.
template <class T>
[[nodiscard]] bool is_beyond(bool is_further, T a, T b) {
  return b == b && (is_further || a != a);
}

/// The element that is better than all before it and no worse than all behind it.
/// \throws ShapeError if there are none
template <class T, std::size_t Rank, class Better>
[[nodiscard]] Variable<T> extreme(const char* operation, const ArrayVariable<T, Rank>& x, Better is_better) {
  if (x.size() == 0) throw ShapeError({operation, ": the array has no elements"});
  const T* const elements = x.value().data();
  std::size_t best = 0;
  for (std::size_t i = 1; i < x.size(); ++i)
    if (is_better(elements[i], elements[best])) best = i;
  const auto pullback = [best](T value_adjoint, Array<T, Rank>* x_adjoint) {
    x_adjoint->data()[best] += value_adjoint;
  };
  return record_scalar(elements[best], CarriesTangents{pullback}, x);
}
}  // namespace detail

/// log Σ exp x over all elements, without overflow; −∞ for none. The derivatives are the softmax of x; where
/// the maximum is infinite, the elements equal to it share 1 equally.
/// \tparam Policy  how the exponentials are computed; below exp(−707), in double, a share is 0
template <Exponential Policy = Exponential::vector, DifferentiableArray X>
[[nodiscard]] auto logsumexp(const X& x) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  const auto weights = detail::array_like(variable);
  const T value =
      detail::softmax_line<Policy>(variable.value().data(), weights->data(), variable.size(), std::size_t(1));
  const auto pullback = [weights](T value_adjoint, Array<T, X::rank>* x_adjoint) {
    T* const to = x_adjoint->data();
    for (std::size_t i = 0; i < weights->size(); ++i)
      to[i] += detail::chain(value_adjoint, weights->data()[i]);
  };
  return record_scalar(value, pullback, variable);
}

/// Σ along one axis, which is dropped, added in double. \throws ShapeError if there is no such axis
template <DifferentiableArray X>
[[nodiscard]] auto sum_along(const X& x, std::size_t axis) {
  using T = detail::ArrayScalarType<X>;
  constexpr std::size_t rank = X::rank;
  const ArrayVariable<T, rank> variable(x);
  const auto layout = detail::layout_around("sum_along", variable.shape(), axis);
  Array<T, rank - 1> value(detail::without_axis(variable.shape(), axis));
  std::vector<detail::Widened<T>> sums(layout.inner);
  for (std::size_t o = 0; o < layout.outer; ++o) {
    std::fill(sums.begin(), sums.end(), detail::Widened<T>(0));
    const T* from = variable.value().data() + o * layout.count * layout.inner;
    for (std::size_t i = 0; i < layout.count; ++i)
      for (std::size_t k = 0; k < layout.inner; ++k) sums[k] += detail::widened(*from++);
    for (std::size_t k = 0; k < layout.inner; ++k)
      value.data()[o * layout.inner + k] = detail::narrowed<T>(sums[k]);
  }
  const auto pullback = [layout](const Array<T, rank - 1>& value_adjoint, Array<T, rank>* x_adjoint) {
    T* to = x_adjoint->data();
    for (std::size_t o = 0; o < layout.outer; ++o)
      for (std::size_t i = 0; i < layout.count; ++i)
        for (std::size_t k = 0; k < layout.inner; ++k) *to++ += value_adjoint.data()[o * layout.inner + k];
  };
  return record_array(std::move(value), CarriesTangents{pullback}, variable);
}

/// log Σ exp along one axis, which is dropped; each line as logsumexp().
/// \throws ShapeError if there is no such axis
template <Exponential Policy = Exponential::vector, DifferentiableArray X>
[[nodiscard]] auto logsumexp_along(const X& x, std::size_t axis) {
  using T = detail::ArrayScalarType<X>;
  constexpr std::size_t rank = X::rank;
  const ArrayVariable<T, rank> variable(x);
  const auto layout = detail::layout_around("logsumexp_along", variable.shape(), axis);
  Array<T, rank - 1> value(detail::without_axis(variable.shape(), axis));
  const auto weights = detail::array_like(variable);
  detail::for_each_line(layout, [&](std::size_t first, std::size_t line) {
    value.data()[line] = detail::softmax_line<Policy>(variable.value().data() + first,
                                                      weights->data() + first, layout.count, layout.inner);
  });
  const auto pullback = [layout, weights](const Array<T, rank - 1>& value_adjoint,
                                          Array<T, rank>* x_adjoint) {
    detail::for_each_line(layout, [&](std::size_t first, std::size_t line) {
      const T g = value_adjoint.data()[line];
      T* const to = x_adjoint->data() + first;
      const T* const share = weights->data() + first;
      for (std::size_t i = 0; i < layout.count; ++i)
        to[i * layout.inner] += detail::chain(g, share[i * layout.inner]);
    });
  };
  return record_array(std::move(value), pullback, variable);
}

/// exp x / Σ exp along one axis, without overflow. The pullback, y·(g − Σ g·y), sums in double.
/// \throws ShapeError if there is no such axis
template <Exponential Policy = Exponential::vector, DifferentiableArray X>
[[nodiscard]] auto softmax_along(const X& x, std::size_t axis) {
  using T = detail::ArrayScalarType<X>;
  constexpr std::size_t rank = X::rank;
  const ArrayVariable<T, rank> variable(x);
  const auto layout = detail::layout_around("softmax_along", variable.shape(), axis);
  const auto value = detail::array_like(variable);
  detail::for_each_line(layout, [&](std::size_t first, std::size_t) {
    static_cast<void>(detail::softmax_line<Policy>(variable.value().data() + first, value->data() + first,
                                                   layout.count, layout.inner));
  });
  const auto pullback = [layout, value](const Array<T, rank>& value_adjoint, Array<T, rank>* x_adjoint) {
    detail::for_each_line(layout, [&](std::size_t first, std::size_t) {
      detail::pull_back_softmax_line(value_adjoint.data() + first, value->data() + first,
                                     x_adjoint->data() + first, layout.count, layout.inner);
    });
  };
  return record_array(std::shared_ptr<const Array<T, rank>>(value), pullback, variable);
}

/// Euclidean length √Σ x², without overflow or underflow of the squares; 0 for none. At the origin all
/// derivatives are 0, a subgradient; an infinite element has the derivative ±1.
template <DifferentiableArray X>
[[nodiscard]] auto norm(const X& x) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  const T* const elements = variable.value().data();
  double largest = 0;
  for (std::size_t i = 0; i < variable.size(); ++i)
    largest = std::max(largest, std::abs(static_cast<double>(elements[i])));
  const double scale = largest == 0 || std::isinf(largest) ? 1 : std::ldexp(1.0, std::ilogb(largest));
  detail::CompensatedSum<> sum;
  sum.add(variable.size(), [=](std::size_t i) {
    const double part = static_cast<double>(elements[i]) / scale;
    return part * part;
  });
  const double length = std::sqrt(sum.total());
  const auto slope = [scale, length](T element) {
    if (std::isinf(length)) return std::isinf(element) ? std::copysign(T(1), element) : T(0);
    return static_cast<T>(static_cast<double>(element) / scale / length);
  };
  const auto pullback = [kept = variable.shared_value(), length, slope](T value_adjoint,
                                                                        Array<T, X::rank>* x_adjoint) {
    if (length == 0) return;
    for (std::size_t i = 0; i < kept->size(); ++i)
      x_adjoint->data()[i] += detail::chain(value_adjoint, slope(kept->data()[i]));
  };
  return record_scalar(static_cast<T>(length * scale), pullback, variable);
}

/// The largest element as a scalar: the first of several equal ones, or the first NaN. Its adjoint goes to
/// that element, as if it were x[i]. At a tie max() shares the adjoint. That would take a second pass here,
/// and the best of thousands of scores would have several gradients.
/// \throws ShapeError if there are none
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> largest(const ArrayVariable<T, Rank>& x) {
  return detail::extreme("largest", x, [](T a, T b) { return detail::is_beyond(a > b, a, b); });
}

/// The smallest one; otherwise as largest().
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> smallest(const ArrayVariable<T, Rank>& x) {
  return detail::extreme("smallest", x, [](T a, T b) { return detail::is_beyond(a < b, a, b); });
}
}  // namespace tapestry
