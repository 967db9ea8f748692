#pragma once
#include <tapestry/detect/detector_variable.hpp>

namespace tapestry::detect {
/// Decoded candidates of a head, numbered (anchor · H + row) · W + column as in Detection.
template <std::floating_point T>
struct DecodedHead {
  ArrayVariable<T, 3> boxes;       ///< [N, candidate, 4]: cx, cy, w, h in pixels of the network's input
  ArrayVariable<T, 3> objectness;  ///< [N, candidate, 1], in [0, 1]; of a head without objectness that of the
                                   ///< surest class, see surest_channel(), where its derivative goes
  ArrayVariable<T, 3> classes;     ///< [N, candidate, K], in [0, 1]
  bool has_objectness = true;
};

/// Confidence of a head in each class of each candidate, [N, candidate, K]: objectness times classes, or
/// classes alone where a head has no objectness.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> confidences(const DecodedHead<T>& head);

/// The boxes and scores of every candidate of a head on the tape, by its decode family, as one record; all
/// families are differentiable. A w or h beyond largest_extent_logit has no slope.
///
/// \param logits  [N, A·D, H, W], see Head; of the family scaled activations in [0, 1]
/// \throws ShapeError if the logits do not fit the head, DomainError as require_layout()
template <std::floating_point T>
[[nodiscard]] DecodedHead<T> decode(const Head& head, const ArrayVariable<T, 4>& logits,
                                    std::size_t input_height, std::size_t input_width);

namespace detail {
/// decode() of each of these heads.
template <std::floating_point T>
[[nodiscard]] std::vector<DecodedHead<T>> decoded_heads(const std::vector<Head>& heads,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        std::size_t input_height, std::size_t input_width);
}  // namespace detail

/// decode() of every head of a detector.
/// \param detector  with heads(), input_height() and input_width(), such as Network
template <class Detector, std::floating_point T>
[[nodiscard]] std::vector<DecodedHead<T>> decode(const Detector& detector,
                                                 const std::vector<ArrayVariable<T, 4>>& logits) {
  return detail::decoded_heads(detector.heads(), logits, detector.input_height(), detector.input_width());
}

/// Confidence of the surest of all candidates and classes in a batch of pictures: the largest of
/// confidences(), from 0 to 1, before suppression. The first of equals has the derivative.
///
/// \param detector  with heads(), input_height() and input_width()
/// \param logits    of forward()
/// \throws as decode()
template <class Detector, std::floating_point T>
[[nodiscard]] Variable<T> best_score(const Detector& detector,
                                     const std::vector<ArrayVariable<T, 4>>& logits) {
  Variable<T> best = 0;
  for (const DecodedHead<T>& head : decode(detector, logits)) {
    const ArrayVariable<T, 1> of_images = largest_along(largest_along(confidences(head), 2), 1);
    for (std::size_t n = 0; n < of_images.size(); ++n) best = max(best, element(of_images, {n}));
  }
  return best;
}
}  // namespace tapestry::detect
