#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <vector>

namespace tapestry::detect {

/// What a head says of all its candidates, numbered (anchor · H + row) · W + column as Detection has them.
template <std::floating_point T>
struct DecodedHead {
  ArrayVariable<T, 3> boxes;       ///< [N, candidate, 4]: cx, cy, w, h in pixels of the network's input
  ArrayVariable<T, 3> objectness;  ///< [N, candidate, 1], in [0, 1]
  ArrayVariable<T, 3> classes;     ///< [N, candidate, K], in [0, 1]; times objectness: the confidence
};

namespace detail {

/// Calls visit(image, candidate, anchor, row, column, first) for every candidate of a batch; its channel c
/// lies at first + c · H · W of the logits.
template <class Visit>
void for_each_decoded(const Head& head, std::size_t images, Visit visit) {
  const std::size_t cells = head.grid_height * head.grid_width;
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const std::size_t first = (n * head.channel_count() + anchor * (5 + head.classes)) * cells + cell;
      visit(n, candidate, anchor, cell / head.grid_width, cell % head.grid_width, first);
    }
}

template <class T>
[[nodiscard]] std::vector<Array<T, 3>> decoded_arrays(const Head& head, const Array<T, 4>& logits,
                                                      double input_height, double input_width) {
  const std::size_t images = logits.shape(0), count = head.candidate_count();
  const std::size_t cells = head.grid_height * head.grid_width;
  std::vector<Array<T, 3>> arrays{Array<T, 3>(Extents<3>{images, count, 4}),
                                  Array<T, 3>(Extents<3>{images, count, 1}),
                                  Array<T, 3>(Extents<3>{images, count, head.classes})};
  for_each_decoded(head, images,
                   [&](std::size_t n, std::size_t candidate, std::size_t anchor, std::size_t row,
                       std::size_t column, std::size_t first) {
                     const auto logit = [&](std::size_t channel) {
                       return static_cast<double>(logits.data()[first + channel * cells]);
                     };
                     const Box box =
                         decode_box(head, anchor, row, column, {logit(0), logit(1), logit(2), logit(3)},
                                    input_width, input_height);
                     const std::array<double, 4> values{box.cx, box.cy, box.w, box.h};
                     for (std::size_t i = 0; i < 4; ++i)
                       arrays[0](n, candidate, i) = static_cast<T>(values[i]);
                     arrays[1](n, candidate, 0) = static_cast<T>(probability(head, logit(4)));
                     for (std::size_t k = 0; k < head.classes; ++k)
                       arrays[2](n, candidate, k) = static_cast<T>(probability(head, logit(5 + k)));
                   });
  return arrays;
}

/// Adds the pullback of decoded_arrays(); null for what nothing depends on.
template <class T>
void decoded_arrays_adjoint(const Head& head, const Array<T, 4>& logits, double input_height,
                            double input_width, const std::vector<const Array<T, 3>*>& adjoints,
                            Array<T, 4>& logits_adjoint) {
  const std::size_t cells = head.grid_height * head.grid_width;
  const double x_scale = input_width / static_cast<double>(head.grid_width);
  const double y_scale = input_height / static_cast<double>(head.grid_height);
  for_each_decoded(head, logits.shape(0),
                   [&](std::size_t n, std::size_t candidate, std::size_t anchor, std::size_t, std::size_t,
                       std::size_t first) {
                     const auto add = [&](std::size_t channel, T adjoint, auto slope_of) {
                       if (adjoint == T(0)) return;  // adds nothing, however large the box is
                       const auto at = first + channel * cells;
                       const double slope = slope_of(static_cast<double>(logits.data()[at]));
                       logits_adjoint.data()[at] += static_cast<T>(static_cast<double>(adjoint) * slope);
                     };
                     const auto centre = [&](double scale) {
                       return [&head, scale](double t) { return scale * centre_offset_slope(head, t); };
                     };
                     const auto extent = [&](std::size_t axis) {
                       const double of_anchor = head.anchors[anchor][axis];
                       return [&head, of_anchor](double t) {
                         return extent_slope(head, t, extent_factor(head, t) * of_anchor);
                       };
                     };
                     const auto score = [&head](double t) { return probability_slope(head, t); };
                     if (adjoints[0] != nullptr) {
                       add(0, (*adjoints[0])(n, candidate, 0), centre(x_scale));
                       add(1, (*adjoints[0])(n, candidate, 1), centre(y_scale));
                       add(2, (*adjoints[0])(n, candidate, 2), extent(0));
                       add(3, (*adjoints[0])(n, candidate, 3), extent(1));
                     }
                     if (adjoints[1] != nullptr) add(4, (*adjoints[1])(n, candidate, 0), score);
                     for (std::size_t k = 0; adjoints[2] != nullptr && k < head.classes; ++k)
                       add(5 + k, (*adjoints[2])(n, candidate, k), score);
                   });
}

}  // namespace detail

/// The boxes and scores of every candidate of a head on the tape, by its decode family, as one record; all
/// three families are differentiable. A w or h beyond largest_extent_logit has no slope.
///
/// \param logits  [N, A·(5+K), H, W]; of the family scaled activations in [0, 1]
/// \throws ShapeError if the logits do not fit the head
template <std::floating_point T>
[[nodiscard]] DecodedHead<T> decode(const Head& head, const ArrayVariable<T, 4>& logits,
                                    std::size_t input_height, std::size_t input_width) {
  require_shape("decode", "logits", logits.value(),
                {logits.shape()[0], head.channel_count(), head.grid_height, head.grid_width});
  const auto height = static_cast<double>(input_height), width = static_cast<double>(input_width);
  const auto pullback = [head, values = logits.shared_value(), height, width](
                            const std::vector<const Array<T, 3>*>& adjoints, Array<T, 4>* logits_adjoint) {
    detail::decoded_arrays_adjoint(head, *values, height, width, adjoints, *logits_adjoint);
  };
  auto results =
      record_arrays<T, 3>(detail::decoded_arrays(head, logits.value(), height, width), pullback, logits);
  return {results[0], results[1], results[2]};
}

/// decode() of every head of a detector.
/// \param detector  with heads(), input_height() and input_width(), such as Network
template <class Detector, std::floating_point T>
[[nodiscard]] std::vector<DecodedHead<T>> decode(const Detector& detector,
                                                 const std::vector<ArrayVariable<T, 4>>& logits) {
  if (logits.size() != detector.heads().size())
    throw ShapeError("decode: logits of " + std::to_string(logits.size()) + " heads, expected " +
                     std::to_string(detector.heads().size()));
  std::vector<DecodedHead<T>> heads;
  for (std::size_t h = 0; h < logits.size(); ++h)
    heads.push_back(decode(detector.heads()[h], logits[h], detector.input_height(), detector.input_width()));
  return heads;
}

}  // namespace tapestry::detect
