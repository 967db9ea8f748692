#pragma once
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/detail/rank_order.hpp>
#include <tapestry/image/fourier_transform.hpp>

namespace tapestry::evaluate {
namespace detail {
/// Picture of a view with its paint in one grey, in the space where paint and light multiply.
inline Array<float, 3> picture_in_grey(const camouflage::View<float>& view, camouflage::Paint<float> paint,
                                       float grey) {
  for (std::size_t texel = 0; texel < paint.colours.shape(0); ++texel)
    if (paint.painted.empty() || paint.painted[texel] != 0)
      for (std::size_t c = 0; c < 3; ++c) paint.colours(texel, c) = grey;
  return image::in_space(view.space, camouflage::picture_of(view, paint.colours));
}

/// The paint in a picture: pixel = dark + light · paint, in the view's space.
struct PaintInPicture {
  Array<float, 3> dark, light;  ///< [H, W, 3]
  Array<float, 2> paint{};      ///< [pixel, 3], encoded as a texture's colours are
  /// Pixels that show it, in the box around them.
  std::vector<raster::TextureChart> charts{};
};

/// \param encoded  the view's picture with the paint
inline PaintInPicture paint_in_picture(const camouflage::View<float>& view,
                                       const camouflage::Paint<float>& paint,
                                       const Array<float, 3>& encoded) {
  constexpr float grey = 0.5F;          // white could exceed the picture's range in strong light
  constexpr float least_light = 2e-3F;  // less is rounding, and cannot be seen
  PaintInPicture found{picture_in_grey(view, paint, 0), picture_in_grey(view, paint, grey)};
  const auto picture = image::in_space(view.space, encoded);
  const float paint_of_grey = view.space == image::ColourSpace::linear ? image::linearised(grey) : grey;
  const std::size_t width = picture.shape(1), pixels = picture.shape(0) * width;
  found.paint = zeros<float, 2>({pixels, 3});
  raster::TextureChart chart;
  std::size_t top = pixels, left = width;
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    bool shows = true;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      float& light = found.light.data()[i];
      light = (light - found.dark.data()[i]) / paint_of_grey;
      shows = shows && light > least_light;
    }
    if (!shows) continue;
    for (std::size_t i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      const float shown = (picture.data()[i] - found.dark.data()[i]) / found.light.data()[i];
      found.paint.data()[i] =
          std::clamp(view.space == image::ColourSpace::linear ? image::encoded(std::max(shown, 0.0F)) : shown,
                     0.0F, 1.0F);
    }
    chart.texels.push_back({pixel / width, pixel % width, pixel});
    top = std::min(top, pixel / width);
    left = std::min(left, pixel % width);
  }
  for (raster::ChartTexel& texel : chart.texels) {
    texel.row -= top;
    texel.column -= left;
    chart.height = std::max(chart.height, texel.row + 1);
    chart.width = std::max(chart.width, texel.column + 1);
  }
  if (!chart.texels.empty()) found.charts.push_back(std::move(chart));
  return found;
}
}  // namespace detail

Array<float, 3> picture_with_noise(const camouflage::View<float>& view, const camouflage::Paint<float>& paint,
                                   const Random& random) {
  camouflage::require_sound("picture_with_noise", paint);
  auto picture = camouflage::picture_of(view, paint.colours);
  if (view.visible_pixels == 0) return picture;
  const auto found = detail::paint_in_picture(view, paint, picture);
  const auto noise = matched_noise(found.paint, found.charts, random, picture_noise_rounds);
  for (const raster::TextureChart& chart : found.charts)
    for (const raster::ChartTexel& texel : chart.texels)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = 3 * texel.texel + c;
        const float colour = noise(texel.texel, c);
        const float shown = view.space == image::ColourSpace::linear ? image::linearised(colour) : colour;
        const float value = found.dark.data()[i] + found.light.data()[i] * shown;
        picture.data()[i] = std::clamp(
            view.space == image::ColourSpace::linear ? image::encoded(std::max(value, 0.0F)) : value, 0.0F,
            1.0F);
      }
  return picture;
}

