#pragma once
#include <algorithm>
#include "seeded.hpp"

namespace tapestry::benchmarks {
/// ½ Σ of the squares of A₁·A₂·A₃·A₄·A₅, matrices [48, 48].
struct MatmulChain {
  static constexpr const char* name = "matmul-chain";
  static constexpr std::size_t side = 48, area = side * side, factors = 5;
  [[nodiscard]] static std::vector<double> start() { return uniform(factors * area, -.25, .25, 41); }

  /// c = a · b
  template <class S>
  static void multiply(const S* a, const S* b, S* c) {
    std::fill_n(c, area, S(0));
    for (std::size_t i = 0; i < side; ++i)
      for (std::size_t k = 0; k < side; ++k)
        for (std::size_t j = 0; j < side; ++j) c[i * side + j] += a[i * side + k] * b[k * side + j];
  }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    std::vector<S> product(x, x + area), next(area);
    for (std::size_t f = 1; f < factors; ++f) {
      multiply(product.data(), x + f * area, next.data());
      product.swap(next);
    }
    S total = 0;
    for (const S& element : product) total += element * element;
    return 0.5 * total;
  }
};

template <class T>
T hand_adjoint(const MatmulChain&, const T* x, T* gradient) {
  constexpr std::size_t side = MatmulChain::side, area = MatmulChain::area, factors = MatmulChain::factors;
  std::vector<T> products(factors * area), g(area), next(area);  // products[f] = A₀ … A_f
  std::copy_n(x, area, products.data());
  for (std::size_t f = 1; f < factors; ++f)
    MatmulChain::multiply(products.data() + (f - 1) * area, x + f * area, products.data() + f * area);
  std::copy_n(products.data() + (factors - 1) * area, area, g.data());
  T total = 0;
  for (const T element : g) total += element * element;
  std::vector<T> turned(area);
  const auto turn = [&](const T* matrix) {
    for (std::size_t i = 0; i < side; ++i)
      for (std::size_t j = 0; j < side; ++j) turned[j * side + i] = matrix[i * side + j];
  };
  for (std::size_t f = factors; f-- > 1;) {
    turn(products.data() + (f - 1) * area);
    MatmulChain::multiply(turned.data(), g.data(), gradient + f * area);
    turn(x + f * area);
    MatmulChain::multiply(g.data(), turned.data(), next.data());
    g.swap(next);
  }
  std::copy_n(g.data(), area, gradient);
  return total / 2;
}
}  // namespace tapestry::benchmarks
