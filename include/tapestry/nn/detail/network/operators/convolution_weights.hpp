#pragma once
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/detail/network/operator_context.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// The activation that a convolution applies to its sums: none, a leaky one, or a curve.
template <std::floating_point T>
struct FusedActivation {
  T slope = 1;  ///< x above 0, slope · x elsewhere; at least 0
  Curve<T> curve{};

  [[nodiscard]] bool is_curve() const { return curve.kind != CurveKind::none; }
  [[nodiscard]] bool needs_signs() const { return !is_curve() && slope != T(1); }
};

/// Reads the attributes `activation`, an operator's name or nothing, and `activation_a` and `activation_b`,
/// its numbers: LeakyRelu's alpha, HardSigmoid's and HardSwish's alpha and beta, Clip's bounds.
template <std::floating_point T>
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
  throw DomainError({"attribute 'activation' is ", in_quotes(name)});
}

/// Weights of one convolution, [filter, channel of its group, row tap, column tap]. They are packed for the
/// kernels when they are first needed; several threads may need them at once.
template <std::floating_point T>
class ConvolutionWeights {
 public:
  explicit ConvolutionWeights(const ConvolutionShape& shape) : shape_(shape) {}

  [[nodiscard]] const ConvolutionShape& shape() const { return shape_; }

  /// Sets the weights, which must stay where they are, unchanged.
  void set(const T* weights) {
    weights_ = weights;
    convolution_.reset();
    adjoint_.reset();
  }

  [[nodiscard]] const PackedConvolution<T>& convolution() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!convolution_)
      convolution_ = std::make_unique<PackedConvolution<T>>(
          pack_convolution<T>(shape_, [this](std::size_t i) { return weights_[i]; }));
    return *convolution_;
  }
  [[nodiscard]] const std::vector<PackedConvolution<T>>& adjoint() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!adjoint_)
      adjoint_ = std::make_unique<std::vector<PackedConvolution<T>>>(
          pack_convolution_adjoint<T>(shape_, [this](std::size_t i) { return weights_[i]; }));
    return *adjoint_;
  }

 private:
  ConvolutionShape shape_;
  const T* weights_ = nullptr;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<PackedConvolution<T>> convolution_;
  mutable std::unique_ptr<std::vector<PackedConvolution<T>>> adjoint_;
};

/// Whether convolve_adjoint() writes every pixel once, by kernels that apply this scale.
template <std::floating_point T>
[[nodiscard]] bool scales_whole(const ConvolutionShape& shape, const AdjointScale<T>& scale) {
  ConvolutionShape back = shape;
  std::swap(back.in_channels, back.out_channels);
  return adjoint_covers_input(shape) && shape.in_channels > 4 &&
         (scale.gate == nullptr || fuses_bits<T>(back));
}

/// Adds to in_adjoint the adjoint of a convolution applied to out_adjoint, or writes it where fresh.
/// \param is_uninitialised  in_adjoint is not initialised
/// \param window    of in_adjoint, as convolve() takes it
/// \param scale     of in_adjoint, applied at the end; see scales_whole()
template <std::floating_point T>
void convolve_adjoint(Engine engine, const ConvolutionWeights<T>& weights, std::size_t images,
                      const T* out_adjoint, bool is_uninitialised, T* in_adjoint,
                      const std::optional<MapWindow>& window = {}, const AdjointScale<T>& scale = {}) {
  const ConvolutionShape& shape = weights.shape();
  const bool writes = is_uninitialised && adjoint_covers_input(shape);
  if (is_uninitialised && !writes) std::fill_n(in_adjoint, images * shape.in_size(), T(0));
  Epilogue<T> end{};
  end.adds = !writes;
  end.factor = scale.factor;
  end.gate = scale.gate;
  end.slope = scale.slope;
  for (const auto& part : weights.adjoint())
    convolve<T>(engine, part, images, out_adjoint, end, in_adjoint, shape.in_size(), window);
}
}  // namespace tapestry::nn
