#pragma once
#include <array>
#include <tapestry/autodiff/detail/tape/scalar.hpp>
#include <utility>

namespace tapestry {
/// A number that carries its derivatives in N directions through every function that Variable has: forward
/// mode, for functions of few inputs, with no tape and no memory.
///
///   Dual<double> x = Dual<double>::input(2.0);
///   auto y = x * x + sin(x);            // y.tangent() == 4 + cos(2)
///
/// T is a floating-point type, or a Dual for derivatives of derivatives. A Variable<Dual<double>> records
/// dual numbers on a Tape<Dual<double>>: forward over reverse, see derivatives.hpp.
///
/// Two derivatives taken one inside the other must not mix their directions up. Duals of different Tags are
/// different types: a sum of the two does not compile, unless one is the T of the other, and so a constant.
/// derivatives.hpp tags by the function that is differentiated.
///
/// On the tape as here, a zero passes nothing on or through: 0 · ∞ = 0 · NaN = 0 wherever slopes are
/// multiplied; see Tape::zero_products(). Comparisons look at the values only.
///
/// Second derivatives by hand, on a tape of duals or in duals of duals: at a tie of max() and min() they are
/// the mean of both sides, for clamp() and fdim() those of the side taken. Where |x|, a length or an angle
/// has the slope 0 at 0, a subgradient, they are NaN wherever they enter, also in products. An infinite slope
/// that meets a zero hides them, as first ones. hessian() and derivative() find more.
template <class T, std::size_t N = 1, class Tag = void>
class Dual {
  static_assert(
      detail::is_scalar<T> && N > 0,
      "a Dual holds floating-point numbers or Duals: for second derivatives record Duals on a tape, "
      "Variable<Dual<double>>, see derivatives.hpp");

 public:
  using value_type = T;
  static constexpr std::size_t direction_count = N;

  constexpr Dual() = default;
  /// A constant.
  template <std::convertible_to<T> X>
  requires(!std::same_as<X, Dual>) constexpr Dual(const X& value) : value_(static_cast<T>(value)) {}
  constexpr Dual(const T& value, const std::array<T, N>& tangents) : value_(value), tangents_(tangents) {}

  /// A number to differentiate by, along one of the directions.
  [[nodiscard]] static constexpr Dual input(const T& value, std::size_t direction = 0) {
    Dual dual(value);
    dual.tangents_[direction] = T(1);
    return dual;
  }

  [[nodiscard]] constexpr const T& value() const { return value_; }
  /// The derivative along one direction.
  [[nodiscard]] constexpr const T& tangent(std::size_t direction = 0) const { return tangents_[direction]; }
  /// The derivatives, one a direction.
  [[nodiscard]] constexpr const std::array<T, N>& tangents() const { return tangents_; }

  /// Whether value and tangents are all zero.
  [[nodiscard]] constexpr bool is_zero() const {
    bool all = detail::is_zero(value_);
    for (const T& tangent : tangents_) all = all && detail::is_zero(tangent);
    return all;
  }

  constexpr Dual& operator+=(const Dual& y) {
    value_ += y.value_;
    for (std::size_t k = 0; k < N; ++k) tangents_[k] += y.tangents_[k];
    return *this;
  }
  constexpr Dual& operator-=(const Dual& y) {
    value_ -= y.value_;
    for (std::size_t k = 0; k < N; ++k) tangents_[k] -= y.tangents_[k];
    return *this;
  }
  constexpr Dual& operator*=(const Dual& y) { return *this = *this * y; }
  constexpr Dual& operator/=(const Dual& y) { return *this = *this / y; }

  friend constexpr void swap(Dual& x, Dual& y) noexcept { std::swap(x, y); }

