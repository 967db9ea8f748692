#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/detect/class_score.hpp>
#include <tapestry/loss/detail/logistic.hpp>

namespace tapestry::loss {
namespace detail {
void add(detect::Box& sum, const detect::Box& term, double scale);
}  // namespace detail

/// Intersection over union of a predicted box and a target, with its gradient.
struct Overlap {
  double iou = 0;
  detect::Box gradient{0, 0, 0, 0};  ///< ∂iou/∂box; the target is a constant
};

/// IoU and its gradient to the box: with I the area shared and U = wh + w'h' − I,
///
///   ∂IoU/∂x = ((1 + IoU) · ∂I/∂x − IoU · ∂(wh)/∂x) / U
///
/// Boxes that only touch, a box without area, and a box too large to have a finite area: IoU 0, gradient 0.
/// Where two edges coincide the gradient is the mean of its two one-sided values. A NaN box gives NaN.
[[nodiscard]] Overlap iou_with_gradient(const detect::Box& box, const detect::Box& target);

/// Complete IoU and its gradient.
struct CompleteOverlap {
  double iou = 0;
  double distance = 0;  ///< squared distance of the centres over the squared diagonal of the hull
  double aspect = 0;    ///< v = 4/π² · (atan(w'/h') − atan(w/h))²
  double alpha = 0;     ///< weight of v, a constant in the gradient
  detect::Box gradient{0, 0, 0, 0};  ///< ∂(iou − distance − alpha·aspect)/∂box with alpha held fixed

