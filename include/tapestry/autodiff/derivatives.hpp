#pragma once
#include <iterator>
#include <tapestry/autodiff/detail/jacobian/second_derivatives.hpp>
#include <tapestry/autodiff/detail/tape/spare_tape.hpp>
#include <tapestry/autodiff/functions.hpp>

namespace tapestry {
// Derivatives of a function of one number, f(x), or of many, f(std::span<const S>), written for any scalar
// type S. The duals are tagged by the function's own type, so that a derivative taken inside another cannot
// mix up its directions with the outer one's: such a mixture does not compile.

/// Point of differentiation: contiguous numbers, or a list in braces, which lives as long as the call.
template <class T>
struct Point : std::span<const T> {
  using std::span<const T>::span;
  Point(std::span<const T> numbers) : std::span<const T>(numbers) {}
  Point(std::initializer_list<T> numbers) : std::span<const T>(numbers.begin(), numbers.size()) {}
};

/// f(x) and f′(x).
template <class T>
struct ValueAndDerivative {
  T value;
  T derivative;
};

/// f(x) and its first derivatives.
template <class T>
struct DenseJacobian {
  std::size_t rows = 0;     ///< results of f
  std::size_t columns = 0;  ///< inputs of f
  std::vector<T> entries;   ///< d f[i] / d x[j] at [i · columns + j]
  std::vector<T> values;    ///< f(x), [rows]

  /// d f[i] / d x[j]
  [[nodiscard]] const T& operator()(std::size_t i, std::size_t j) const { return entries[i * columns + j]; }
};

namespace detail {
/// Whether a scalar is a Dual of numbers: the derivative of a derivative is then asked for.
template <class T>
inline constexpr bool carries_numbers = false;
template <std::floating_point T, std::size_t N, class Tag>
inline constexpr bool carries_numbers<Dual<T, N, Tag>> = requires(Dual<T, N, Tag> x) {
  x.tangents().size();
};

/// found_at(x), with the derivative's tangents at kinks as in hessian().
template <class D, class FoundAt>
[[nodiscard]] ValueAndDerivative<D> known_derivative(const D& x, FoundAt found_at) {
  using T = typename D::value_type;
  const std::size_t before = kinks().met;
  ValueAndDerivative<D> found = found_at(x);
  if (kinks().met == before) return found;
  const auto evaluate = [&](const std::vector<T>& at) {
    const auto [value, slope] = found_at(D(at[0], x.tangents()));
    return Curvature<T>{value.value(), {slope.value()}, {slope.tangents().begin(), slope.tangents().end()}};
  };
  const auto known = known_curvature<T>({&x.value(), 1}, evaluate, [](std::size_t) {
                       return std::pair<std::size_t, std::size_t>(0, 0);
                     }).second;
  auto tangents = x.tangents();
  std::copy(known.begin(), known.end(), tangents.begin());
  found.derivative = D(found.derivative.value(), tangents);
  return found;
}

inline void require_as_many(const char* operation, const char* what, std::size_t found,
                            std::size_t expected) {
  if (found != expected)
    throw DomainError({operation, ": ", found, " entries of ", what, ", expected ", expected});
}

/// Records f on a tape of duals, calls `seed(i)` for the tangents of input i, sweeps back, and calls
/// `take(i, adjoint of input i)`. Returns the root.
template <class D, class Function, class T, class Seed, class Take>
D sweep_duals(Tape<D>& tape, const Function& f, std::span<const T> x, Seed seed, Take take) {
  const auto scope = tape.activate();
  tape.clear();
  std::vector<Variable<D>> inputs;
  inputs.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) inputs.push_back(tape.input(D(x[i], seed(i))));
  const Variable<D> root = f(std::span<const Variable<D>>(inputs));
  tape.reverse(root);
  for (std::size_t i = 0; i < x.size(); ++i) take(i, tape.adjoint(inputs[i]));
  return root.value();
}

/// Results of a function and columns of a Jacobian that one call with duals computes.
inline constexpr std::size_t columns_a_call = 8;

/// Results of a function, a range or one number, in its scalar type S.
template <class S, class Found>
[[nodiscard]] std::vector<S> results_of(const Found& found) {
  if constexpr (std::convertible_to<const Found&, S>)
    return {S(found)};
  else
    return std::vector<S>(std::begin(found), std::end(found));
}

/// Calls f with duals, columns_a_call columns a call and at least once.
/// \throws DomainError if f returns another number of results from one call to the next
template <std::floating_point T, class Function>
[[nodiscard]] DenseJacobian<T> jacobian_by_duals(const Function& f, std::span<const T> x) {
  using D = Dual<T, columns_a_call, Function>;
  DenseJacobian<T> result;
  result.columns = x.size();
  std::size_t first = 0;
  do {
    const std::size_t count = std::min(columns_a_call, x.size() - first);
    std::vector<D> inputs(x.begin(), x.end());
    for (std::size_t k = 0; k < count; ++k) inputs[first + k] = D::input(x[first + k], k);
    const std::vector<D> found = results_of<D>(f(std::span<const D>(inputs)));
    if (first == 0) {
      result.rows = found.size();
      result.values.resize(result.rows);
      result.entries.resize(result.rows * x.size());
    }
    require_as_many("jacobian", "the result in a later call", found.size(), result.rows);
    for (std::size_t i = 0; i < result.rows; ++i) {
      result.values[i] = found[i].value();
      for (std::size_t k = 0; k < count; ++k) result.entries[i * x.size() + first + k] = found[i].tangent(k);
    }
    first += columns_a_call;
  } while (first < x.size());
  return result;
}
}  // namespace detail

