#pragma once
#include <tapestry/autodiff/variable.hpp>

// Functions and traits of variables for Boost.Math and Boost.Odeint; to be included before their headers,
// and including none of them.

namespace tapestry {
namespace detail {
/// \throws NumericError if the whole number does not fit Integer, or is not a number
template <std::integral Integer, std::floating_point T>
[[nodiscard]] Integer whole_number(const char* operation, T truncated) {
  constexpr auto low = static_cast<T>(std::numeric_limits<Integer>::min());  // a power of two, exact
  if (!(truncated >= low && truncated < -low))
    throw NumericError({operation, ": ", truncated, " does not fit an integer"});
  return static_cast<Integer>(truncated);
}
}  // namespace detail

/// The whole part of a variable's value, which has no derivative. Boost.Math finds these overloads by their
/// arguments.
/// \throws NumericError if it does not fit
template <std::floating_point T, class Policy>
[[nodiscard]] int itrunc(const Variable<T>& x, const Policy&) {
  return detail::whole_number<int>("itrunc", std::trunc(x.value()));
}
template <std::floating_point T, class Policy>
[[nodiscard]] long long lltrunc(const Variable<T>& x, const Policy&) {
  return detail::whole_number<long long>("lltrunc", std::trunc(x.value()));
}
template <std::floating_point T, class Policy>
[[nodiscard]] int iround(const Variable<T>& x, const Policy&) {
  return detail::whole_number<int>("iround", std::round(x.value()));
}
}  // namespace tapestry

namespace boost::math::tools {
template <class T>
struct promote_arg;

/// Results are variables also where the argument is a formula, such as −x.
template <tapestry::ScalarExpression Formula>
struct promote_arg<Formula> {
  using type = tapestry::Variable<typename Formula::ExpressionScalar>;
};

/// A polynomial in a formula, computed in the variable that the formula becomes; Boost would compute it in
/// the formula's type.
template <std::size_t N, class Coefficient, class Formula>
requires tapestry::ScalarExpression<Formula> &&
    (!std::same_as<Formula, tapestry::Variable<typename Formula::ExpressionScalar>>)
        tapestry::Variable<typename Formula::ExpressionScalar> evaluate_polynomial(
            const Coefficient (&coefficients)[N], const Formula& x) {
  const tapestry::Variable<typename Formula::ExpressionScalar> variable = x;
  tapestry::Variable<typename Formula::ExpressionScalar> sum = coefficients[N - 1];
  for (std::size_t i = N - 1; i-- > 0;) sum = sum * variable + coefficients[i];
  return sum;
}

/// Refuses the bracket of a bisection, which has no derivative: its ends are halves of the first bracket, and
/// depend on the function by comparisons alone.
template <class Function, tapestry::Differentiable T, class Tolerance, class Policy>
std::pair<T, T> bisect(Function, T low, T high, Tolerance, std::uintmax_t&, const Policy&) {
  static_assert(!tapestry::Differentiable<T>,
                "bisect() has no derivative: find the root in plain numbers, and pass it to "
                "tapestry::implicit_function()");
  return {low, high};
}
}  // namespace boost::math::tools

namespace boost::numeric::odeint {
template <class State, class Enabler>
struct norm_result_type;

/// Norm of a state of variables: a controlled stepper computes its step from it.
template <class State>
requires tapestry::ScalarExpression<typename State::value_type>
struct norm_result_type<State, void> {
  using type = typename State::value_type;
};
}  // namespace boost::numeric::odeint
