#pragma once
#include <cstddef>
#include <tapestry/autodiff/arrays/elementwise.hpp>
#include <tapestry/autodiff/arrays/product_kernel.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <type_traits>
#include <utility>

namespace tapestry {
namespace detail {

/// c[m, n] += a[m, k] · b[k, n]
template <class T>
void add_product(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  add_product<T>({a.data(), a.shape(1), 1, b.data(), c.data(), a.shape(0), a.shape(1), b.shape(1)});
}

/// c[m, n] += a[m, k] · b[n, k]ᵀ
template <class T>
void add_product_transposed(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  const auto turned = transposed(b.data(), b.shape(0), b.shape(1));
  add_product<T>({a.data(), a.shape(1), 1, turned.data(), c.data(), a.shape(0), a.shape(1), b.shape(0)});
}

/// c[m, n] += a[k, m]ᵀ · b[k, n]
template <class T>
void add_transposed_product(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  add_product<T>({a.data(), 1, a.shape(1), b.data(), c.data(), a.shape(1), a.shape(0), b.shape(1)});
}

template <class T>
[[nodiscard]] ArrayVariable<T, 2> matmul_of(const ArrayVariable<T, 2>& a, const ArrayVariable<T, 2>& b) {
  require_shape("matmul", "right operand", b.value(), {a.shape()[1], b.shape()[1]});
  Array<T, 2> value = zeros<T, 2>({a.shape()[0], b.shape()[1]});
  add_product(a.value(), b.value(), value);
  const auto pullback = [kept_a = a.shared_value(), kept_b = b.shared_value()](
                            const Array<T, 2>& value_adjoint, Array<T, 2>* a_adjoint,
                            Array<T, 2>* b_adjoint) {
    if (a_adjoint != nullptr) add_product_transposed(value_adjoint, *kept_b, *a_adjoint);
    if (b_adjoint != nullptr) add_transposed_product(*kept_a, value_adjoint, *b_adjoint);
  };
  return record_array(std::move(value), pullback, a, b);
}

template <class T>
[[nodiscard]] ArrayVariable<T, 2> affine_of(const ArrayVariable<T, 2>& x, const ArrayVariable<T, 2>& weight,
                                            const ArrayVariable<T, 1>& bias) {
  require_shape("affine", "weight", weight.value(), {weight.shape()[0], x.shape()[1]});
  require_shape("affine", "bias", bias.value(), {weight.shape()[0]});
  Array<T, 2> value({x.shape()[0], weight.shape()[0]});
  for (std::size_t n = 0; n < value.shape(0); ++n)
    for (std::size_t o = 0; o < value.shape(1); ++o) value(n, o) = bias.value()(o);
  add_product_transposed(x.value(), weight.value(), value);
  const auto pullback = [kept_x = x.shared_value(), kept_weight = weight.shared_value()](
                            const Array<T, 2>& value_adjoint, Array<T, 2>* x_adjoint,
                            Array<T, 2>* weight_adjoint, Array<T, 1>* bias_adjoint) {
    if (x_adjoint != nullptr) add_product(value_adjoint, *kept_weight, *x_adjoint);
    if (weight_adjoint != nullptr) add_transposed_product(value_adjoint, *kept_x, *weight_adjoint);
    if (bias_adjoint == nullptr) return;
    for (std::size_t n = 0; n < value_adjoint.shape(0); ++n)
      for (std::size_t o = 0; o < value_adjoint.shape(1); ++o) (*bias_adjoint)(o) += value_adjoint(n, o);
  };
  return record_array(std::move(value), pullback, x, weight, bias);
}
}  // namespace detail

/// a · b of [M, K] and [K, N], giving [M, N]; one is an array variable or a formula, the other may be a plain
/// array. In one thread. \throws ShapeError if the inner extents differ
template <class A, class B>
requires detail::ArrayPair<A, B>
[[nodiscard]] auto matmul(const A& a, const B& b) {
  using T = detail::ArrayScalarType<std::conditional_t<DifferentiableArray<A>, A, B>>;
  return detail::matmul_of<T>(ArrayVariable<T, 2>(a), ArrayVariable<T, 2>(b));
}

/// A layer: row n of the result is weight · x[n] + bias, for x [N, I], weight [O, I], bias [O], of which at
/// least one is an array variable or a formula. \throws ShapeError if they do not fit
template <class X, class W, class B>
requires(DifferentiableArray<X> || DifferentiableArray<W> || DifferentiableArray<B>)
    [[nodiscard]] auto affine(const X& x, const W& weight, const B& bias) {
  using T = detail::ArrayScalarType<
      std::conditional_t<DifferentiableArray<X>, X, std::conditional_t<DifferentiableArray<W>, W, B>>>;
  return detail::affine_of<T>(ArrayVariable<T, 2>(x), ArrayVariable<T, 2>(weight), ArrayVariable<T, 1>(bias));
}

}  // namespace tapestry
