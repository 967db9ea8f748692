#pragma once
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/detail/arrays/product.hpp>

// More functions of arrays that scalars have. Errors as of the others.

namespace tapestry {
namespace detail {
/// A function that is constant between its jumps.
template <class Function>
struct Steps {
  static constexpr bool is_cheap = true;
  template <class T>
  static T value(const T& x) {
    return T(Function()(value_of<Base<T>>(x)));
  }
  static auto partial(auto x, auto) { return decltype(x)(0); }
};

template <class Function, DifferentiableArray X>
[[nodiscard]] auto steps(const X& x, const Function&) {
  return array_unary(x, Steps<Function>());
}
}  // namespace detail

// Their derivative is 0.
template <DifferentiableArray X>
[[nodiscard]] auto sign(const X& x) {
  return detail::steps(x, [](auto number) { return tapestry::sign(number); });
}
template <DifferentiableArray X>
[[nodiscard]] auto floor(const X& x) {
  return detail::steps(x, [](auto number) { return std::floor(number); });
}
template <DifferentiableArray X>
[[nodiscard]] auto ceil(const X& x) {
  return detail::steps(x, [](auto number) { return std::ceil(number); });
}
template <DifferentiableArray X>
[[nodiscard]] auto round(const X& x) {
  return detail::steps(x, [](auto number) { return std::round(number); });
}
template <DifferentiableArray X>
[[nodiscard]] auto rint(const X& x) {
  return detail::steps(x, [](auto number) { return std::rint(number); });
}
template <DifferentiableArray X>
[[nodiscard]] auto trunc(const X& x) {
  return detail::steps(x, [](auto number) { return std::trunc(number); });
}

/// x · y + z; two roundings.
template <class X, class Y, class Z>
requires(detail::ArrayPair<X, Y> || detail::ArrayPair<X, Z> || detail::ArrayPair<Y, Z>)
    [[nodiscard]] auto fma(const X& x, const Y& y, const Z& z) {
  return x * y + z;
}

/// x + t · (y − x).
template <class X, class Y, class Z>
requires(detail::ArrayPair<X, Y> || detail::ArrayPair<X, Z> || detail::ArrayPair<Y, Z>)
    [[nodiscard]] auto lerp(const X& x, const Y& y, const Z& t) {
  return x + t * (y - x);
}

/// x, with y added as of operator+.
template <class T, std::size_t Rank, detail::ArrayPair<ArrayVariable<T, Rank>> Y>
ArrayVariable<T, Rank>& operator+=(ArrayVariable<T, Rank>& x, const Y& y) {
  return x = ArrayVariable<T, Rank>(x + y);
}
template <class T, std::size_t Rank, detail::ArrayPair<ArrayVariable<T, Rank>> Y>
ArrayVariable<T, Rank>& operator-=(ArrayVariable<T, Rank>& x, const Y& y) {
  return x = ArrayVariable<T, Rank>(x - y);
}
template <class T, std::size_t Rank, detail::ArrayPair<ArrayVariable<T, Rank>> Y>
ArrayVariable<T, Rank>& operator*=(ArrayVariable<T, Rank>& x, const Y& y) {
  return x = ArrayVariable<T, Rank>(x * y);
}

/// Π of all elements; 1 for none. Its derivatives are products of the other elements, so that a zero among
/// them needs no division.
template <DifferentiableArray X>
[[nodiscard]] auto prod(const X& x) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  const auto before = std::make_shared<std::vector<T>>(1, T(1));  // product of the elements before each
  for (const T& element : variable.value()) before->push_back(before->back() * element);
  const auto pullback = [before, kept = variable.shared_value()](T value_adjoint, auto* x_adjoint) {
    T behind = value_adjoint;
    for (std::size_t i = kept->size(); i-- > 0;) {
      x_adjoint->data()[i] += detail::chain(behind, (*before)[i]);
      behind *= kept->data()[i];
    }
  };
  return record_scalar(before->back(), CarriesTangents{pullback}, variable);
}

/// Sums of the elements up to each along one axis, added in double. \throws ShapeError for no such axis
template <DifferentiableArray X>
[[nodiscard]] auto cumsum(const X& x, std::size_t axis) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  const auto layout = detail::layout_around("cumsum", variable.shape(), axis);
  // Adds to each element of `to` the sum of those of `from` up to it, or from it on.
  const auto add_sums = [layout](const T* from, T* to, bool is_backward) {
    detail::for_each_line(layout, [&](std::size_t first, std::size_t) {
      detail::Widened<T> sum = 0;
      for (std::size_t i = 0; i < layout.count; ++i) {
        const std::size_t at = first + (is_backward ? layout.count - 1 - i : i) * layout.inner;
        to[at] += detail::narrowed<T>(sum += detail::widened(from[at]));
      }
    });
  };
  auto value = zeros<T, X::rank>(variable.shape());
  add_sums(variable.value().data(), value.data(), false);
  const auto pullback = [add_sums](const Array<T, X::rank>& value_adjoint, Array<T, X::rank>* x_adjoint) {
    add_sums(value_adjoint.data(), x_adjoint->data(), true);
  };
  return record_array(std::move(value), CarriesTangents{pullback}, variable);
}

/// a · x of a matrix [M, K] and a vector [K], giving [M].
template <class A, class X>
requires(DifferentiableArray<A> || DifferentiableArray<X>) [[nodiscard]] auto matvec(const A& a, const X& x) {
  using T = detail::ArrayScalarType<std::conditional_t<DifferentiableArray<A>, A, X>>;
  const ArrayVariable<T, 2> matrix(a);
  const ArrayVariable<T, 1> vector(x);
  const auto product = matmul(matrix, reshape(vector, Extents<2>{vector.size(), 1}));
  return reshape(product, Extents<1>{matrix.shape()[0]});
}
}  // namespace tapestry
