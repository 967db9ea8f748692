#pragma once
#include <tapestry/autodiff/detail/tape/dual_number.hpp>
#include <tapestry/autodiff/detail/tape/operand_counts.hpp>

namespace tapestry {
/// A Variable, or a formula of Variables and numbers that has not been assigned to one yet.
/// It has value(), is_active(), and push(factor, sink), which hands factor · (partial derivative by v) to
/// the sink for each variable v in it, at most operand_bound times.
template <class E>
concept ScalarExpression = requires {
  typename std::remove_cvref_t<E>::ExpressionScalar;
};

/// A differentiable number: a Variable, a formula of Variables, or a Dual.
template <class E>
concept Differentiable = ScalarExpression<E> || DualNumber<E>;

template <class T, std::size_t Rank>
class ArrayVariable;

namespace detail {
template <class X>
inline constexpr bool is_array_variable = false;
template <class T, std::size_t Rank>
inline constexpr bool is_array_variable<ArrayVariable<T, Rank>> = true;
}  // namespace detail

/// A formula of array variables that has not been assigned to one yet. It has the scalar type, the rank,
/// extents, and its variables, in order, as leaves().
template <class E>
concept ArrayExpression = requires {
  typename std::remove_cvref_t<E>::ArrayScalar;
};

/// An array variable or a formula of array variables.
template <class X>
concept DifferentiableArray = detail::is_array_variable<std::remove_cvref_t<X>> || ArrayExpression<X>;

template <Differentiable X>
X& operator++(X& x) {
  return x += 1;
}
template <Differentiable X>
X& operator--(X& x) {
  return x -= 1;
}
template <Differentiable X>
X operator++(X& x, int) {
  return std::exchange(x, x + 1);
}
template <Differentiable X>
X operator--(X& x, int) {
  return std::exchange(x, x - 1);
}

namespace detail {
template <class X, class T>
concept ConvertibleDual = DualNumber<X> && std::convertible_to<X, T>;

/// A constant of scalar type T: a number, or a dual that is T or converts to it.
template <class X, class T>
concept ConstantOf = Number<X> || ConvertibleDual<X, T>;

/// Operand of an operator beside a Variable<T>.
template <class Y, class T>
concept OperandBeside = ScalarExpression<Y> || ConstantOf<Y, T>;

template <class T>
class ConstantLeaf {
 public:
  using ExpressionScalar = T;
  static constexpr std::size_t operand_bound = 0;
  explicit constexpr ConstantLeaf(T value) : value_(value) {}
  [[nodiscard]] constexpr T value() const { return value_; }
  template <class Factor>
  static constexpr OperandCounts operand_counts{};
  static constexpr bool always_pushes_all = true;
  [[nodiscard]] constexpr bool is_active() const { return false; }
  [[nodiscard]] constexpr std::uint64_t difference(Link) const { return 0; }
  template <class Factor, class Sink>
  [[gnu::always_inline]] constexpr void push(Factor, Sink&) const {}

 private:
  T value_;
};

/// \param factor   a number, One or MinusOne
/// \param partial  likewise
template <class Operation, class Operand, class Factor, class Partial, class Sink>
[[gnu::always_inline]] inline void push_partial(const Operand& operand, const Factor& factor,
                                                const Partial& partial, Sink& sink) {
  if constexpr (SkipsZero<Operation>) {
    if (is_zero(partial)) return;
  }
  push_factor(operand, chain_slopes(factor, partial), sink);
}

/// f(x), where Operation is a row of functions/, see slope_of().
template <class Operation, class X>
class Unary {
 public:
  using ExpressionScalar = typename X::ExpressionScalar;
  using T = ExpressionScalar;
  using Slope = typename SlopeOf<Operation, T>::type;
  static constexpr std::size_t operand_bound = X::operand_bound;
  template <class Factor>
  static constexpr OperandCounts operand_counts = counts_of_expression<X, Chained<Factor, Slope>>();
  static constexpr bool always_pushes_all = !SkipsZero<Operation> && pushes_all<X>();

