#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/network/operator_table.hpp>
#include <vector>

namespace tapestry::nn {

/// A tensor whose axis 1 counts channels, as [images, pixels, channels] if it is stored channels last or else
/// [images, channels, pixels].
struct ChannelExtents {
  std::size_t images = 1, channels = 1, pixels = 1;
  bool is_last = false;

  [[nodiscard]] std::size_t at(std::size_t image, std::size_t channel, std::size_t pixel) const {
    return is_last ? (image * pixels + pixel) * channels + channel
                   : (image * channels + channel) * pixels + pixel;
  }
};

/// \throws DomainError for a tensor without an axis of channels
[[nodiscard]] inline ChannelExtents channel_extents(const OperatorContext& context) {
  const Shape& shape = context.input(0).shape;
  if (shape.size() < 2)
    throw DomainError("input 0 is " + tapestry::detail::to_text(shape) + ", expected [N, C, …]");
  ChannelExtents extents;
  extents.is_last = context.channels_last();
  extents.images = shape[0];
  extents.channels = extents.is_last ? shape.back() : shape[1];
  if (extents.channels == 0) throw ShapeError("input 0 has no channels");
  extents.pixels = size_of(shape) / std::max<std::size_t>(1, extents.images * extents.channels);
  return extents;
}

/// \throws ShapeError unless an operand has one value a channel
inline void require_channels(const OperatorContext& context, std::size_t input, std::size_t channels) {
  if (context.input(input).shape != Shape{channels})
    throw ShapeError("input " + std::to_string(input) + " is " +
                     tapestry::detail::to_text(context.input(input).shape) + ", expected [" +
                     std::to_string(channels) + "]");
}

/// BatchNormalization with the statistics that it is given: scale · (x − mean)/√(variance + ε) + bias.
template <std::floating_point T>
class BatchNormalization : public Operation<T> {
 public:
  /// \param is_computed  whether the network computes the scale or the variance
  BatchNormalization(const Shape& shape, const ChannelExtents& extents, double epsilon, bool is_computed)
      : Operation<T>({{shape, ElementType::floating}}),
        extents_(extents),
        epsilon_(epsilon),
        is_computed_(is_computed) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    const Factors factors(*this, call.inputs);
    const std::size_t run = extents_.is_last ? 1 : extents_.pixels;
    if (run == 1) {
      detail::Periodic<T> scale(extents_.channels), shift(extents_.channels);
      scale.assign([&](std::size_t c) { return factors.scale[c]; });
      shift.assign([&](std::size_t c) { return factors.shift[c]; });
      detail::for_each_period_block(call.outputs[0].size(), scale.period(),
                                    [&](std::size_t begin, std::size_t size) {
                                      kernels<T>().affine(in + begin, scale.data(), shift.data(),
                                                          scale.period(), T(1), out + begin, size);
                                    });
      return;
    }
    parallel_for(extents_.images * extents_.channels, [&](std::size_t row) {
      const T scale = static_cast<T>(factors.scale[row % extents_.channels]);
      const T shift = static_cast<T>(factors.shift[row % extents_.channels]);
      for (std::size_t i = row * run; i < (row + 1) * run; ++i) out[i] = scale * in[i] + shift;
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const Factors factors(*this, call.inputs);
    const T* const adjoint = call.output_adjoints[0].values;
    const std::size_t channels = extents_.channels;
    if (call.wants(0)) {
      T* const to = call.accumulate(0);
      parallel_for(extents_.images, [&](std::size_t n) {
        for_each(
            n, [&](std::size_t i, std::size_t c) { to[i] += static_cast<T>(factors.scale[c]) * adjoint[i]; });
      });
    }
    if (!call.wants(1) && !call.wants(2) && !call.wants(3) && !call.wants(4)) return;
    std::vector<double> sums(channels, 0), products(channels, 0);
    for (std::size_t n = 0; n < extents_.images; ++n)
      for_each(n, [&](std::size_t i, std::size_t c) {
        const auto g = static_cast<double>(adjoint[i]);
        sums[c] += g;
        if (call.wants(1) || call.wants(4))
          products[c] += g * (static_cast<double>(call.inputs[0].values[i]) - factors.mean[c]);
      });
    const auto hand_on = [&](std::size_t input, auto value_of) {
      if (!call.wants(input)) return;
      T* const to = call.accumulate(input);
      for (std::size_t c = 0; c < channels; ++c) to[c] += static_cast<T>(value_of(c));
    };
    hand_on(1, [&](std::size_t c) { return products[c] * factors.inverse[c]; });
    hand_on(2, [&](std::size_t c) { return sums[c]; });
    hand_on(3, [&](std::size_t c) { return -sums[c] * factors.scale[c]; });
    hand_on(4, [&](std::size_t c) {
      return -0.5 * products[c] * factors.scale[c] * factors.inverse[c] * factors.inverse[c];
    });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return {is_computed_ ? 0b11111U : 0b11110U, 0};
  }
  [[nodiscard]] AdjointReads weight_adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return input == 1 || input == 2; }

 private:
  /// y = scale · x + shift, and what they are made of, for each channel.
  struct Factors {
    std::vector<double> scale, shift, mean, inverse;

    Factors(const BatchNormalization& owner, std::span<const TensorView<const T>> inputs) {
      const auto at = [&](std::size_t input, std::size_t c) {
        return static_cast<double>(inputs[input].values[c]);
      };
      for (std::size_t c = 0; c < owner.extents_.channels; ++c) {
        inverse.push_back(1 / std::sqrt(at(4, c) + owner.epsilon_));
        mean.push_back(at(3, c));
        scale.push_back(at(1, c) * inverse[c]);
        shift.push_back(at(2, c) - scale[c] * mean[c]);
      }
    }
  };

  template <class Body>
  void for_each(std::size_t image, Body body) const {
    const std::size_t size = extents_.channels * extents_.pixels;
    for (std::size_t i = 0; i < size; ++i)
      body(image * size + i, extents_.is_last ? i % extents_.channels : i / extents_.pixels);
  }

  ChannelExtents extents_;
  double epsilon_;
  bool is_computed_;
};

/// BatchNormalization in its form for inference.
template <std::floating_point T>
void add_batch_normalization(OperatorTable<T>& table) {
  table["BatchNormalization"] = {
      LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
        context.ignore("momentum");
        context.ignore("spatial");  // 0 is refused by the extents of what is given for each channel
        if (context.integer("training_mode", 0) != 0)
          throw DomainError("attribute 'training_mode' is 1; only the form for inference is supported");
        const ChannelExtents extents = channel_extents(context);
        for (std::size_t input = 1; input < 5; ++input) require_channels(context, input, extents.channels);
        const bool is_computed = context.input(1).constant == nullptr || context.input(4).constant == nullptr;
        return std::make_unique<BatchNormalization<T>>(context.input(0).shape, extents,
                                                       context.number("epsilon", 1e-5), is_computed);
      }};
}

}  // namespace tapestry::nn