/// f′ at x, in forward mode. To differentiate inside a function that is itself differentiated, take x in the
/// scalar type of that function.
template <class Function, Scalar T>
[[nodiscard]] ValueAndDerivative<T> derivative(const Function& f, const T& x) {
  const auto found_at = [&](const T& at) {
    const Dual<T, 1, Function> y = f(Dual<T, 1, Function>::input(at));
    return ValueAndDerivative<T>{y.value(), y.tangent()};
  };
  if constexpr (detail::carries_numbers<T>) return detail::known_derivative(x, found_at);
  return found_at(x);
}

/// Refuses a Variable. The tape gives its derivative.
template <class Function, ScalarExpression X>
void derivative(const Function&, const X&) {
  static_assert(detail::is_scalar<X>,
                "derivative() takes a number or a Dual: record f(x) and call Tape::reverse() for a Variable");
}

/// Result of gradient().
template <class T>
struct ValueAndGradient {
  T value;
  std::vector<T> gradient;
};

/// Value and gradient, from a tape of its own. It leaves up to 128 MiB of its memory to the thread's next
/// call.
template <std::floating_point T = double, class Function>
[[nodiscard]] ValueAndGradient<T> gradient(const Function& f, Point<std::type_identity_t<T>> x) {
  detail::SpareTape<T> tape;
  const auto scope = tape->activate();
  const std::span<const Variable<T>> inputs = tape.input(x);
  const Variable<T> root = f(inputs);
  tape->reverse(root);
  ValueAndGradient<T> result{root.value(), std::vector<T>(x.size())};
  tape->adjoints(inputs, result.gradient);
  return result;
}

/// f(x), ∇f(x), and ∇²f(x)·v; see hessian() for unknown entries.
template <class T>
struct HessianProduct {
  T value;
  std::vector<T> gradient;
  SecondDerivatives<T> product;
};

/// Products of the Hessian of one function with directions, and its gradient: forward over reverse, on a tape
/// of duals that is kept from call to call, at about twice the cost of a gradient.
///
///   HessianProducts products(f);
///   const auto [value, gradient, product] = products(x, v);
template <class Function, std::floating_point T = double>
class HessianProducts {
  using D = Dual<T, 1, Function>;

 public:
  explicit HessianProducts(Function f) : f_(std::move(f)) {}