  [[gnu::always_inline]] Unary(const Unary& o) : x_(o.x_), value_(o.value_) {}
  explicit Unary(const X& x) : x_(x), value_(Operation::value(x.value())) {
    note_kink_of<Operation>(x.value());
  }
  [[nodiscard]] T value() const { return value_; }
  [[nodiscard]] bool is_active() const { return x_.is_active(); }
  [[nodiscard]] std::uint64_t difference(Link link) const { return detail::difference(x_, link); }
  template <class Factor, class Sink>
  [[gnu::always_inline]] void push(Factor factor, Sink& sink) const {
    if constexpr (std::is_same_v<Slope, T>) {
      push_partial<Operation>(x_, factor, slope_of<Operation>(x_.value(), value_), sink);
    } else {
      push_partial<Operation>(x_, factor, Slope{}, sink);
    }
  }

 private:
  X x_;
  T value_;
};

template <class X>
inline constexpr bool is_leaf = requires(const X& x) {
  x.link();
};

/// f(x, y), where Operation has value(x, y), partial_x(x, y, f) and partial_y(x, y, f).
template <class Operation, class X, class Y>
class Binary {
 public:
  using ExpressionScalar = typename X::ExpressionScalar;
  using T = ExpressionScalar;
  using SlopeX = typename SlopesOf<Operation, T>::X;
  using SlopeY = typename SlopesOf<Operation, T>::Y;
  static_assert(std::is_same_v<T, typename Y::ExpressionScalar>, "variables of float and double do not mix");
  static constexpr std::size_t operand_bound = X::operand_bound + Y::operand_bound;
  template <class Factor>
  static constexpr OperandCounts operand_counts =
      counts_of_expression<X, Chained<Factor, SlopeX>>() + counts_of_expression<Y, Chained<Factor, SlopeY>>();
  static constexpr bool always_pushes_all = !SkipsZero<Operation> && pushes_all<X>() && pushes_all<Y>();

  [[gnu::always_inline]] Binary(const Binary& o) : x_(o.x_), y_(o.y_), value_(o.value_) {}
  Binary(const X& x, const Y& y) : x_(x), y_(y), value_(Operation::value(x.value(), y.value())) {
    note_kink_of<Operation>(x.value(), y.value());
  }
  [[nodiscard]] T value() const { return value_; }
  [[nodiscard]] bool is_active() const { return x_.is_active() || y_.is_active(); }
  [[nodiscard]] std::uint64_t difference(Link link) const {
    return detail::difference(x_, link) | detail::difference(y_, link);
  }
  template <class Factor, class Sink>
  [[gnu::always_inline]] void push(Factor factor, Sink& sink) const {
    if constexpr (X::operand_bound != 0) push_partial<Operation>(x_, factor, slope_x(), sink);
    if constexpr (Y::operand_bound != 0) push_partial<Operation>(y_, factor, slope_y(), sink);
  }

 private:
  [[nodiscard]] SlopeX slope_x() const {
    if constexpr (std::is_same_v<SlopeX, T>) {
      if constexpr (is_leaf<X> && !requires { Operation::is_linear_in_y; })
        if (!x_.is_active()) return T(0);
      return Operation::partial_x(x_.value(), y_.value(), value_);
    } else {
      return {};
    }
  }
  [[nodiscard]] SlopeY slope_y() const {
    if constexpr (std::is_same_v<SlopeY, T>) {
      if constexpr (is_leaf<Y> && !requires { Operation::is_linear_in_y; })
        if (!y_.is_active()) return T(0);
      return Operation::partial_y(x_.value(), y_.value(), value_);
    } else {
      return {};
    }
  }

  X x_;
  Y y_;
  T value_;
};
}  // namespace detail
}  // namespace tapestry
