#pragma once
#include <tapestry/nn/detail/batch_norm.hpp>
#include <tapestry/nn/detail/network/operators/channel_extents.hpp>

namespace tapestry::nn {
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
      detail::for_each_period_block(
          call.outputs[0].size(), scale.period(), [&](std::size_t begin, std::size_t size) {
            kernels<T>().affine(in + begin, scale.data(), shift.data(), scale.period(), out + begin, size);
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
    if (call.wants(0)) add_scaled(adjoint, factors.scale, call.accumulate(0));
    if (!call.wants(1) && !call.wants(2) && !call.wants(3) && !call.wants(4)) return;
    const bool has_products = call.wants(1) || call.wants(4);
    std::vector<double> sums, products;
    sum_channels(adjoint, has_products ? call.inputs[0].values : adjoint, factors.mean, sums, products);
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
  /// y = scale · x + shift for each channel, and the parts of both factors.
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

  [[nodiscard]] bool is_channels_last() const { return extents_.is_last || extents_.pixels == 1; }
  [[nodiscard]] std::size_t pixel_count() const { return extents_.images * extents_.pixels; }

  void add_scaled(const T* adjoint, const std::vector<double>& scale, T* to) const {
    if (is_channels_last()) {
      detail::Periodic<T> ones(extents_.channels), factors(extents_.channels), zeros(extents_.channels);
      ones.assign([](std::size_t) { return 1; });
      factors.assign([&](std::size_t c) { return scale[c]; });
      zeros.assign([](std::size_t) { return 0; });
      detail::for_each_period_block(pixel_count() * extents_.channels, ones.period(),
                                    [&](std::size_t begin, std::size_t size) {
                                      kernels<T>().combine(adjoint + begin, ones.data(), factors.data(),
                                                           zeros.data(), ones.period(), to + begin, size);
                                    });
      return;
    }
    for_each_row([&](std::size_t c, std::size_t begin) {
      for (std::size_t i = begin; i < begin + extents_.pixels; ++i)
        to[i] += static_cast<T>(scale[c]) * adjoint[i];
    });
  }

  /// For each channel Σ adjoint and Σ adjoint · (x − mean).
  void sum_channels(const T* adjoint, const T* x, const std::vector<double>& mean, std::vector<double>& sums,
                    std::vector<double>& products) const {
    if (is_channels_last()) return detail::channel_sums(adjoint, x, mean, pixel_count(), sums, products);
    sums.assign(extents_.channels, 0);
    products.assign(extents_.channels, 0);
    for_each_row([&](std::size_t c, std::size_t begin) {
      for (std::size_t i = begin; i < begin + extents_.pixels; ++i) {
        sums[c] += static_cast<double>(adjoint[i]);
        products[c] += static_cast<double>(adjoint[i]) * (static_cast<double>(x[i]) - mean[c]);
      }
    });
  }

  /// Calls body(channel, its first element) for each channel of each image.
  template <class Body>
  void for_each_row(Body body) const {
    for (std::size_t row = 0; row < extents_.images * extents_.channels; ++row)
      body(row % extents_.channels, row * extents_.pixels);
  }

  ChannelExtents extents_;
  double epsilon_;
  bool is_computed_;
};

/// BatchNormalization with the statistics of the pass's batch, training_mode 1. Where the network computes
/// one of the operands of a channel, each picture of the batch has statistics of its own:
///
///   y = scale · (x − mean(x)) / √(variance(x) + ε) + bias
///   running ← momentum · running + (1 − momentum) · batch       results 1 and 2, the same for the whole
///   batch
///
/// with the biased variance. Derivatives include the statistics' derivatives.
template <std::floating_point T>
class BatchStatisticsNormalization : public Operation<T> {
 public:
  /// \param takes_batches  whether the operands for each channel are constant
  BatchStatisticsNormalization(const Shape& shape, const ChannelExtents& extents, double epsilon,
                               double momentum, bool takes_batches)
      : Operation<T>({{shape, ElementType::floating},
                      {{extents.channels}, ElementType::floating},
                      {{extents.channels}, ElementType::floating}}),
        extents_(extents),
        epsilon_(epsilon),
        momentum_(momentum),
        takes_batches_(takes_batches) {}

  void forward(const ForwardCall<T>& call) const override {
    const std::size_t pixels = call.batch * extents_.images * extents_.pixels;
    const T* const in = call.inputs[0].values;
    const auto statistics = batch_statistics(in, pixels, extents_.channels, epsilon_);
    batch_norm(statistics, call.inputs[1].values, call.inputs[2].values, in, pixels, call.outputs[0].values);
    const auto hand_out = [&](std::size_t result, const T* running, const std::vector<double>& of_batch) {
      if (result >= call.outputs.size() || !call.outputs[result].is_there()) return;
      for (std::size_t i = 0; i < call.batch * of_batch.size(); ++i) {
        const std::size_t c = i % of_batch.size();
        call.outputs[result].values[i] =
            static_cast<T>(momentum_ * static_cast<double>(running[c]) + (1 - momentum_) * of_batch[c]);
      }
    };
    hand_out(1, call.inputs[3].values, statistics.mean);
    hand_out(2, call.inputs[4].values, statistics.variance);
    if (!call.keeps) return;
    std::vector<double>& kept = call.state.statistics;
    kept.clear();
    for (const auto* part : {&statistics.mean, &statistics.variance, &statistics.inverse_deviation})
      kept.insert(kept.end(), part->begin(), part->end());
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const std::size_t channels = extents_.channels;
    const std::size_t pixels = call.batch * extents_.images * extents_.pixels;
    const auto kept = [&](std::size_t part) {
      const auto first = call.state.statistics.begin() + static_cast<std::ptrdiff_t>(part * channels);
      return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(channels));
    };
    const BatchStatistics statistics{kept(0), kept(1), kept(2)};
    const T* const in = call.inputs[0].values;
    const auto goal = [&](std::size_t input) { return call.wants(input) ? call.accumulate(input) : nullptr; };
    T *const of_scale = goal(1), *const of_bias = goal(2);
    if (T* const adjoint = call.output_adjoints[0].values; adjoint != nullptr) {
      batch_norm_adjoint(statistics, call.inputs[1].values, in, pixels, adjoint, of_scale, of_bias);
      if (call.wants(0)) {
        T* const to = call.input_adjoints[0].values;
        call.is_uninitialised[0] ? copy(adjoint, to, pixels * channels) : add(adjoint, to, pixels * channels);
        call.is_uninitialised[0] = false;
      }
    } else {
      goal(0);
    }
    pull_back_running(call, 1, [&](std::size_t, std::size_t) { return 1.0; });
    pull_back_running(call, 2, [&](std::size_t i, std::size_t c) {
      return 2 * (static_cast<double>(in[i]) - statistics.mean[c]);
    });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {0b11, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return input == 1 || input == 2; }
  [[nodiscard]] bool takes_batches() const override { return takes_batches_; }

 private:
  /// Pulls the adjoint of a running statistic back to x and to the statistic before.
  /// \param slope_of  derivative of the batch's statistic by x[i] of channel c, times the number of pixels
  template <class Slope>
  void pull_back_running(const AdjointCall<T>& call, std::size_t result, Slope slope_of) const {
    const std::size_t channels = extents_.channels;
    std::vector<double> wanted(channels, 0);
    if (result < call.output_adjoints.size() && call.output_adjoints[result].is_there())
      for (std::size_t i = 0; i < call.batch * channels; ++i)
        wanted[i % channels] += static_cast<double>(call.output_adjoints[result].values[i]);
    if (const std::size_t before = 2 + result; call.wants(before)) {
      T* const to = call.accumulate(before);
      for (std::size_t c = 0; c < channels; ++c) to[c] += static_cast<T>(momentum_ * wanted[c]);
    }
    if (!call.wants(0) || std::ranges::all_of(wanted, [](double w) { return w == 0; })) return;
    const std::size_t pixels = call.batch * extents_.images * extents_.pixels;
    const double share = (1 - momentum_) / static_cast<double>(pixels);
    T* const to = call.accumulate(0);
    for (std::size_t i = 0; i < pixels * channels; ++i)
      to[i] += static_cast<T>(share * wanted[i % channels] * slope_of(i, i % channels));
  }

  ChannelExtents extents_;
  double epsilon_;
  double momentum_;
  bool takes_batches_;
};

/// BatchNormalization. In training_mode 1 only of tensors whose channels lie last: maps, and [N, C].
template <std::floating_point T>
void add_batch_normalization(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
    const double momentum = context.number("momentum", 0.9);
    context.ignore("spatial");  // the extents of the operands of each channel exclude 0
    const bool is_training = context.flag("training_mode", 0);
    const ChannelExtents extents = channel_extents(context);
    for (std::size_t input = 1; input < 5; ++input) require_channels(context, input, extents.channels);
    const Shape& shape = context.input(0).shape;
    const double epsilon = context.number("epsilon", 1e-5);
    if (!is_training) {
      const bool is_computed = context.input(1).constant == nullptr || context.input(4).constant == nullptr;
      return std::make_unique<BatchNormalization<T>>(shape, extents, epsilon, is_computed);
    }
    if (!extents.is_last && extents.pixels != 1)
      throw DomainError("attribute 'training_mode' is 1; only maps, [N, C, H, W], are supported there");
    bool takes_batches = true;
    for (std::size_t input = 1; input < 5; ++input)
      takes_batches = takes_batches && context.input(input).constant != nullptr;
    return std::make_unique<BatchStatisticsNormalization<T>>(shape, extents, epsilon, momentum,
                                                             takes_batches);
  };
  table["BatchNormalization"] = {LayoutRule::channels_last, 1, false, {{5, 5}}, make};
}
}  // namespace tapestry::nn
