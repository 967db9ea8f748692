#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tapestry::nn {
/// How RoiAlign lays samples in a box. Source: onnx.ai, Operators.md, RoiAlign; He et al., "Mask R-CNN"
/// (2017).
struct RoiSampling {
  bool takes_largest = false;  ///< of the weighted pixels of all samples, instead of the samples' mean
  bool is_half_pixel = true;   ///< pixel centres lie at +½; if not, boxes are at least one pixel large
  std::size_t rows = 1, columns = 1;  ///< of the result
  std::size_t samples =
      0;  ///< of an output pixel, along each axis; 0: one for each pixel of the input that it covers
  double scale = 1;  ///< pixels of the input per unit of the boxes
};

namespace detail {
/// The two pixels between which a sample lies along one axis, and the share of the second.
struct RoiTaps {
  std::size_t low = 0, high = 0;
  double share = 0;
  bool is_outside = false;  ///< more than a pixel outside the picture: counts as 0
  bool moves = false;       ///< whether the share grows with the place

  RoiTaps(double place, std::size_t extent) {
    const auto last = static_cast<double>(extent) - 1;
    is_outside = !(place >= -1 && place <= static_cast<double>(extent));
    if (is_outside) return;
    const double inside = std::max(place, 0.0);
    low = std::min(static_cast<std::size_t>(inside), extent - 1);
    high = std::min(low + 1, extent - 1);
    if (inside < last) share = inside - static_cast<double>(low);
    moves = place > 0 && inside < last;
  }
};

/// A box along one axis of the input.
struct RoiAxis {
  double first = 0, bin = 0;
  std::size_t samples = 1;  ///< of a bin; 0 for a box that is empty, or of more than 2^31 pixels a bin
  bool is_least = false;    ///< widened to one pixel
  std::size_t bins = 1;

  RoiAxis(double low, double high, std::size_t bins_of, const RoiSampling& rule) : bins(bins_of) {
    const double shift = rule.is_half_pixel ? 0.5 : 0;
    first = low * rule.scale - shift;
    double extent = high * rule.scale - shift - first;
    is_least = !rule.is_half_pixel && extent < 1;
    if (is_least) extent = 1;
    bin = extent / static_cast<double>(bins);
    samples = rule.samples;
    if (samples == 0 && bin > 0 && bin < 0x1p31) samples = static_cast<std::size_t>(std::ceil(bin));
  }
  /// The samples of a bin that may lie within a pixel of a picture; others count as 0.
  [[nodiscard]] std::array<std::size_t, 2> inside(std::size_t index, std::size_t extent) const {
    const auto count = static_cast<double>(samples);
    if (!(bin > 0) || samples == 0) return {0, samples};
    const auto sample_at = [&](double place) {
      return ((place - first) / bin - static_cast<double>(index)) * count - 0.5;
    };
    const double begin = std::floor(sample_at(-1)) - 1,
                 end = std::ceil(sample_at(static_cast<double>(extent))) + 2;
    return {static_cast<std::size_t>(std::clamp(begin, 0.0, count)),
            static_cast<std::size_t>(std::clamp(end, 0.0, count))};
  }
  /// Place of a sample as a share of the box.
  [[nodiscard]] double share(std::size_t index, std::size_t sample) const {
    return (static_cast<double>(index) + (static_cast<double>(sample) + 0.5) / static_cast<double>(samples)) /
           static_cast<double>(bins);
  }
  [[nodiscard]] double place(double share) const { return first + share * bin * static_cast<double>(bins); }
};
}  // namespace detail
}  // namespace tapestry::nn