  [[nodiscard]] double value() const { return iou - distance - alpha * aspect; }
};

/// CIoU = IoU − ρ²/c² − αv with α = v / (1 − IoU + v), and 0 where v = 0. Unlike IoU it also differs between
/// boxes that do not meet; it lies in (−1.5, 1].
///
/// A box without area or too large to be measured has CIoU 0 and gradient 0; coinciding edges and NaN as
/// in iou_with_gradient(). Source: Zheng et al., "Distance-IoU loss" (AAAI 2020), eq. 7 to 12; α is not
/// differentiated, as there.
[[nodiscard]] CompleteOverlap complete_iou(const detect::Box& box, const detect::Box& target);

/// The object that an adversarial loss hides, or that a detector is trained to find.
struct Target {
  std::size_t class_index = 0;
  detect::Box box{0, 0, 0, 0};  ///< pixels of the network's input; may reach over the border
};

/// Per image the objects to be found.
using Truths = std::vector<std::vector<Target>>;

/// Logits of every head, [N, A·D, H, W] in the layout of detect::Head, before any sigmoid or softmax; none
/// null.
template <std::floating_point T>
using LogitsView = std::vector<const Array<T, 4>*>;

/// One image's raw output of all heads, as a view: neither heads nor logits are copied.
template <std::floating_point T>
struct Predictions {
  const std::vector<detect::Head>& heads;
  LogitsView<T> logits;
  std::size_t image;                      ///< index among the N
  std::size_t input_height, input_width;  ///< of the network, pixels
};

/// Arrays that a loss adds its derivatives to: per head an array of the shape of its logits; null where not
/// wanted.
template <std::floating_point T>
using LogitsAdjoint = std::vector<Array<T, 4>*>;

/// Pointers to arrays that are read.
template <std::floating_point T>
[[nodiscard]] LogitsView<T> to_read(const std::vector<Array<T, 4>>& arrays) {
  LogitsView<T> addresses;
  for (const auto& array : arrays) addresses.push_back(&array);
  return addresses;
}
template <std::floating_point T>
void to_read(const std::vector<Array<T, 4>>&& temporaries) = delete;

/// Pointers to arrays that are added to.
template <std::floating_point T>
[[nodiscard]] LogitsAdjoint<T> to_add_to(std::vector<Array<T, 4>>& arrays) {
  LogitsAdjoint<T> addresses;
  for (auto& array : arrays) addresses.push_back(&array);
  return addresses;
}

/// Properties of a network that losses of its logits need; detect::Detector has them.
template <class D>
concept DetectorLike = requires(const D& detector) {
  { detector.heads() } -> std::convertible_to<const std::vector<detect::Head>&>;
  { detector.input_height() } -> std::convertible_to<std::size_t>;
  { detector.input_width() } -> std::convertible_to<std::size_t>;
};

/// The place of one predicted box. Candidates are ordered by head, then anchor, row and column; of equal ones
/// the first counts.
struct Candidate {
  std::size_t head = 0, anchor = 0, row = 0, column = 0;
  bool operator==(const Candidate&) const = default;
};

using enum detect::BoxChannel;

/// Losses are functions of raw logits. Heads of the decode family scaled have none: σ is taken in the network
/// before them, and where it rounds to 1 no slope is left.
/// \param families  those that the operation takes, for the message
/// \throws DomainError if a head is of that family
inline void require_raw_logits(const char* operation, const std::vector<detect::Head>& heads,
                               const char* families = "darknet, ultralytics, yolox, distance or decoded") {
  for (const auto& head : heads)
    if (head.decode == detect::DecodeFamily::scaled)
      throw DomainError(
          {operation,
           ": heads of the decode family scaled (new_coords=1) give activations, but losses need "
           "raw logits; expected ",
           families});
}

/// \throws ShapeError if the logits do not belong to the heads; DomainError if there is no such image, a head
///         gives no raw logits, or as detect::require_layout()
template <std::floating_point T>
void require_predictions(const char* operation, const Predictions<T>& predictions) {
  const std::string name(operation);
  if (predictions.logits.size() != predictions.heads.size())
    throw ShapeError(
        {name, ": logits of ", predictions.logits.size(), " heads, expected ", predictions.heads.size()});
  require_raw_logits(operation, predictions.heads);
  for (std::size_t i = 0; i < predictions.heads.size(); ++i) {
    const auto& head = predictions.heads[i];
    const auto& logits = *predictions.logits[i];
    detect::require_layout(operation, head);
    require_shape(operation, "logits", logits,
                  {logits.shape(0), head.channel_count(), head.grid_height, head.grid_width});
    if (predictions.image >= logits.shape(0))
      throw DomainError({name, ": image ", predictions.image, " of a batch of ", logits.shape(0)});
  }
}

/// \throws DomainError if there are no images; ShapeError if the logits are of another number
template <std::floating_point T>
void require_batch(const char* operation, const char* argument, std::size_t images,
                   const LogitsView<T>& logits) {
  if (images == 0) throw DomainError({operation, ": an empty batch"});
  for (const auto* head : logits)
    if (head->shape(0) != images)
      throw ShapeError({operation, ": ", argument, " of ", images, " images, expected ", head->shape(0)});
}

/// \throws DomainError if the class is none of the heads' or the box is not finite
template <std::floating_point T>
void require_target(const char* operation, const Predictions<T>& predictions, const Target& target) {
  const auto& [cx, cy, w, h] = target.box;
  if (!std::isfinite(cx + cy + w + h)) throw DomainError({operation, ": the target box is not finite"});
  for (const auto& head : predictions.heads)
    if (target.class_index >= head.classes)
      throw DomainError({operation, ": class ", target.class_index, " of ", head.classes});
}

/// \throws ShapeError if the adjoint does not have the shapes of the logits, where it is wanted
template <std::floating_point T>
void require_adjoint(const char* operation, const Predictions<T>& predictions,
                     const LogitsAdjoint<T>& logits_adjoint) {
  if (logits_adjoint.size() != predictions.logits.size())
    throw ShapeError({operation, ": logits_adjoint of ", logits_adjoint.size(), " heads, expected ",
                      predictions.logits.size()});
  for (std::size_t i = 0; i < logits_adjoint.size(); ++i)
    if (logits_adjoint[i] != nullptr)
      require_shape(operation, "logits_adjoint", *logits_adjoint[i], predictions.logits[i]->shape());
}

/// Position of one channel of a candidate in its head's logits.
template <std::floating_point T>
[[nodiscard]] std::size_t logit_index(const Predictions<T>& predictions, const Candidate& candidate,
                                      std::size_t channel) {
  const auto& head = predictions.heads[candidate.head];
  const std::size_t depth = head.candidate_channel_count();
  const std::size_t plane = (predictions.image * head.anchor_count() + candidate.anchor) * depth + channel;
  return (plane * head.grid_height + candidate.row) * head.grid_width + candidate.column;
}

/// One candidate's logits, by channel in the head's layout.
template <std::floating_point T>
struct CandidateLogits {
  const T* first;      ///< channel 0
  std::size_t stride;  ///< elements between channels

