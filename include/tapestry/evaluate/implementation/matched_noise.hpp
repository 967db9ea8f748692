#pragma once
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/detail/rank_order.hpp>
#include <tapestry/image/fourier_transform.hpp>

namespace tapestry::evaluate {
namespace detail {

/// Replaces M values, in the order of rank, by values of a sorted list of N: number i of M by number ⌊(i +
/// ½)·N/M⌋ of N, each used once if M = N. The first of equal values comes first.
inline void take_values_by_rank(std::vector<double>& values, const std::vector<double>& sorted) {
  const RankOrder order(values);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[order[i]] = sorted[(2 * i + 1) * sorted.size() / (2 * values.size())];
}

/// One colour channel of a chart, in a box that is periodic at its borders.
struct NoiseChannel {
  image::FourierTransform transform;
  std::vector<double> sorted;                    ///< the chart's values, in ascending order
  image::FourierTransform::Spectrum optimised;   ///< X, the source of amplitudes and relative phases
  image::FourierTransform::Plane plane{};        ///< the noise
  image::FourierTransform::Spectrum spectrum{};  ///< of the noise
};

/// The matched noise of one chart, see matched_noise().
class ChartNoise {
 public:
  ChartNoise(const Array<float, 2>& colours, const raster::TextureChart& chart, Random random)
      : chart_(chart),
        height_(image::fourier_extent(chart.height)),
        width_(image::fourier_extent(chart.width)) {
    for (std::size_t c = 0; c < 3; ++c) channels_.push_back(channel_of(colours, c));
    divide_by_pair_shares();
    // The phases of white noise are a random draw that a real picture can have.
    image::FourierTransform::Plane white(height_ * width_);
    for (double& value : white) value = random.uniform(-1, 1);
    phases_ = channels_.front().transform.forward(white);
    for (auto& phase : phases_) phase = unit(phase);
    impose_spectrum();
  }

  /// One round: the distribution of values, then the spectrum.
  void refine() {
    parallel_for(channels_.size(), [&](std::size_t c) {
      NoiseChannel& channel = channels_[c];
      take_values_by_rank(channel.plane, channel.sorted);
      channel.spectrum = channel.transform.forward(channel.plane);
    });
    parallel_for_blocks(phases_.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        std::complex<double> sum = 0;
        for (const NoiseChannel& channel : channels_)
          sum += channel.spectrum[k] * std::conj(channel.optimised[k]);
        phases_[k] = unit(sum);
      }
    });
    impose_spectrum();
  }

  /// Writes the noise to the texels of the chart, each channel with the chart's values.
  void write(Array<float, 2>& colours) const {
    std::vector<double> values(chart_.texels.size());
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = channels_[c].plane[place(i)];
      take_values_by_rank(values, channels_[c].sorted);
      for (std::size_t i = 0; i < values.size(); ++i)
        colours(chart_.texels[i].texel, c) = static_cast<float>(values[i]);
    }
  }

 private:
  [[nodiscard]] std::size_t place(std::size_t i) const {
    return chart_.texels[i].row * width_ + chart_.texels[i].column;
  }
  static std::complex<double> unit(const std::complex<double>& number) {
    const double length = std::abs(number);
    return length > 0 ? number / length : 1;
  }

  /// Takes the spectrum of the chart's deviations from its mean, 0 outside it.
  [[nodiscard]] NoiseChannel channel_of(const Array<float, 2>& colours, std::size_t c) const {
    NoiseChannel channel{image::FourierTransform(height_, width_), {}, {}};
    double sum = 0;
    for (const raster::ChartTexel& texel : chart_.texels) {
      channel.sorted.push_back(static_cast<double>(colours(texel.texel, c)));
      sum += channel.sorted.back();
    }
    const double mean = sum / static_cast<double>(chart_.texels.size());
    channel.plane.assign(height_ * width_, 0);
    for (std::size_t i = 0; i < chart_.texels.size(); ++i) channel.plane[place(i)] = channel.sorted[i] - mean;
    channel.optimised = channel.transform.forward(channel.plane);
    std::sort(channel.sorted.begin(), channel.sorted.end());
    return channel;
  }

  /// Gives X the amplitudes of a picture that fills the box. A chart with 0 around it has less covariance at
  /// each distance than its texels have; X is divided by the share of pairs of places that both lie in the
  /// chart.
  void divide_by_pair_shares() {
    constexpr double least_share = 0.3;  // share of the chart's texels; farther lags have too few pairs
    auto& transform = channels_.front().transform;
    image::FourierTransform::Plane inside(height_ * width_, 0);
    for (std::size_t i = 0; i < chart_.texels.size(); ++i) inside[place(i)] = 1;
    const auto pairs = transform.inverse(squared(transform.forward(inside)));
    const auto count = static_cast<double>(chart_.texels.size());
    for (NoiseChannel& channel : channels_) {
      auto covariance = transform.inverse(squared(channel.optimised));
      for (std::size_t i = 0; i < covariance.size(); ++i)
        covariance[i] *= static_cast<double>(inside.size()) / std::max(pairs[i], least_share * count);
      const auto power = transform.forward(covariance);
      for (std::size_t k = 0; k < power.size(); ++k)
        channel.optimised[k] = std::sqrt(std::max(power[k].real(), 0.0)) * unit(channel.optimised[k]);
      channel.optimised[0] = 0;  // the mean is a matter of the values
    }
  }

  static image::FourierTransform::Spectrum squared(image::FourierTransform::Spectrum spectrum) {
    for (auto& value : spectrum) value = std::norm(value);
    return spectrum;
  }

  /// The planes whose spectra are X · e^(iα).
  void impose_spectrum() {
    parallel_for(channels_.size(), [&](std::size_t c) {
      NoiseChannel& channel = channels_[c];
      channel.spectrum = channel.optimised;
      for (std::size_t k = 0; k < phases_.size(); ++k) channel.spectrum[k] *= phases_[k];
      channel.plane = channel.transform.inverse(channel.spectrum);
    });
  }

  const raster::TextureChart& chart_;
  std::size_t height_, width_;  ///< of the box
  std::vector<NoiseChannel> channels_;
  image::FourierTransform::Spectrum phases_;  ///< e^(iα)
};

}  // namespace detail

Array<float, 2> matched_noise(const Array<float, 2>& colours, const std::vector<raster::TextureChart>& charts,
                              const Random& random, std::size_t rounds) {
  detail::require_chart_colours("matched_noise", colours, charts);
  Array<float, 2> noise = colours;
  parallel_for(charts.size(), [&](std::size_t i) {
    if (charts[i].texels.empty()) return;
    detail::ChartNoise chart(colours, charts[i], random.fork(i));
    for (std::size_t round = 0; round < rounds; ++round) chart.refine();
    chart.write(noise);
  });
  return noise;
}

}  // namespace tapestry::evaluate
