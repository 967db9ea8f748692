#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/decode_family.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/nn/activation.hpp>
#include <vector>

namespace tapestry::detect {

/// One class of one candidate box.
struct Detection {
  std::size_t class_index = 0;
  double confidence = 0;  ///< probability of an object times that of its class
  double objectness = 0;  ///< probability of an object
  Box box{};              ///< pixels of the network's input
  std::size_t head = 0;
  std::size_t candidate = 0;  ///< (anchor · H + row) · W + column within its head
};

/// Bound on w and h logits of the darknet family before the exponential, so that a box stays finite: e^50 is
/// 5·10²¹.
inline constexpr double largest_extent_logit = 50;

/// Offset of a centre from the upper left corner of its cell, in cells; see DecodeFamily.
[[nodiscard]] inline double centre_offset(const Head& head, double logit) {
  if (head.decode == DecodeFamily::scaled) return logit * head.scale_x_y - (head.scale_x_y - 1) / 2;
  if (head.decode == DecodeFamily::ultralytics) return 2 * nn::logistic(logit) - 0.5;
  return (nn::logistic(logit) - 0.5) * head.scale_x_y + 0.5;
}

/// Width or height of a box as a multiple of its anchor's; see DecodeFamily. That of the darknet family is
/// bounded by largest_extent_logit; that of the others lies in [0, 4].
[[nodiscard]] inline double extent_factor(const Head& head, double logit) {
  if (head.decode == DecodeFamily::darknet)
    return std::exp(logit > largest_extent_logit ? largest_extent_logit : logit);
  const double twice = 2 * (head.decode == DecodeFamily::scaled ? logit : nn::logistic(logit));
  return twice * twice;
}

/// Probability that an output for objectness or a class stands for: σ of it, or itself for the decode family
/// scaled.
[[nodiscard]] inline double probability(const Head& head, double logit) {
  return head.decode == DecodeFamily::scaled ? logit : nn::logistic(logit);
}

/// ∂centre_offset/∂logit.
[[nodiscard]] inline double centre_offset_slope(const Head& head, double logit) {
  if (head.decode == DecodeFamily::scaled) return head.scale_x_y;
  const double scale = head.decode == DecodeFamily::ultralytics ? 2 : head.scale_x_y;
  return nn::logistic(logit) * nn::logistic(-logit) * scale;
}

/// ∂extent/∂logit of a width or height, extent_factor() times the anchor's; 0 where the logit is bounded.
[[nodiscard]] inline double extent_slope(const Head& head, double logit, double extent) {
  if (head.decode == DecodeFamily::ultralytics)
    return 2 * extent * nn::logistic(-logit);  // 8 · σ · σ' · anchor
  if (head.decode == DecodeFamily::scaled) return logit == 0 ? 0 : 2 * extent / logit;  // 8 · t · anchor
  return logit > largest_extent_logit ? 0 : extent;
}

/// ∂probability/∂logit; keeps its digits where σ rounds to 1.
[[nodiscard]] inline double probability_slope(const Head& head, double logit) {
  return head.decode == DecodeFamily::scaled ? 1 : nn::logistic(logit) * nn::logistic(-logit);
}

/// Box of one candidate from its four logits by the decode family of its head.
///
/// \param logits  of x, y, w, h; for the family scaled activations in [0, 1]
/// \returns  the box in pixels of an input of input_width × input_height
[[nodiscard]] inline Box decode_box(const Head& head, std::size_t anchor, std::size_t row, std::size_t column,
                                    const double (&logits)[4], double input_width, double input_height) {
  const auto centre = [&](double logit, std::size_t cell) {
    return centre_offset(head, logit) + static_cast<double>(cell);
  };
  return {centre(logits[0], column) / static_cast<double>(head.grid_width) * input_width,
          centre(logits[1], row) / static_cast<double>(head.grid_height) * input_height,
          extent_factor(head, logits[2]) * head.anchors[anchor][0],
          extent_factor(head, logits[3]) * head.anchors[anchor][1]};
}

/// Every class of every candidate whose confidence is above the threshold, in the order head, candidate,
/// class, each head by its own decode family. Candidates with a NaN among their logits are never above it.
///
/// \param logits  one [N, A·(5+K), H, W] for each head; of the family scaled activations in [0, 1]
/// \param image   which of the N
/// \throws ShapeError if the logits do not fit the heads, DomainError if there is no such image
template <std::floating_point T>
[[nodiscard]] std::vector<Detection> decode(const std::vector<Head>& heads,
                                            const std::vector<Array<T, 4>>& logits, std::size_t image,
                                            double confidence_threshold, std::size_t input_height,
                                            std::size_t input_width) {
  if (logits.size() != heads.size())
    throw ShapeError("decode: number of logit arrays differs from that of heads");
  std::vector<Detection> detections;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const Head& head = heads[h];
    const std::size_t cells = head.grid_height * head.grid_width;
    if (image >= logits[h].shape(0)) throw DomainError("decode: no image " + std::to_string(image));
    require_shape("decode", "logits", logits[h],
                  {logits[h].shape(0), head.channel_count(), head.grid_height, head.grid_width});
    const T* of_image = logits[h].data() + image * head.channel_count() * cells;
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells;
      const std::size_t cell = candidate % cells;
      const T* first = of_image + anchor * (5 + head.classes) * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double objectness = probability(head, logit(4));
      if (!(objectness > confidence_threshold)) continue;  // the class factor is at most 1
      std::optional<Box> box;                              // most candidates have no class that asks for it
      for (std::size_t k = 0; k < head.classes; ++k) {
        const double confidence = objectness * probability(head, logit(5 + k));
        if (!(confidence > confidence_threshold)) continue;
        if (!box)
          box = decode_box(head, anchor, cell / head.grid_width, cell % head.grid_width,
                           {logit(0), logit(1), logit(2), logit(3)}, static_cast<double>(input_width),
                           static_cast<double>(input_height));
        if (!std::isfinite(box->cx + box->cy + box->w + box->h)) break;
        detections.push_back({k, confidence, objectness, *box, h, candidate});
      }
    }
  }
  return detections;
}

}  // namespace tapestry::detect