namespace detail {
/// Replaces M values, in the order of rank, by values of a sorted list of N: number i of M by number ⌊(i +
/// ½)·N/M⌋ of N, each used once if M = N. The first of equal values comes first.
inline void take_values_by_rank(std::span<float> values, const std::vector<float>& sorted) {
  const RankOrder order(values.data(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    values[order[i]] = sorted[(2 * i + 1) * sorted.size() / (2 * values.size())];
}

/// Rounds are in single precision. The spectrum that they impose is found in double: its powers span more.
using NoiseTransform = image::FourierTransform<float>;
using ExactTransform = image::FourierTransform<double>;

/// One colour channel of a chart, in a box that is periodic at its borders.
struct NoiseChannel {
  std::vector<float> sorted;            ///< the chart's values, in ascending order
  NoiseTransform::Spectrum optimised;   ///< X, the source of amplitudes and relative phases
  NoiseTransform::Plane plane{};        ///< the noise
  NoiseTransform::Spectrum spectrum{};  ///< of the noise
};

/// The matched noise of one chart, see matched_noise().
class ChartNoise {
 public:
  ChartNoise(const Array<float, 2>& colours, const raster::TextureChart& chart, Random random)
      : chart_(chart),
        height_(image::fourier_extent(chart.height)),
        width_(image::fourier_extent(chart.width)),
        transform_(height_, width_) {
    const ExactTransform exact(height_, width_);
    const auto pairs = pairs_by_lag(exact);
    for (std::size_t c = 0; c < 3; ++c) channels_.push_back(channel_of(colours, c, exact, pairs));
    // The phases of white noise are a random draw that a real picture can have.
    NoiseTransform::Plane white(height_ * width_);
    for (float& value : white) value = static_cast<float>(random.uniform(-1, 1));
    phases_ = transform_.forward(white);
    for (auto& phase : phases_) phase = unit(phase);
    impose_spectrum();
  }

  /// One round: the distribution of values, then the spectrum.
  void refine() {
    parallel_for(channels_.size(),
                 [&](std::size_t c) { take_values_by_rank(channels_[c].plane, channels_[c].sorted); });
    for (NoiseChannel& channel : channels_) channel.spectrum = transform_.forward(channel.plane);
    parallel_for_blocks(phases_.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        std::complex<float> sum = 0;
        for (const NoiseChannel& channel : channels_)
          sum += channel.spectrum[k] * std::conj(channel.optimised[k]);
        phases_[k] = unit(sum);
      }
    });
    impose_spectrum();
  }

  /// Writes the noise to the texels of the chart, each channel with the chart's values.
  void write(Array<float, 2>& colours) const {
    std::vector<float> values(chart_.texels.size());
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      for (std::size_t i = 0; i < values.size(); ++i) values[i] = channels_[c].plane[place(i)];
      take_values_by_rank(values, channels_[c].sorted);
      for (std::size_t i = 0; i < values.size(); ++i) colours(chart_.texels[i].texel, c) = values[i];
    }
  }

 private:
  [[nodiscard]] std::size_t place(std::size_t i) const {
    return chart_.texels[i].row * width_ + chart_.texels[i].column;
  }
  template <std::floating_point T>
  static std::complex<T> unit(const std::complex<T>& number) {
    const T length = std::abs(number);
    return length > 0 ? number / length : 1;
  }

  /// Takes the spectrum of the chart's deviations from its mean, 0 outside it, with the amplitudes of a
  /// picture that fills the box. A chart with 0 around it has less covariance at each distance than its
  /// texels have; it is divided by the share of pairs of places that both lie in the chart.
  [[nodiscard]] NoiseChannel channel_of(const Array<float, 2>& colours, std::size_t c,
                                        const ExactTransform& exact,
                                        const ExactTransform::Plane& pairs) const {
    constexpr double least_share = 0.3;  // share of the chart's texels; farther lags have too few pairs
    NoiseChannel channel;
    double sum = 0;
    for (const raster::ChartTexel& texel : chart_.texels) {
      channel.sorted.push_back(colours(texel.texel, c));
      sum += static_cast<double>(channel.sorted.back());
    }
    const auto count = static_cast<double>(chart_.texels.size());
    ExactTransform::Plane plane(height_ * width_, 0);
    for (std::size_t i = 0; i < chart_.texels.size(); ++i)
      plane[place(i)] = static_cast<double>(channel.sorted[i]) - sum / count;
    std::sort(channel.sorted.begin(), channel.sorted.end());
    const auto found = exact.forward(plane);
    auto covariance = exact.inverse(squared(found));
    for (std::size_t i = 0; i < covariance.size(); ++i)
      covariance[i] *= static_cast<double>(plane.size()) / std::max(pairs[i], least_share * count);
    const auto power = exact.forward(covariance);
    for (std::size_t k = 0; k < power.size(); ++k)
      channel.optimised.emplace_back(std::sqrt(std::max(power[k].real(), 0.0)) * unit(found[k]));
    channel.optimised[0] = 0;  // the mean is a matter of the values
    return channel;
  }

  /// Pairs of places that both lie in the chart, by their distance.
  [[nodiscard]] ExactTransform::Plane pairs_by_lag(const ExactTransform& exact) const {
    ExactTransform::Plane inside(height_ * width_, 0);
    for (std::size_t i = 0; i < chart_.texels.size(); ++i) inside[place(i)] = 1;
    return exact.inverse(squared(exact.forward(inside)));
  }

  static ExactTransform::Spectrum squared(ExactTransform::Spectrum spectrum) {
    for (auto& value : spectrum) value = std::norm(value);
    return spectrum;
  }

  /// The planes whose spectra are X · e^(iα).
  void impose_spectrum() {
    for (NoiseChannel& channel : channels_) {
      channel.spectrum = channel.optimised;
      for (std::size_t k = 0; k < phases_.size(); ++k) channel.spectrum[k] *= phases_[k];
      channel.plane = transform_.inverse(std::move(channel.spectrum));
    }
  }

  const raster::TextureChart& chart_;
  std::size_t height_, width_;  ///< of the box
  NoiseTransform transform_;
  std::vector<NoiseChannel> channels_;
  NoiseTransform::Spectrum phases_;  ///< e^(iα)
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
