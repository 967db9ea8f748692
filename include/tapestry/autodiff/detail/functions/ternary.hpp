#pragma once
#include <tapestry/autodiff/detail/functions/power.hpp>
#include <tapestry/autodiff/variable.hpp>

namespace tapestry {
namespace detail {
struct FusedMultiplyAdd {
  static auto value(auto x, auto y, auto z) { return fma(x, y, z); }
  template <class T>
  static std::array<T, 3> partials(const T& x, const T& y, const T&, const T&) {
    return {y, x, T(1)};
  }
};
struct Lerp {
  static auto value(auto x, auto y, auto t) { return lerp(x, y, t); }
  template <class T>
  static std::array<T, 3> partials(const T& x, const T& y, const T& t, const T&) {
    return {1 - t, t, y - x};
  }
};
struct Hypot3 {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y, auto z) {
    return value_at_kink(x == 0 && y == 0 && z == 0, decltype(x)(hypot(x, y, z)), x, y, z);
  }
  template <class T>
  static std::array<T, 3> partials(const T& x, const T& y, const T& z, const T& length) {
    return direction(std::array{x, y, z}, length);
  }
};

/// f(x, y, z), where Operation has value(x, y, z) and partials(x, y, z, f).
template <class Operation, class X, class Y, class Z>
class Ternary {
 public:
  using ExpressionScalar = typename X::ExpressionScalar;
  using T = ExpressionScalar;
  static_assert(std::is_same_v<T, typename Y::ExpressionScalar> &&
                    std::is_same_v<T, typename Z::ExpressionScalar>,
                "variables of float and double do not mix");
  static constexpr std::size_t operand_bound = X::operand_bound + Y::operand_bound + Z::operand_bound;
  template <class Factor>
  static constexpr OperandCounts operand_counts =
      counts_of_expression<X, Chained<Factor, T>>() + counts_of_expression<Y, Chained<Factor, T>>() +
      counts_of_expression<Z, Chained<Factor, T>>();
  static constexpr bool always_pushes_all =
      !SkipsZero<Operation> && pushes_all<X>() && pushes_all<Y>() && pushes_all<Z>();

  Ternary(const X& x, const Y& y, const Z& z)
      : x_(x), y_(y), z_(z), value_(Operation::value(x.value(), y.value(), z.value())) {
    note_kink_of<Operation>(x.value(), y.value(), z.value());
  }
  [[nodiscard]] T value() const { return value_; }
  [[nodiscard]] bool is_active() const { return x_.is_active() || y_.is_active() || z_.is_active(); }
  [[nodiscard]] std::uint64_t difference(Link link) const {
    return detail::difference(x_, link) | detail::difference(y_, link) | detail::difference(z_, link);
  }
  template <class Factor, class Sink>
  [[gnu::always_inline]] void push(Factor factor, Sink& sink) const {
    const std::array<T, 3> partials = Operation::partials(x_.value(), y_.value(), z_.value(), value_);
    if constexpr (X::operand_bound != 0) push_partial<Operation>(x_, factor, partials[0], sink);
    if constexpr (Y::operand_bound != 0) push_partial<Operation>(y_, factor, partials[1], sink);
    if constexpr (Z::operand_bound != 0) push_partial<Operation>(z_, factor, partials[2], sink);
  }

 private:
  X x_;
  Y y_;
  Z z_;
  T value_;
};

template <class Operation, class T, class X, class Y, class Z>
[[nodiscard]] auto expression_ternary(const X& x, const Y& y, const Z& z) {
  const auto a = as_expression<T>(x);
  const auto b = as_expression<T>(y);
  const auto c = as_expression<T>(z);
  return Ternary<Operation, std::remove_const_t<decltype(a)>, std::remove_const_t<decltype(b)>,
                 std::remove_const_t<decltype(c)>>(a, b, c);
}

template <class Operation, class D>
[[nodiscard]] D dual_ternary(const D& x, const D& y, const D& z) {
  using T = typename D::value_type;
  const T value = Operation::value(x.value(), y.value(), z.value());
  note_kink_of<Operation>(x.value(), y.value(), z.value());
  const std::array<T, 3> partials = Operation::partials(x.value(), y.value(), z.value(), value);
  auto tangents = D(0).tangents();
  add_tangents<Operation>(tangents, x.tangents(), partials[0]);
  add_tangents<Operation>(tangents, y.tangents(), partials[1]);
  add_tangents<Operation>(tangents, z.tangents(), partials[2]);
  return {value, tangents};
}

template <class X, class Y, class Z>
struct TernaryScalar;
template <class X, class Y, class Z>
requires FormulaOperands<X, Y>
struct TernaryScalar<X, Y, Z> : FormulaScalar<X, Y> {
};
template <class X, class Y, class Z>
requires(!FormulaOperands<X, Y> && FormulaOperands<Y, Z>) struct TernaryScalar<X, Y, Z>
    : FormulaScalar<Y, Z> {
};
template <class X, class Y, class Z>
requires(!FormulaOperands<X, Y> && !FormulaOperands<Y, Z> &&
         FormulaOperands<X, Z>) struct TernaryScalar<X, Y, Z> : FormulaScalar<X, Z> {
};

template <class X, class Y, class Z>
concept TernaryOperands = requires {
  typename TernaryScalar<X, Y, Z>::type;
};

template <class Operation, class X, class Y, class Z>
[[nodiscard]] auto make_ternary(const X& x, const Y& y, const Z& z) {
  using T = typename TernaryScalar<X, Y, Z>::type;
  if constexpr (ScalarExpression<X> || ScalarExpression<Y> || ScalarExpression<Z>) {
    return expression_ternary<Operation, T>(x, y, z);
  } else {
    return dual_ternary<Operation, T>(T(x), T(y), T(z));
  }
}
}  // namespace detail

/// x · y + z, rounded once.
template <class X, class Y, detail::TernaryOperands<X, Y> Z>
[[nodiscard]] auto fma(const X& x, const Y& y, const Z& z) {
  return detail::make_ternary<detail::FusedMultiplyAdd>(x, y, z);
}

/// x + t · (y − x), as std::lerp: exactly x at t = 0 and y at t = 1.
template <class X, class Y, detail::TernaryOperands<X, Y> Z>
[[nodiscard]] auto lerp(const X& x, const Y& y, const Z& t) {
  return detail::make_ternary<detail::Lerp>(x, y, t);
}

/// √(x² + y² + z²) without overflow. At the origin all derivatives are 0, a subgradient.
template <class X, class Y, detail::TernaryOperands<X, Y> Z>
[[nodiscard]] auto hypot(const X& x, const Y& y, const Z& z) {
  return detail::make_ternary<detail::Hypot3>(x, y, z);
}
}  // namespace tapestry