  [[nodiscard]] double operator()(std::size_t channel) const {
    return static_cast<double>(first[channel * stride]);
  }
};

/// All numbers of a candidate, by channel.
template <std::floating_point T>
[[nodiscard]] CandidateLogits<T> logits_of(const Predictions<T>& predictions, const Candidate& candidate) {
  const auto& head = predictions.heads[candidate.head];
  return {predictions.logits[candidate.head]->data() + logit_index(predictions, candidate, 0),
          head.grid_height * head.grid_width};
}

/// One number of a candidate.
template <std::floating_point T>
[[nodiscard]] double logit(const Predictions<T>& predictions, const Candidate& candidate,
                           std::size_t channel) {
  return logits_of(predictions, candidate)(channel);
}

/// The channel of the logit that measures how surely a candidate holds something: its objectness, or, where
/// the head has none, the class that is looked for.
[[nodiscard]] inline std::size_t objectness_channel(const detect::Head& head, std::size_t class_index) {
  return head.objectness_channel().value_or(head.class_channel(class_index));
}

namespace detail {
template <std::floating_point T>
[[nodiscard]] detect::CandidatePlace place_of(const Predictions<T>& predictions, const Candidate& candidate) {
  return {candidate.anchor, candidate.row, candidate.column, static_cast<double>(predictions.input_width),
          static_cast<double>(predictions.input_height)};
}
}  // namespace detail

/// The box that a candidate predicts, in pixels of the input; see detect::decode_box().
template <std::floating_point T>
[[nodiscard]] detect::Box decoded_box(const Predictions<T>& predictions, const Candidate& candidate) {
  return detect::decode_box(predictions.heads[candidate.head], detail::place_of(predictions, candidate),
                            logits_of(predictions, candidate));
}

/// Adds slope to the adjoint of one channel of a candidate, if wanted.
template <std::floating_point T>
void add_to_logit(const Predictions<T>& predictions, const Candidate& candidate, std::size_t channel,
                  double slope, const LogitsAdjoint<T>& logits_adjoint) {
  Array<T, 4>* const adjoint = logits_adjoint[candidate.head];
  if (adjoint == nullptr) return;
  adjoint->data()[logit_index(predictions, candidate, channel)] += static_cast<T>(slope);
}

/// The number whose σ is a candidate's probability of a class; see detect::class_logit().
template <std::floating_point T>
[[nodiscard]] double class_logit(const Predictions<T>& predictions, const Candidate& candidate,
                                 std::size_t class_index) {
  return detect::class_logit(predictions.heads[candidate.head], class_index,
                             logits_of(predictions, candidate));
}

/// Adds the pullback of class_logit().
template <std::floating_point T>
void class_logit_adjoint(const Predictions<T>& predictions, const Candidate& candidate,
                         std::size_t class_index, double adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  detect::class_logit_adjoint(predictions.heads[candidate.head], class_index,
                              logits_of(predictions, candidate), adjoint,
                              [&](std::size_t channel, double slope) {
                                add_to_logit(predictions, candidate, channel, slope, logits_adjoint);
                              });
}

/// Adds the pullback of decoded_box(), see detect::decode_box_adjoint().
template <std::floating_point T>
void decoded_box_adjoint(const Predictions<T>& predictions, const Candidate& candidate,
                         const detect::Box& box_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  detect::decode_box_adjoint(predictions.heads[candidate.head], detail::place_of(predictions, candidate),
                             logits_of(predictions, candidate), box_adjoint,
                             [&](std::size_t channel, double slope) {
                               add_to_logit(predictions, candidate, channel, slope, logits_adjoint);
                             });
}

/// Calls visit(candidate) for all candidates of one head, in order.
template <class Visit>
void for_each_candidate(std::size_t head_index, const detect::Head& head, Visit visit) {
  for (std::size_t anchor = 0; anchor < head.anchor_count(); ++anchor)
    for (std::size_t row = 0; row < head.grid_height; ++row)
      for (std::size_t column = 0; column < head.grid_width; ++column)
        visit(Candidate{head_index, anchor, row, column});
}
}  // namespace tapestry::loss
