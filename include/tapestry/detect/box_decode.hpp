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
#include <tapestry/detect/head.hpp>
#include <tapestry/nn/activation.hpp>
#include <vector>

namespace tapestry::detect {

/// One class of one candidate box.
struct Detection {
  std::size_t class_index = 0;
  double confidence = 0;  ///< σ(objectness) · σ(class)
  double objectness = 0;  ///< σ(objectness)
  Box box{};              ///< pixels of the network's input
  std::size_t head = 0;
  std::size_t candidate = 0;  ///< (anchor · H + row) · W + column within its head
};

/// Bound on |w| and |h| logits before the exponential, so that a box stays finite: e^50 is 5·10²¹.
inline constexpr double largest_extent_logit = 50;

/// Box of one candidate from its four logits, in Darknet's convention:
///
///   x = ((σ(tx) − ½)·s + ½ + column)/W,   w = e^tw · anchor_w,   y and h alike
///
/// Source: Redmon and Farhadi, YOLOv3 (2018), section 2.1; s is Bochkovskiy's scale_x_y.
/// \returns  the box in pixels of an input of input_width × input_height
[[nodiscard]] inline Box decode_box(const Head& head, std::size_t anchor, std::size_t row, std::size_t column,
                                    const double (&logits)[4], double input_width, double input_height) {
  const auto centre = [&](double logit, std::size_t cell) {
    return (nn::logistic(logit) - 0.5) * head.scale_x_y + 0.5 + static_cast<double>(cell);
  };
  const auto extent = [](double logit) {
    return std::exp(logit > largest_extent_logit ? largest_extent_logit : logit);
  };
  return {centre(logits[0], column) / static_cast<double>(head.grid_width) * input_width,
          centre(logits[1], row) / static_cast<double>(head.grid_height) * input_height,
          extent(logits[2]) * head.anchors[anchor][0], extent(logits[3]) * head.anchors[anchor][1]};
}

/// Every class of every candidate whose confidence is above the threshold, in the order head, candidate,
/// class. Candidates with a NaN among their logits are never above it.
///
/// \param logits  one [N, A·(5+K), H, W] for each head
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
      const double objectness = nn::logistic(logit(4));
      if (!(objectness > confidence_threshold)) continue;  // the class factor is at most 1
      std::optional<Box> box;                              // most candidates have no class that asks for it
      for (std::size_t k = 0; k < head.classes; ++k) {
        const double confidence = objectness * nn::logistic(logit(5 + k));
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
