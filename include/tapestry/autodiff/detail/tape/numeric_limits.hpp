#pragma once
#include <tapestry/autodiff/detail/tape/expression.hpp>

namespace tapestry {
template <class T>
class Variable;

namespace detail {
/// std::numeric_limits of B, its numbers as constants of type X.
template <class X, class B>
struct LimitsOf : std::numeric_limits<B> {
  static constexpr X min() noexcept { return std::numeric_limits<B>::min(); }
  static constexpr X max() noexcept { return std::numeric_limits<B>::max(); }
  static constexpr X lowest() noexcept { return std::numeric_limits<B>::lowest(); }
  static constexpr X epsilon() noexcept { return std::numeric_limits<B>::epsilon(); }
  static constexpr X round_error() noexcept { return std::numeric_limits<B>::round_error(); }
  static constexpr X infinity() noexcept { return std::numeric_limits<B>::infinity(); }
  static constexpr X quiet_NaN() noexcept { return std::numeric_limits<B>::quiet_NaN(); }
  static constexpr X signaling_NaN() noexcept { return std::numeric_limits<B>::signaling_NaN(); }
  static constexpr X denorm_min() noexcept { return std::numeric_limits<B>::denorm_min(); }
};

/// E itself if a number converts to it; for a formula the variable that it becomes.
template <class E>
using NumberBeside = std::conditional_t<std::convertible_to<typename E::ExpressionScalar, E>, E,
                                        Variable<typename E::ExpressionScalar>>;
}  // namespace detail
}  // namespace tapestry

namespace std {
/// Limits of a variable or a formula of type E: the limits of the number beneath, as passive variables.
template <tapestry::ScalarExpression E>
requires(same_as<E, remove_cv_t<E>>) class numeric_limits<E>
    : public tapestry::detail::LimitsOf<tapestry::detail::NumberBeside<E>,
                                        tapestry::detail::Base<typename E::ExpressionScalar>> {
};
/// Limits of a dual: the limits of the number beneath, as constants.
template <class T, size_t N, class Tag>
class numeric_limits<tapestry::Dual<T, N, Tag>>
    : public tapestry::detail::LimitsOf<tapestry::Dual<T, N, Tag>, tapestry::detail::Base<T>> {};
}  // namespace std