 private:
  T value_ = T(0);
  std::array<T, N> tangents_{};
};

/// The value alone, a constant.
template <class T, std::size_t N, class Tag>
[[nodiscard]] constexpr Dual<T, N, Tag> passive(const Dual<T, N, Tag>& x) {
  return x.value();
}

namespace detail {
/// A dual with each of its numbers changed by f.
template <class To, DualNumber D, class F>
[[nodiscard]] constexpr To changed(const D& x, F f) {
  auto tangents = To().tangents();
  for (std::size_t k = 0; k < D::direction_count; ++k) tangents[k] = f(x.tangent(k));
  return {f(x.value()), tangents};
}
template <class T, std::size_t N, class Tag>
[[nodiscard]] constexpr auto widened(const Dual<T, N, Tag>& x) {
  using Wide = Dual<decltype(widened(T())), N, Tag>;
  return changed<Wide>(x, [](const T& part) { return widened(part); });
}
template <DualNumber T, class Wide>
[[nodiscard]] constexpr T narrowed(const Wide& x) {
  return changed<T>(x, [](const auto& part) { return narrowed<typename T::value_type>(part); });
}
/// The scalar of sums of T: numbers are doubles.
template <class T>
using Widened = decltype(widened(T()));

/// Counts of a thread's operations on duals at kinks, ties, and infinite slopes: where slopes follow from a
/// rule, and slopes of slopes with them.
struct Kinks {
  std::size_t met = 0;
  std::size_t varying = 0;  ///< operations whose operands have tangents; without ties
};
[[nodiscard]] inline Kinks& kinks() {
  thread_local Kinks counts;
  return counts;
}
[[gnu::noinline, gnu::cold]] inline void note_kink(bool is_varying) {
  ++kinks().met;
  if (is_varying) ++kinks().varying;
}

template <DualNumber X>
[[nodiscard]] constexpr bool varies(const X& x) {
  return !X(typename X::value_type(0), x.tangents()).is_zero();
}

/// Notes if an operation on duals takes a side at a kink or has an infinite slope, given its operands: it
/// declares is_kink() of them.
template <class Operation, class... X>
constexpr void note_kink_of(const X&... x) {
  if constexpr ((DualNumber<X> && ...) && requires { Operation::is_kink(x...); })
    if (Operation::is_kink(x...)) [[unlikely]]
      note_kink((varies(x) || ...));
}

/// The number of f; its derivatives are NaN in each direction that changes an operand.
template <class T, class... X>
[[nodiscard, gnu::noinline, gnu::cold]] constexpr T unknown_along(const T& f, const X&... operands) {
  if constexpr (std::floating_point<T>) {
    return f;
  } else {
    auto tangents = f.tangents();
    for (std::size_t k = 0; k < T::direction_count; ++k)
      if (!(is_zero(operands.tangent(k)) && ...)) tangents[k] = unknown<typename T::value_type>();
    return {unknown_along(f.value(), operands.value()...), tangents};
  }
}

/// Value and slope of an operation at a kink where its slope is 0, a subgradient: for duals the derivatives
/// of that slope are unknown, not 0. A zero does not hide them, see chain().
template <class T, class... X>
[[nodiscard]] constexpr T value_at_kink([[maybe_unused]] bool is_kink, const T& f,
                                        [[maybe_unused]] const X&... operands) {
  if constexpr (DualNumber<T>)
    if (is_kink) [[unlikely]] {
      note_kink((varies(operands) || ...));
      return unknown_along(f, operands...);
    }
  return f;
}
template <class T>
[[nodiscard]] constexpr T slope_at_kink([[maybe_unused]] bool is_kink, const T& slope) {
  if constexpr (DualNumber<T>)
    if (is_kink) [[unlikely]]
      return unknown_along(slope, unknown<T>());
  return slope;
}

/// tangent · partial. A partial that is a plain number has no tangents of 0, which would turn ∞ into NaN.
template <class T, class Partial>
[[nodiscard]] constexpr T chain_with(const T& tangent, const Partial& partial) {
  if constexpr (std::same_as<T, Partial> && std::floating_point<T>) {
    return chain_in_sum(tangent, partial);
  } else if constexpr (std::same_as<T, Partial>) {
    return chain(tangent, partial);
  } else {
    auto inner = tangent.tangents();
    for (auto& of_tangent : inner) of_tangent = chain_with(of_tangent, partial);
    return {chain_with(tangent.value(), partial), inner};
  }
}

/// Adds partial · (tangents of x) to the tangents.
template <class Operation, class T, std::size_t N, class Partial>
constexpr void add_tangents(std::array<T, N>& tangents, const std::array<T, N>& from,
                            const Partial& partial) {
  if constexpr (SkipsZero<Operation>) {
    if (is_zero(partial)) return;
  }
  for (std::size_t k = 0; k < N; ++k) tangents[k] += chain_with(from[k], partial);
}

/// Whether the partial by an operand is a number that follows from the other, of type Other: the operation is
/// linear, and the other is a number or does not matter.
template <class Operation, class Other>
concept SlopeXIsNumber = requires {
  typename Operation::SlopeX;
}
|| (Number<Other> && requires { Operation::is_linear_in_x; });
template <class Operation, class Other>
concept SlopeYIsNumber = requires {
  typename Operation::SlopeY;
}
|| (Number<Other> && requires { Operation::is_linear_in_y; });

/// f(x), given f and its derivative at the value of x.
template <class Operation, class T, std::size_t N, class Tag, class Slope>
[[nodiscard]] constexpr Dual<T, N, Tag> dual_of(const Dual<T, N, Tag>& x, const T& value,
                                                const Slope& slope) {
  std::array<T, N> tangents{};
  add_tangents<Operation>(tangents, x.tangents(), slope);
  return {value, tangents};
}

/// Slope of an operation, given x and f(x). Where x is a dual, the slope's derivative is the operation's
/// curvature(x, f, slope), if it has one because partial() would cancel; else partial() of duals.
template <class Operation, class T>
[[nodiscard, gnu::always_inline]] constexpr auto slope_of(const T& x, const T& f) {
  if constexpr (DualNumber<T> && requires { Operation::curvature(x.value(), f.value(), f.value()); }) {
    const auto slope = slope_of<Operation>(x.value(), f.value());
    return dual_of<Operation>(x, slope, Operation::curvature(x.value(), f.value(), slope));
  } else {
    return Operation::partial(x, f);
  }
}

template <class Operation, class T, std::size_t N, class Tag>
[[nodiscard]] constexpr Dual<T, N, Tag> dual_unary(const Dual<T, N, Tag>& x) {
  const T value = Operation::value(x.value());
  note_kink_of<Operation>(x.value());
  if constexpr (requires { typename Operation::Slope; }) {
    return dual_of<Operation>(x, value, Operation::partial(Base<T>(0), Base<T>(0)));
  } else {
    return dual_of<Operation>(x, value, slope_of<Operation>(x.value(), value));
  }
}

/// One of x and y is a D, the other a D, or a constant that converts to the T of it.
template <class Operation, class D, class X, class Y>
[[nodiscard]] constexpr D dual_binary(const X& x, const Y& y) {
  using T = typename D::value_type;
  constexpr std::size_t n = D::direction_count;
  constexpr bool x_varies = std::same_as<X, D>;
  constexpr bool y_varies = std::same_as<Y, D>;
  const auto value_in = []<class Z>(const Z& z) {
    if constexpr (std::same_as<Z, D>) {
      return z.value();
    } else {
      return static_cast<T>(z);
    }
  };
  constexpr Base<T> zero = 0;
  const auto number_in = []<class Z>(const Z& z) {
    if constexpr (Number<Z>) {
      return static_cast<Base<T>>(z);
    } else {
      return Base<T>(0);  // does not matter
    }
  };
  const T a = value_in(x);
  const T b = value_in(y);
  const T value = Operation::value(a, b);
  note_kink_of<Operation>(a, b);
  std::array<T, n> tangents{};
  if constexpr (x_varies && SlopeXIsNumber<Operation, Y>) {
    add_tangents<Operation>(tangents, x.tangents(), Operation::partial_x(zero, number_in(y), zero));
  } else if constexpr (x_varies) {
    add_tangents<Operation>(tangents, x.tangents(), Operation::partial_x(a, b, value));
  }
  if constexpr (y_varies && SlopeYIsNumber<Operation, X>) {
    add_tangents<Operation>(tangents, y.tangents(), Operation::partial_y(number_in(x), zero, zero));
  } else if constexpr (y_varies) {
    add_tangents<Operation>(tangents, y.tangents(), Operation::partial_y(a, b, value));
  }
  return {value, tangents};
}
}  // namespace detail
}  // namespace tapestry
