#pragma once
#include <numeric>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/detail/vector_kernels.hpp>
#include <tapestry/nn/workspace.hpp>

namespace tapestry::nn {
/// Statistics of one batch: for each channel its mean, its biased variance, and 1/√(variance + ε).
struct BatchStatistics {
  std::vector<double> mean{};
  std::vector<double> variance{};
  std::vector<double> inverse_deviation{};
};

namespace detail {
/// Values repeated up to a whole number of vectors, so that channels need no tails.
template <std::floating_point T>
class Periodic {
 public:
  explicit Periodic(std::size_t channels)
      : channels_(channels), values_(std::lcm(channels, kernels<T>().lanes)) {}

  template <class Function>
  void assign(Function value_of_channel) {
    for (std::size_t i = 0; i < values_.size(); ++i)
      values_.data()[i] = static_cast<T>(value_of_channel(i % channels_));
  }
  [[nodiscard]] const T* data() const { return values_.data(); }
  [[nodiscard]] std::size_t period() const { return values_.size(); }

 private:
  std::size_t channels_;
  Buffer<T> values_;
};

/// For each channel Σ x and Σ x·(y − origin): short sums in T, joined in double in a fixed order.
template <std::floating_point T>
void channel_sums(const T* x, const T* y, const std::vector<double>& origin, std::size_t pixels,
                  std::vector<double>& sums, std::vector<double>& products) {
  const std::size_t channels = origin.size();
  Periodic<T> origins(channels);
  origins.assign([&](std::size_t c) { return origin[c]; });
  const std::size_t period = origins.period();
  const std::size_t count = pixels * channels;
  const std::size_t block = period * std::max<std::size_t>(1, std::min<std::size_t>(128, 16384 / period));
  const std::size_t blocks = block_count(count, block);
  std::vector<double> partial(blocks * 2 * channels);
  parallel_for(blocks, [&](std::size_t b) {
    static thread_local Buffer<T> scratch;
    scratch.resize(2 * period);
    scratch.fill_zero();
    const BlockRange range = block_range(b, count, block);
    kernels<T>().periodic_sums(x + range.begin, y + range.begin, origins.data(), period, scratch.data(),
                               scratch.data() + period, range.end - range.begin);
    for (std::size_t i = 0; i < period; ++i) {
      partial[b * 2 * channels + i % channels] += static_cast<double>(scratch.data()[i]);
      partial[b * 2 * channels + channels + i % channels] += static_cast<double>(scratch.data()[period + i]);
    }
  });
  sums.assign(channels, 0);
  products.assign(channels, 0);
  for (std::size_t b = 0; b < blocks; ++b)
    for (std::size_t c = 0; c < channels; ++c) {
      sums[c] += partial[b * 2 * channels + c];
      products[c] += partial[b * 2 * channels + channels + c];
    }
}

/// Calls body(begin, size) for blocks of whole periods.
template <class Body>
void for_each_period_block(std::size_t count, std::size_t period, Body body) {
  const std::size_t block = period * std::max<std::size_t>(1, 65536 / period);
  parallel_for_blocks(count, block, [&](std::size_t begin, std::size_t end) { body(begin, end - begin); });
}
}  // namespace detail

/// Adds the sum over pixels of [pixels, channels] to channel_sums_adjoint: the gradient of a bias.
template <std::floating_point T>
void bias_adjoint(const T* out_adjoint, std::size_t pixels, std::size_t channels, T* bias_adjoint) {
  std::vector<double> sums;
  std::vector<double> products;
  detail::channel_sums(out_adjoint, out_adjoint, std::vector<double>(channels), pixels, sums, products);
  for (std::size_t c = 0; c < channels; ++c) bias_adjoint[c] += static_cast<T>(sums[c]);
}

/// Mean and variance of each channel of [pixels, channels], in two passes; ε is added inside the root.
template <std::floating_point T>
[[nodiscard]] BatchStatistics batch_statistics(const T* values, std::size_t pixels, std::size_t channels,
                                               double epsilon) {
  BatchStatistics statistics;
  std::vector<double> sums;
  std::vector<double> products;
  const auto count = static_cast<double>(pixels);
  detail::channel_sums(values, values, std::vector<double>(channels), pixels, sums, products);
  for (const double sum : sums) statistics.mean.push_back(sum / count);
  // Σ x·(x − mean) = Σ (x − mean)² up to mean · Σ (x − mean), which is removed as well.
  detail::channel_sums(values, values, statistics.mean, pixels, sums, products);
  for (std::size_t c = 0; c < channels; ++c) {
    const double square_sum = products[c] - statistics.mean[c] * (sums[c] - count * statistics.mean[c]);
    const double variance = square_sum / count;
    statistics.variance.push_back(variance < 0 ? 0 : variance);
    statistics.inverse_deviation.push_back(1 / std::sqrt(statistics.variance.back() + epsilon));
  }
  return statistics;
}

/// out = scale · (in − mean) / √(variance + ε) + bias, all for each channel of [pixels, channels].
template <std::floating_point T>
void batch_norm(const BatchStatistics& statistics, const T* scale, const T* bias, const T* in,
                std::size_t pixels, T* out) {
  const std::size_t channels = statistics.mean.size();
  detail::Periodic<T> factor(channels);
  detail::Periodic<T> shift(channels);
  const auto factor_of = [&](std::size_t c) {
    return static_cast<double>(scale[c]) * statistics.inverse_deviation[c];
  };
  factor.assign(factor_of);
  shift.assign(
      [&](std::size_t c) { return static_cast<double>(bias[c]) - factor_of(c) * statistics.mean[c]; });
  detail::for_each_period_block(pixels * channels, factor.period(), [&](std::size_t begin, std::size_t size) {
    kernels<T>().affine(in + begin, factor.data(), shift.data(), factor.period(), out + begin, size);
  });
}

/// Turns the adjoint of batch_norm()'s output into that of its input, in place. The statistics are the
/// batch's own. Adds to scale_adjoint and bias_adjoint unless they are null.
///
///   x̂ = (in − mean)·s,   ∂L/∂in = scale·s·(g − mean(g) − x̂·mean(g·x̂))
///
/// Source: Ioffe and Szegedy, "Batch normalization" (2015), section 3.
template <std::floating_point T>
void batch_norm_adjoint(const BatchStatistics& statistics, const T* scale, const T* in, std::size_t pixels,
                        T* adjoint, T* scale_adjoint, T* bias_adjoint) {
  const std::size_t channels = statistics.mean.size();
  std::vector<double> sums;
  std::vector<double> products;
  detail::channel_sums(adjoint, in, statistics.mean, pixels, sums, products);
  const auto count = static_cast<double>(pixels);
  detail::Periodic<T> of_adjoint(channels);
  detail::Periodic<T> of_input(channels);
  detail::Periodic<T> constant(channels);
  const auto& s = statistics.inverse_deviation;
  const auto factor = [&](std::size_t c) { return static_cast<double>(scale[c]) * s[c]; };
  const auto input_factor = [&](std::size_t c) { return -factor(c) * s[c] * s[c] * products[c] / count; };
  of_adjoint.assign(factor);
  of_input.assign(input_factor);
  constant.assign(
      [&](std::size_t c) { return -factor(c) * sums[c] / count - input_factor(c) * statistics.mean[c]; });
  for (std::size_t c = 0; c < channels; ++c) {
    if (scale_adjoint != nullptr) scale_adjoint[c] += static_cast<T>(products[c] * s[c]);
    if (bias_adjoint != nullptr) bias_adjoint[c] += static_cast<T>(sums[c]);
  }
  detail::for_each_period_block(
      pixels * channels, constant.period(), [&](std::size_t begin, std::size_t size) {
        kernels<T>().combine(in + begin, of_adjoint.data(), of_input.data(), constant.data(),
                             constant.period(), adjoint + begin, size);
      });
}
}  // namespace tapestry::nn