  /// \throws DomainError if v and x differ in size
  [[nodiscard]] HessianProduct<T> operator()(Point<T> x, Point<T> v) {
    detail::require_as_many("hessian_product", "the direction", v.size(), x.size());
    const auto evaluate = [&](const std::vector<T>& at) {
      detail::Curvature<T> found{T(0), std::vector<T>(at.size()), SecondDerivatives<T>(at.size())};
      const D root = detail::sweep_duals<D>(
          tape_, f_, std::span<const T>(at), [&](std::size_t i) { return std::array<T, 1>{v[i]}; },
          [&](std::size_t i, const D& adjoint) {
            found.gradient[i] = adjoint.value();
            found.second[i] = adjoint.tangent();
          });
      found.value = root.value();
      return found;
    };
    auto found = detail::known_curvature<T>(x, evaluate, [](std::size_t i) { return std::pair(i, i); });
    return {found.value, std::move(found.gradient), std::move(found.second)};
  }

 private:
  Function f_;
  Tape<D> tape_;
};

/// The same once, on a tape of its own. \throws DomainError if v and x differ in size
template <std::floating_point T = double, class Function>
[[nodiscard]] HessianProduct<T> hessian_product(const Function& f, Point<std::type_identity_t<T>> x,
                                                Point<std::type_identity_t<T>> v) {
  return HessianProducts<Function, T>(f)(x, v);
}

/// The Hessian at x, exact but for rounding, row by row: [n·n]. Eight columns a sweep.
///
/// A second derivative that is not known is NaN, and counted in `unknown`. Where f has a kink or an infinite
/// slope, as |x| and √x at 0, first derivatives do not decide the second ones: f is computed anew at some
/// dozens of points around x, a few roundings away. Second derivatives that agree there are the Hessian, as 2
/// for |x|² and the identity for half of norm(x)². Where the gradient jumps or they differ, there is none.
/// The same for hessian_product(), HessianProducts and sparse_hessian(), and for a derivative() within a
/// derivative(). Duals of duals by hand, and tapes of duals, use x alone; see Dual for their rule.
///
///   const auto h = hessian(f, x);
///   if (h.unknown > 0) throw NumericError(h.description());
template <std::floating_point T = double, class Function>
[[nodiscard]] SecondDerivatives<T> hessian(const Function& f, Point<std::type_identity_t<T>> x) {
  constexpr std::size_t width = 8;
  using D = Dual<T, width, Function>;
  const std::size_t n = x.size();
  Tape<D> tape;
  const auto evaluate = [&](const std::vector<T>& at) {
    detail::Curvature<T> found{T(0), std::vector<T>(n), SecondDerivatives<T>(n * n)};
    for (std::size_t first = 0; first < n; first += width) {
      const auto seed = [&](std::size_t i) {
        std::array<T, width> tangents{};
        if (i >= first && i < first + width) tangents[i - first] = T(1);
        return tangents;
      };
      const D root =
          detail::sweep_duals<D>(tape, f, std::span<const T>(at), seed, [&](std::size_t i, const D& adjoint) {
            found.gradient[i] = adjoint.value();
            for (std::size_t k = 0; k < width && first + k < n; ++k)
              found.second[i * n + first + k] = adjoint.tangent(k);
          });
      found.value = root.value();
    }
    return found;
  };
  return detail::known_curvature<T>(x, evaluate, [n](std::size_t e) { return std::pair(e / n, e % n); })
      .second;
}

/// The Jacobian at x of f: span<const S> → range of S, row by row: [outputs · inputs]. Forward mode, eight
/// columns a call: for functions of no more inputs than outputs.
/// \throws DomainError if f returns another number of results from one call to the next
template <std::floating_point T = double, class Function>
[[nodiscard]] std::vector<T> forward_jacobian(const Function& f, Point<std::type_identity_t<T>> x) {
  return detail::jacobian_by_duals<T>(f, x).entries;
}
}  // namespace tapestry
