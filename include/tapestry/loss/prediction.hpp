#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_decode.hpp>  // Head, decode_box
#include <tapestry/loss/logistic.hpp>
#include <tapestry/loss/overlap.hpp>
#include <vector>

namespace tapestry::loss {

/// What an adversarial loss wants hidden, or what a detector is trained to find.
struct Target {
  std::size_t class_index = 0;
  detect::Box box{0, 0, 0, 0};  ///< pixels of the network's input; may reach over the border
};

/// Where the logits of every head are, [N, A·(5+K), H, W], before any sigmoid; none null.
template <class T>
using LogitsView = std::vector<const Array<T, 4>*>;

/// One image's raw output of all heads, as a view: neither heads nor logits are copied.
template <class T>
struct Predictions {
  const std::vector<detect::Head>& heads;
  LogitsView<T> logits;
  std::size_t image;                      ///< which of the N
  std::size_t input_height, input_width;  ///< of the network, pixels
};

/// Where a loss adds its derivatives: per head an array of the shape of its logits; null where not wanted.
template <class T>
using LogitsAdjoint = std::vector<Array<T, 4>*>;

/// Where arrays are, to read.
template <class T>
[[nodiscard]] LogitsView<T> to_read(const std::vector<Array<T, 4>>& arrays) {
  LogitsView<T> addresses;
  for (const auto& array : arrays) addresses.push_back(&array);
  return addresses;
}
template <class T>
void to_read(const std::vector<Array<T, 4>>&& temporaries) = delete;

/// Where arrays are, to add to.
template <class T>
[[nodiscard]] LogitsAdjoint<T> to_add_to(std::vector<Array<T, 4>>& arrays) {
  LogitsAdjoint<T> addresses;
  for (auto& array : arrays) addresses.push_back(&array);
  return addresses;
}

/// What losses of a batch have to know of the network that gave the logits; detect::Network is one.
template <class D>
concept Detector = requires(const D& detector) {
  { detector.heads() } -> std::convertible_to<const std::vector<detect::Head>&>;
  { detector.input_height() } -> std::convertible_to<std::size_t>;
  { detector.input_width() } -> std::convertible_to<std::size_t>;
};

/// The place of one predicted box. The order of candidates, in which ties go to the first, is by head,
/// then anchor, then row, then column.
struct Candidate {
  std::size_t head = 0, anchor = 0, row = 0, column = 0;
  bool operator==(const Candidate&) const = default;
};

/// Channels of a candidate; class k is at class_channel + k.
enum Channel : std::size_t { x_channel, y_channel, w_channel, h_channel, objectness_channel, class_channel };

/// Losses are functions of raw logits, which heads of the decode family scaled do not hand over: σ is taken
/// in the network before them, and where it rounds to 1 no slope is left.
/// \throws DomainError if a head is of that family
inline void require_raw_logits(const char* operation, const std::vector<detect::Head>& heads) {
  for (const auto& head : heads)
    if (head.decode == detect::DecodeFamily::scaled)
      throw DomainError(
          std::string(operation) +
          ": heads of the decode family scaled (new_coords=1) give activations, but losses need "
          "raw logits; expected darknet or ultralytics");
}

/// \throws ShapeError if the logits do not belong to the heads; DomainError if there is no such image or a
///         head gives no raw logits
template <class T>
void require_predictions(const char* operation, const Predictions<T>& predictions) {
  const std::string name(operation);
  if (predictions.logits.size() != predictions.heads.size())
    throw ShapeError(name + ": logits of " + std::to_string(predictions.logits.size()) + " heads, expected " +
                     std::to_string(predictions.heads.size()));
  require_raw_logits(operation, predictions.heads);
  for (std::size_t i = 0; i < predictions.heads.size(); ++i) {
    const auto& head = predictions.heads[i];
    const auto& logits = *predictions.logits[i];
    require_shape(
        operation, "logits", logits,
        {logits.shape(0), head.anchors.size() * (5 + head.classes), head.grid_height, head.grid_width});
    if (predictions.image >= logits.shape(0))
      throw DomainError(name + ": image " + std::to_string(predictions.image) + " of a batch of " +
                        std::to_string(logits.shape(0)));
  }
}

/// \throws DomainError if there are no images; ShapeError if the logits are of another number
template <class T>
void require_batch(const char* operation, const char* argument, std::size_t images,
                   const LogitsView<T>& logits) {
  if (images == 0) throw DomainError(std::string(operation) + ": an empty batch");
  for (const auto* head : logits)
    if (head->shape(0) != images)
      throw ShapeError(std::string(operation) + ": " + argument + " of " + std::to_string(images) +
                       " images, expected " + std::to_string(head->shape(0)));
}

/// \throws DomainError if the class is none of the heads' or the box is not finite
template <class T>
void require_target(const char* operation, const Predictions<T>& predictions, const Target& target) {
  const auto& [cx, cy, w, h] = target.box;
  if (!std::isfinite(cx + cy + w + h))
    throw DomainError(std::string(operation) + ": the target box is not finite");
  for (const auto& head : predictions.heads)
    if (target.class_index >= head.classes)
      throw DomainError(std::string(operation) + ": class " + std::to_string(target.class_index) + " of " +
                        std::to_string(head.classes));
}

/// \throws ShapeError if the adjoint does not have the shapes of the logits, where it is wanted
template <class T>
void require_adjoint(const char* operation, const Predictions<T>& predictions,
                     const LogitsAdjoint<T>& logits_adjoint) {
  if (logits_adjoint.size() != predictions.logits.size())
    throw ShapeError(std::string(operation) + ": logits_adjoint of " + std::to_string(logits_adjoint.size()) +
                     " heads, expected " + std::to_string(predictions.logits.size()));
  for (std::size_t i = 0; i < logits_adjoint.size(); ++i)
    if (logits_adjoint[i] != nullptr)
      require_shape(operation, "logits_adjoint", *logits_adjoint[i], predictions.logits[i]->shape());
}

/// Position of one channel of a candidate in its head's logits.
template <class T>
[[nodiscard]] std::size_t logit_index(const Predictions<T>& predictions, const Candidate& candidate,
                                      std::size_t channel) {
  const auto& head = predictions.heads[candidate.head];
  const std::size_t depth = 5 + head.classes;
  const std::size_t plane = (predictions.image * head.anchors.size() + candidate.anchor) * depth + channel;
  return (plane * head.grid_height + candidate.row) * head.grid_width + candidate.column;
}

/// One number of a candidate: x, y, w, h, objectness, then the classes.
template <class T>
[[nodiscard]] double logit(const Predictions<T>& predictions, const Candidate& candidate,
                           std::size_t channel) {
  return static_cast<double>(
      predictions.logits[candidate.head]->data()[logit_index(predictions, candidate, channel)]);
}

/// The box that a candidate predicts, in pixels of the input; see detect::decode_box().
template <class T>
[[nodiscard]] detect::Box decoded_box(const Predictions<T>& predictions, const Candidate& candidate) {
  const auto at = [&](std::size_t channel) { return logit(predictions, candidate, channel); };
  return detect::decode_box(predictions.heads[candidate.head], candidate.anchor, candidate.row,
                            candidate.column, {at(x_channel), at(y_channel), at(w_channel), at(h_channel)},
                            static_cast<double>(predictions.input_width),
                            static_cast<double>(predictions.input_height));
}

/// Adds slope to the adjoint of one channel of a candidate, if wanted.
template <class T>
void add_to_logit(const Predictions<T>& predictions, const Candidate& candidate, std::size_t channel,
                  double slope, const LogitsAdjoint<T>& logits_adjoint) {
  Array<T, 4>* const adjoint = logits_adjoint[candidate.head];
  if (adjoint == nullptr) return;
  adjoint->data()[logit_index(predictions, candidate, channel)] += static_cast<T>(slope);
}

/// Adds the pullback of decoded_box(), see detect::centre_offset_slope() and extent_slope(). A component of
/// box_adjoint that is 0 adds nothing, however large the box is.
template <class T>
void decoded_box_adjoint(const Predictions<T>& predictions, const Candidate& candidate,
                         const detect::Box& box_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  const auto& head = predictions.heads[candidate.head];
  const detect::Box box = decoded_box(predictions, candidate);
  const auto centre_slope = [&](std::size_t channel, std::size_t cells, std::size_t extent) {
    return detect::centre_offset_slope(head, logit(predictions, candidate, channel)) *
           static_cast<double>(extent) / static_cast<double>(cells);
  };
  const auto extent_slope = [&](std::size_t channel, double extent) {
    return detect::extent_slope(head, logit(predictions, candidate, channel), extent);
  };
  const auto add = [&](std::size_t channel, double adjoint, double slope) {
    if (adjoint != 0) add_to_logit(predictions, candidate, channel, adjoint * slope, logits_adjoint);
  };
  add(x_channel, box_adjoint.cx, centre_slope(x_channel, head.grid_width, predictions.input_width));
  add(y_channel, box_adjoint.cy, centre_slope(y_channel, head.grid_height, predictions.input_height));
  add(w_channel, box_adjoint.w, extent_slope(w_channel, box.w));
  add(h_channel, box_adjoint.h, extent_slope(h_channel, box.h));
}

/// Calls visit(candidate) for all candidates of one head, in order.
template <class Visit>
void for_each_candidate(std::size_t head_index, const detect::Head& head, Visit visit) {
  for (std::size_t anchor = 0; anchor < head.anchors.size(); ++anchor)
    for (std::size_t row = 0; row < head.grid_height; ++row)
      for (std::size_t column = 0; column < head.grid_width; ++column)
        visit(Candidate{head_index, anchor, row, column});
}

}  // namespace tapestry::loss
