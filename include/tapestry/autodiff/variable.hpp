#pragma once
#include <tapestry/autodiff/detail/functions/arithmetic.hpp>
#include <tapestry/autodiff/detail/tape/write_statement.hpp>
#include <tapestry/autodiff/tape.hpp>

namespace tapestry {
/// A scalar that a tape can differentiate by. Numbers convert to passive variables, which cost no tape.
/// Formulas of variables are evaluated and recorded, as one statement, when they become a Variable. Write
/// `Variable<T> y = x * x;`, since `auto` would keep the formula (safely, by value) and evaluate it anew
/// wherever it is used. Copies share their record; a moved-from variable keeps its value.
template <class T>
class Variable {
  static_assert(Scalar<T>);

 public:
  using ExpressionScalar = T;
  using value_type = T;
  static constexpr std::size_t operand_bound = 1;
  template <class Factor>
  static constexpr detail::OperandCounts operand_counts{
      std::same_as<Factor, detail::One>, std::same_as<Factor, detail::MinusOne>, std::same_as<Factor, T>};
  static constexpr bool always_pushes_all = true;

  constexpr Variable() = default;
  template <detail::ConstantOf<T> N>
  constexpr Variable(const N& value) : value_(static_cast<T>(value)) {}

  /// Records the formula as one statement of the active tape; a passive formula records nothing. Always
  /// inlined, as are updates: the formula then stays in registers.
  /// \throws DomainError if the formula is active but no tape is, or it uses a variable not on the tape
  template <ScalarExpression E>
  requires(!std::same_as<E, Variable> && std::same_as<typename E::ExpressionScalar, T>)
      [[gnu::always_inline]] Variable(const E& formula)
      : value_(formula.value()) {
    detail::record_statement(formula, link_);
  }

  /// For operations with records of their own; record.hpp is more convenient.
  constexpr Variable(T value, detail::Link link) : value_(value), link_(link) {}

  [[nodiscard]] constexpr T value() const { return value_; }

  /// Whether the variable is on a tape.
  [[nodiscard]] constexpr bool is_active() const { return link_.is_active(); }

  /// d root / d variable of the last reverse() of the active tape; zero before it and for passive variables.
  /// \throws DomainError if the variable is active but not on the active tape; see also Tape::adjoint()
  [[nodiscard]] T adjoint() const {
    if (!is_active()) return T(0);
    const detail::WriteHead& head = *detail::TapeState<T>::active;
    if (head.next.generation() == link_.generation()) [[likely]]
      return static_cast<const detail::TapeState<T>&>(head).adjoint(link_);
    return detail::TapeState<T>::require_active().adjoint(link_);
  }

  template <detail::OperandBeside<T> Y>
  [[gnu::always_inline]] Variable& operator+=(const Y& y) {
    return *this = *this + y;
  }
  template <detail::OperandBeside<T> Y>
  [[gnu::always_inline]] Variable& operator-=(const Y& y) {
    return *this = *this - y;
  }
  template <detail::OperandBeside<T> Y>
  [[gnu::always_inline]] Variable& operator*=(const Y& y) {
    return *this = *this * y;
  }
  template <detail::OperandBeside<T> Y>
  [[gnu::always_inline]] Variable& operator/=(const Y& y) {
    return *this = *this / y;
  }

  friend constexpr void swap(Variable& x, Variable& y) noexcept { std::swap(x, y); }

  /// The place where it was recorded.
  [[nodiscard]] constexpr detail::Link link() const { return link_; }
  [[nodiscard]] constexpr std::uint64_t difference(detail::Link link) const { return link_.difference(link); }
  template <class Factor, class Sink>
  [[gnu::always_inline]] void push(Factor factor, Sink& sink) const {
    sink.add(link_, factor);
  }

 private:
  T value_ = T(0);
  detail::Link link_;
};

/// A passive variable of the same value, which stops the gradient.
template <template <class...> class Formula, class... Parts>
requires ScalarExpression<Formula<Parts...>>
[[nodiscard]] auto passive(const Formula<Parts...>& formula) {
  return Variable<typename Formula<Parts...>::ExpressionScalar>(formula.value());
}

/// Refuses a value that would be a constant on a tape of duals.
template <DualNumber T, std::convertible_to<T> Value>
requires(!std::same_as<Value, T>) Variable<T> record_partials(const Value& value,
                                                              std::span<const Variable<T>>,
                                                              std::span<const T>) {
  static_assert(DualNumber<Value>,
                "on a tape of duals, record_partials() takes the value as a dual, with its tangents; a plain "
                "number is a constant");
  return T(value);
}

/// A scalar operation with partial derivatives already known, d value / d variables[i] = partials[i], as
/// one statement of the active tape.
/// \throws DomainError if there are not as many partials as variables, and as Variable's constructor
template <class T>
[[nodiscard]] Variable<T> record_partials(T value, std::span<const Variable<T>> variables,
                                          std::span<const T> partials) {
  if (variables.size() != partials.size())
    throw DomainError(
        {"record_partials: ", partials.size(), " partials for ", variables.size(), " variables"});
  bool is_active = false;
  for (const Variable<T>& variable : variables) is_active = is_active || variable.is_active();
  if (!is_active) return value;
  detail::TapeState<T>& state = detail::TapeState<T>::require_active();
  const detail::Link link = state.append_linear(
      variables.size(), [&](std::size_t i) { return variables[i].link(); }, partials.data());
  state.note_value(link, static_cast<double>(detail::value_of<detail::Base<T>>(value)));
  return {value, link};
}
}  // namespace tapestry
