#pragma once
#include "array_computation.hpp"
#include "jacobian_computations.hpp"
#include "tape_computations.hpp"
#include "variants.hpp"

namespace tapestry::benchmarks {
[[nodiscard]] inline Made make_jacobian(const BundleJacobian& objective, const std::string& variant) {
  if (variant == "scalar") return std::make_unique<BlockSweeps>(objective);
  if (variant == "dual") return std::make_unique<BlockDuals>(objective);
  if (variant == "compressed") return std::make_unique<CompressedSweeps>(objective);
  return nullptr;
}

template <class Objective>
[[nodiscard]] Made make_array(const Objective& objective, const std::string& variant) {
  if constexpr (std::is_same_v<Objective, Softmax>) {
    using Form = SoftmaxForm<double, Exponential::library>;
    if (variant == "array-library-exp") return std::make_unique<ArrayTape<Softmax, double, Form>>(objective);
  }
  if constexpr (HasArrayForm<Objective>) {
    if (variant == "array") return std::make_unique<ArrayTape<Objective, double>>(objective);
    if (variant == "array-float") return std::make_unique<ArrayTape<Objective, float>>(objective);
  }
  return nullptr;
}

template <class Objective>
Made make_variant(const Objective& objective, const std::string& variant, std::ptrdiff_t threads) {
  if (variant == "plain") return std::make_unique<PlainValue<Objective>>(objective);
  if (variant == "hand") return std::make_unique<HandAdjoint<Objective>>(objective);
  if constexpr (std::is_same_v<Objective, BundleJacobian>) {
    return make_jacobian(objective, variant);
  } else {
    if (variant == "scalar" && threads > 1)
      return std::make_unique<OnThreads<ScalarTape<Objective>>>(objective, threads);
    if (variant == "scalar") return std::make_unique<ScalarTape<Objective>>(objective);
    if (variant == "recording") return std::make_unique<RecordingAlone<Objective>>(objective);
    if (variant == "gradient-call") return std::make_unique<GradientCall<Objective>>(objective);
    if (variant == "scalar-8-roots") return std::make_unique<VectorSweeps<Objective>>(objective);
    if (variant == "hessian-product") return std::make_unique<HessianTimesVector<Objective>>(objective);
    return make_array(objective, variant);
  }
}
}  // namespace tapestry::benchmarks
