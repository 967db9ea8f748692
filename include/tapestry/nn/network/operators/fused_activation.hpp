#pragma once
#include <string>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/curve.hpp>
#include <tapestry/nn/network/operator_context.hpp>

namespace tapestry::nn {

/// The activation that a convolution applies to its sums: none, a leaky one, or a curve.
template <class T>
struct FusedActivation {
  T slope = 1;  ///< x above 0, slope · x elsewhere; at least 0
  Curve<T> curve{};

  [[nodiscard]] bool is_curve() const { return curve.kind != CurveKind::none; }
  [[nodiscard]] bool needs_signs() const { return !is_curve() && slope != T(1); }
};

/// Reads the attributes `activation`, an operator's name or nothing, and `activation_a` and `activation_b`,
/// its numbers: LeakyRelu's alpha, HardSigmoid's and HardSwish's alpha and beta, Clip's bounds.
template <class T>
[[nodiscard]] FusedActivation<T> fused_activation(OperatorContext& context) {
  const std::string name = context.text("activation", "");
  const T a = static_cast<T>(context.number("activation_a", 0));
  const T b = static_cast<T>(context.number("activation_b", 0));
  if (name.empty()) return {};
  if (name == "Relu") return {T(0), {}};
  if (name == "LeakyRelu" && a >= T(0)) return {a, {}};
  if (name == "Sigmoid") return {T(1), {CurveKind::logistic, a, b}};
  if (name == "Swish") return {T(1), {CurveKind::swish, a, b}};
  if (name == "Mish") return {T(1), {CurveKind::mish, a, b}};
  if (name == "HardSigmoid") return {T(1), {CurveKind::hard_logistic, a, b}};
  if (name == "HardSwish") return {T(1), {CurveKind::hard_swish, a, b}};
  if (name == "Clip") return {T(1), {CurveKind::clip, a, b}};
  throw DomainError("attribute 'activation' is " + in_quotes(name));
}

}  // namespace tapestry::nn
