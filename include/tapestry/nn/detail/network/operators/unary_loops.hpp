#pragma once
#include <tapestry/core/block_loop.hpp>
#include <tapestry/nn/detail/network/operators/piecewise_functions.hpp>

namespace tapestry::nn {
/// Loops of a function of one number, see unary_functions.hpp.
template <std::floating_point T>
struct UnaryLoops {
  void (*forward)(const T* x, T* y, std::size_t count, T a, T b) = nullptr;
  /// dx[i] = dy[i] · slope, computed from `kept`; dx may be dy.
  void (*adjoint)(const T* kept, const T* dy, T* dx, std::size_t count, T a, T b) = nullptr;
  unary::Reads reads = unary::Reads::nothing;
  bool is_test = false;  ///< results are truths
  /// y = f(x) and v = f'(x)·u.
  void (*with_tangent)(const T* x, const T* u, T* y, T* v, std::size_t count, T a, T b) = nullptr;
  /// dx = f'·dy + f''·u·dv and du = f'·dv, computed from `kept`; dx may be dy, and du dv.
  void (*tangent_adjoint)(const T* kept, const T* u, const T* dy, const T* dv, T* dx, T* du,
                          std::size_t count, T a, T b) = nullptr;
};

namespace detail {
/// Calls body(i) for each element, side by side if the function is one of vectors.
template <class F, class Body>
void for_each_element(std::size_t count, const Body& body) {
  if constexpr (F::is_vector) {
    tapestry::detail::for_block<16>(count, body);
  } else {
    for (std::size_t i = 0; i < count; ++i) body(i);
  }
}

template <class F, std::floating_point T>
void unary_forward(const T* x, T* y, std::size_t count, T a, T b) {
  struct Body {
    const T* x;
    T* y;
    T a, b;
    [[gnu::always_inline]] void operator()(std::size_t i) const { y[i] = F::value(x[i], a, b); }
  };
  for_each_element<F>(count, Body{x, y, a, b});
}

template <class F, std::floating_point T>
void unary_adjoint(const T* kept, const T* dy, T* dx, std::size_t count, T a, T b) {
  struct Body {
    const T *kept, *dy;
    T* dx;
    T a, b;
    [[gnu::always_inline]] void operator()(std::size_t i) const { dx[i] = dy[i] * F::slope(kept[i], a, b); }
  };
  for_each_element<F>(count, Body{kept, dy, dx, a, b});
}

template <class F, std::floating_point T>
void unary_with_tangent(const T* x, const T* u, T* y, T* v, std::size_t count, T a, T b) {
  struct Body {
    const T *x, *u;
    T *y, *v;
    T a, b;
    [[gnu::always_inline]] void operator()(std::size_t i) const {
      const T value = F::value(x[i], a, b);
      v[i] = F::slope(F::reads == unary::Reads::output ? value : x[i], a, b) * u[i];
      y[i] = value;
    }
  };
  for_each_element<F>(count, Body{x, u, y, v, a, b});
}

template <class F, std::floating_point T>
void unary_tangent_adjoint(const T* kept, const T* u, const T* dy, const T* dv, T* dx, T* du,
                           std::size_t count, T a, T b) {
  struct Body {
    const T *kept, *u, *dy, *dv;
    T *dx, *du;
    T a, b;
    [[gnu::always_inline]] void operator()(std::size_t i) const {
      const T own = dv[i], slope = F::slope(kept[i], a, b);
      dx[i] = slope * dy[i] + F::curvature(kept[i], a, b) * u[i] * own;
      du[i] = slope * own;
    }
  };
  for_each_element<F>(count, Body{kept, u, dy, dv, dx, du, a, b});
}

template <class F, std::floating_point T>
[[nodiscard]] UnaryLoops<T> unary_loops() {
  UnaryLoops<T> loops{
      &unary_forward<F, T>, nullptr, F::reads,
      std::same_as<F, unary::Not<T>> || std::same_as<F, unary::IsNan<T>> || std::same_as<F, unary::IsInf<T>>};
  if constexpr (F::reads != unary::Reads::no_derivative) loops.adjoint = &unary_adjoint<F, T>;
  if constexpr (F::reads == unary::Reads::input || F::reads == unary::Reads::output) {
    loops.with_tangent = &unary_with_tangent<F, T>;
    loops.tangent_adjoint = &unary_tangent_adjoint<F, T>;
  }
  return loops;
}
}  // namespace detail
}  // namespace tapestry::nn
