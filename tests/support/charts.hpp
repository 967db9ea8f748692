#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/image/fourier_transform.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::test {
/// The places of a box with inside(row, column), as a chart whose texels begin at number `first`.
template <class Inside>
raster::TextureChart chart_of(std::size_t height, std::size_t width, Inside inside, std::size_t first = 0) {
  raster::TextureChart chart{height, width};
  for (std::size_t row = 0; row < height; ++row)
    for (std::size_t column = 0; column < width; ++column)
      if (inside(row, column)) chart.texels.push_back({row, column, first + chart.texels.size()});
  return chart;
}

inline raster::TextureChart rectangle_chart(std::size_t height, std::size_t width, std::size_t first = 0) {
  return chart_of(
      height, width, [](std::size_t, std::size_t) { return true; }, first);
}

/// Colours in [0, 1] for the texels of a chart that starts at 0: blobs of about two texels and a ramp, in
/// channels that have much in common, with most values at the ends.
inline Array<float, 2> blotched_colours(const raster::TextureChart& chart, std::uint64_t seed) {
  Random random(seed);
  Array<double, 2> white(Extents<2>{(chart.height + 4) * (chart.width + 4), 4});
  for (double& value : white.storage()) value = random.normal();
  const auto smooth = [&](const raster::ChartTexel& texel, std::size_t c) {
    double sum = 0;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t j = 0; j < 5; ++j) {
        const double dy = static_cast<double>(i) - 2, dx = static_cast<double>(j) - 2;
        sum += std::exp(-(dy * dy + dx * dx) / 2) *
               white((texel.row + i) * (chart.width + 4) + texel.column + j, c);
      }
    return sum;
  };
  Array<float, 2> colours(Extents<2>{chart.texels.size(), 3});
  for (const raster::ChartTexel& texel : chart.texels)
    for (std::size_t c = 0; c < 3; ++c) {
      const double ramp = static_cast<double>(texel.column) / static_cast<double>(chart.width) - 0.5;
      colours(texel.texel, c) =
          static_cast<float>(0.5 + 0.5 * std::tanh(0.6 * (smooth(texel, c) + smooth(texel, 3)) + ramp));
    }
  return colours;
}

/// The values of one channel of a chart, ascending.
template <class T>
std::vector<T> sorted_values(const Array<T, 2>& colours, const raster::TextureChart& chart, std::size_t c) {
  std::vector<T> values;
  for (const auto& texel : chart.texels) values.push_back(colours(texel.texel, c));
  std::sort(values.begin(), values.end());
  return values;
}

/// Mean of one channel over a chart.
inline double mean_of(const Array<float, 2>& colours, const raster::TextureChart& chart, std::size_t c) {
  double sum = 0;
  for (const auto& texel : chart.texels) sum += static_cast<double>(colours(texel.texel, c));
  return sum / static_cast<double>(chart.texels.size());
}

/// Pearson's coefficient of channel c of one picture and channel d of another over a chart.
inline double correlation(const Array<float, 2>& a, std::size_t c, const Array<float, 2>& b, std::size_t d,
                          const raster::TextureChart& chart) {
  const double mean_a = mean_of(a, chart, c), mean_b = mean_of(b, chart, d);
  double aa = 0, bb = 0, ab = 0;
  for (const auto& texel : chart.texels) {
    const double x = static_cast<double>(a(texel.texel, c)) - mean_a;
    const double y = static_cast<double>(b(texel.texel, d)) - mean_b;
    aa += x * x;
    bb += y * y;
    ab += x * y;
  }
  return ab / std::sqrt(aa * bb);
}

/// Amplitudes |F| of a channel's deviations from its mean, 0 outside the chart, over the box of the chart, in
/// bands of `band` × `band` frequencies: the root of their mean power.
inline std::vector<double> amplitudes(const Array<float, 2>& colours, const raster::TextureChart& chart,
                                      std::size_t c, std::size_t band = 1) {
  const image::FourierTransform<double> transform(chart.height, chart.width);
  image::FourierTransform<double>::Plane plane(chart.height * chart.width, 0);
  const double mean = mean_of(colours, chart, c);
  for (const auto& texel : chart.texels)
    plane[texel.row * chart.width + texel.column] = static_cast<double>(colours(texel.texel, c)) - mean;
  const auto spectrum = transform.forward(plane);
  const std::size_t columns = transform.spectrum_width();
  const std::size_t bands = (columns + band - 1) / band;
  std::vector<double> power(bands * ((chart.height + band - 1) / band), 0);
  for (std::size_t k = 0; k < chart.height; ++k)
    for (std::size_t l = 0; l < columns; ++l)
      power[k / band * bands + l / band] += std::norm(spectrum[k * columns + l]);
  for (double& value : power) value = std::sqrt(value / static_cast<double>(band * band));
  return power;
}

/// Distance of the amplitudes of `a` and `b`, relative to those of `b`, over the three channels.
inline double spectrum_distance(const Array<float, 2>& a, const Array<float, 2>& b,
                                const raster::TextureChart& chart, std::size_t band = 1) {
  double difference = 0, total = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    const auto of_a = amplitudes(a, chart, c, band), of_b = amplitudes(b, chart, c, band);
    for (std::size_t i = 0; i < of_a.size(); ++i) {
      difference += (of_a[i] - of_b[i]) * (of_a[i] - of_b[i]);
      total += of_b[i] * of_b[i];
    }
  }
  return std::sqrt(difference / total);
}

/// The texels of a chart that starts at 0 in random order, all channels together: white noise of its colours.
inline Array<float, 2> white_noise_of(const Array<float, 2>& colours, std::uint64_t seed) {
  std::vector<std::size_t> order(colours.shape(0));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  Random random(seed);
  random.shuffle(order);
  Array<float, 2> white(colours.shape());
  for (std::size_t i = 0; i < order.size(); ++i)
    for (std::size_t c = 0; c < 3; ++c) white(i, c) = colours(order[i], c);
  return white;
}
}  // namespace tapestry::test
