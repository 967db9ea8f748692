#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/detail/box_assignment.hpp>
#include <tapestry/loss/detail/prediction_variable.hpp>
#include <tapestry/loss/yolo_training.hpp>

namespace tapestry::loss {
namespace detail {
/// IoU of two boxes with a common centre.
[[nodiscard]] inline double shape_iou(double width, double height, const std::array<double, 2>& anchor) {
  const double shared = std::min(width, anchor[0]) * std::min(height, anchor[1]);
  return shared / (width * height + anchor[0] * anchor[1] - shared);
}

/// One candidate that has to predict a truth.
struct Assignment {
  Candidate candidate;
  const Target* truth;
};

/// Assigns truths to candidates: in the cell of the truth's centre the anchor, over all heads, whose shape
/// fits best (ties to the first), and those above match_iou. A candidate that two truths claim keeps the
/// first. Truths without area or with their centre outside the picture are left out.
template <std::floating_point T>
std::vector<Assignment> assignments(const Predictions<T>& predictions, const std::vector<Target>& truths,
                                    const YoloTrainingOptions& options) {
  std::vector<Assignment> assigned;
  const auto assign = [&](std::size_t head, std::size_t anchor, const Target& truth) {
    const GridCell cell =
        cell_of(predictions.heads[head], truth.box, predictions.input_height, predictions.input_width);
    const Candidate candidate{head, anchor, cell.row, cell.column};
    const auto is_taken = [&](const Assignment& other) { return other.candidate == candidate; };
    if (cell.exists && std::ranges::none_of(assigned, is_taken)) assigned.push_back({candidate, &truth});
  };
  for (const Target& truth : truths) {
    if (!(truth.box.w > 0 && truth.box.h > 0)) continue;
    std::size_t best_head = 0, best_anchor = 0;
    double best_iou = -1;
    for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
      const auto& anchors = predictions.heads[head].anchors;
      for (std::size_t anchor = 0; anchor < anchors.size(); ++anchor) {
        const double iou = shape_iou(truth.box.w, truth.box.h, anchors[anchor]);
        if (iou > options.match_iou) assign(head, anchor, truth);
        if (iou > best_iou) std::tie(best_head, best_anchor, best_iou) = std::tuple(head, anchor, iou);
      }
    }
    assign(best_head, best_anchor, truth);
  }
  return assigned;
}

/// Calls visit(candidate) for the unmatched candidates that should predict "no object".
template <std::floating_point T, class Visit>
void for_each_background(const Predictions<T>& predictions, const std::vector<Target>& truths,
                         const std::vector<Assignment>& assigned, double ignore_iou, Visit visit) {
  for (std::size_t head = 0; head < predictions.heads.size(); ++head)
    for_each_candidate(head, predictions.heads[head], [&](const Candidate& candidate) {
      const auto is_assigned = [&](const Assignment& other) { return other.candidate == candidate; };
      if (std::ranges::any_of(assigned, is_assigned)) return;
      if (!truths.empty()) {
        const detect::Box box = decoded_box(predictions, candidate);
        const auto overlaps = [&](const Target& truth) { return detect::iou(box, truth.box) > ignore_iou; };
        if (std::ranges::any_of(truths, overlaps)) return;
      }
      visit(candidate);
    });
}

/// Wanted values of an assigned candidate's four box logits: σ(tx), σ(ty), then tw and th or, in the
/// ultralytics family, σ(tw) and σ(th); and their weight.
struct BoxGoal {
  double x, y, w, h;
  double weight;  ///< 2 − share of the picture: small boxes count more
};

template <std::floating_point T>
BoxGoal box_goal(const Predictions<T>& predictions, const Assignment& assignment) {
  const auto& [candidate, truth] = assignment;
  const auto& head = predictions.heads[candidate.head];
  const auto& anchor = head.anchors[candidate.anchor];
  const auto width = static_cast<double>(predictions.input_width);
  const auto height = static_cast<double>(predictions.input_height);
  const bool is_ultralytics = head.decode == detect::DecodeFamily::ultralytics;
  const double scale = is_ultralytics ? 2 : head.scale_x_y;
  const auto offset = [&](double centre, double extent, std::size_t cells, std::size_t cell) {
    const double in_cell = centre / extent * static_cast<double>(cells) - static_cast<double>(cell);
    return std::clamp((in_cell - 0.5) / scale + 0.5, 0.0, 1.0);
  };
  const auto stretch = [&](double extent, double of_anchor) {
    return is_ultralytics ? std::min(1.0, std::sqrt(extent / of_anchor) / 2) : std::log(extent / of_anchor);
  };
  return {offset(truth->box.cx, width, head.grid_width, candidate.column),
          offset(truth->box.cy, height, head.grid_height, candidate.row), stretch(truth->box.w, anchor[0]),
          stretch(truth->box.h, anchor[1]),
          2 - std::min(1.0, truth->box.w * truth->box.h / (width * height))};
}

/// The loss of a w or h logit: the cross entropy with σ where its family applies σ to it, else half the
/// square.
[[nodiscard]] inline double extent_loss(const detect::Head& head, double logit, double wanted) {
  if (head.decode == detect::DecodeFamily::ultralytics) return binary_cross_entropy(logit, wanted);
  return (logit - wanted) * (logit - wanted) / 2;
}

[[nodiscard]] inline double extent_loss_slope(const detect::Head& head, double logit, double wanted) {
  if (head.decode == detect::DecodeFamily::ultralytics) return binary_cross_entropy_slope(logit, wanted);
  return logit - wanted;
}

/// Throws unless all heads have anchors and raw logits: truths are assigned to anchors.
inline void require_family(const char* operation, const std::vector<detect::Head>& heads) {
  require_raw_logits(operation, heads, "darknet or ultralytics");
  for (const auto& head : heads)
    if (!detect::has_anchors(head.decode))
      throw DomainError({operation, ": heads of the decode family ", detect::name_of(head.decode),
                         " have no anchors, which this loss needs; expected darknet or ultralytics"});
}

template <std::floating_point T>
YoloTrainingTerms image_terms(const Predictions<T>& predictions, const std::vector<Target>& truths,
                              const YoloTrainingOptions& options) {
  YoloTrainingTerms terms;
  const auto assigned = assignments(predictions, truths, options);
  for (const Assignment& assignment : assigned) {
    const auto at = [&](std::size_t channel) { return logit(predictions, assignment.candidate, channel); };
    const BoxGoal goal = box_goal(predictions, assignment);
    const auto& head = predictions.heads[assignment.candidate.head];
    terms.box += goal.weight *
                 (binary_cross_entropy(at(x_channel), goal.x) + binary_cross_entropy(at(y_channel), goal.y) +
                  extent_loss(head, at(w_channel), goal.w) + extent_loss(head, at(h_channel), goal.h));
    terms.objectness += binary_cross_entropy(at(*head.objectness_channel()), 1);
    terms.classification += class_entropy(predictions, assignment.candidate, assignment.truth->class_index);
  }
  for_each_background(predictions, truths, assigned, options.ignore_iou, [&](const Candidate& candidate) {
    const std::size_t channel = *predictions.heads[candidate.head].objectness_channel();
    terms.objectness += binary_cross_entropy(logit(predictions, candidate, channel), 0);
  });
  return terms;
}

template <std::floating_point T>
void image_terms_adjoint(const Predictions<T>& predictions, const std::vector<Target>& truths,
                         const YoloTrainingOptions& options, double adjoint,
                         const LogitsAdjoint<T>& logits_adjoint) {
  const auto assigned = assignments(predictions, truths, options);
  for (const Assignment& assignment : assigned) {
    const auto add = [&](std::size_t channel, double weight, auto slope_of) {
      const double slope = slope_of(logit(predictions, assignment.candidate, channel));
      add_to_logit(predictions, assignment.candidate, channel, adjoint * weight * slope, logits_adjoint);
    };
    const BoxGoal goal = box_goal(predictions, assignment);
    const auto& head = predictions.heads[assignment.candidate.head];
    const double box = options.box * goal.weight;
    add(x_channel, box, [&](double at) { return binary_cross_entropy_slope(at, goal.x); });
    add(y_channel, box, [&](double at) { return binary_cross_entropy_slope(at, goal.y); });
    add(w_channel, box, [&](double at) { return extent_loss_slope(head, at, goal.w); });
    add(h_channel, box, [&](double at) { return extent_loss_slope(head, at, goal.h); });
    add(*head.objectness_channel(), options.objectness,
        [](double at) { return binary_cross_entropy_slope(at, 1); });
    class_entropy_adjoint(predictions, assignment.candidate, assignment.truth->class_index,
                          adjoint * options.classification, logits_adjoint);
  }
  for_each_background(predictions, truths, assigned, options.ignore_iou, [&](const Candidate& candidate) {
    const std::size_t channel = *predictions.heads[candidate.head].objectness_channel();
    const double slope = binary_cross_entropy_slope(logit(predictions, candidate, channel), 0);
    add_to_logit(predictions, candidate, channel, adjoint * options.objectness * slope, logits_adjoint);
  });
}

/// The terms of a training loss on the tape, as one record.
/// \param options     with the weights of the terms
/// \param adjoint_of  adds to its second argument the total's derivative with the weights in its first
template <std::floating_point T, class Options, class AdjointOf>
[[nodiscard]] YoloTrainingVariables<T> record_training_terms(const YoloTrainingTerms& terms,
                                                             const Options& options, AdjointOf adjoint_of,
                                                             const std::vector<ArrayVariable<T, 4>>& logits) {
  const auto pullback = [options, adjoint_of](const Array<T, 1>& terms_adjoint,
                                              const LogitsAdjoint<T>& logits_adjoint) {
    const auto adjoint = [&](std::size_t term) { return static_cast<double>(terms_adjoint(term)); };
    Options weights = options;  // weights from the adjoints of each term and of the total
    weights.box = adjoint(0) + adjoint(3) * options.box;
    weights.objectness = adjoint(1) + adjoint(3) * options.objectness;
    weights.classification = adjoint(2) + adjoint(3) * options.classification;
    adjoint_of(weights, logits_adjoint);
  };
  const ArrayVariable<T, 1> values =
      record_array(Array<T, 1>{static_cast<T>(terms.box), static_cast<T>(terms.objectness),
                               static_cast<T>(terms.classification), static_cast<T>(terms.total)},
                   pullback, logits);
  return {element(values, {0}), element(values, {1}), element(values, {2}), element(values, {3})};
}

template <std::floating_point T>
YoloTrainingVariables<T> yolo_training_of(const std::vector<detect::Head>& heads, std::size_t input_height,
                                          std::size_t input_width,
                                          const std::vector<ArrayVariable<T, 4>>& logits,
                                          const Truths& truths, const YoloTrainingOptions& options) {
  const auto kept = std::make_shared<const KeptLogits<T>>(heads, input_height, input_width, logits);
  const auto adjoint_of = [=](const YoloTrainingOptions& weights, const LogitsAdjoint<T>& logits_adjoint) {
    yolo_training_adjoint(kept->heads(), kept->view(), truths, input_height, input_width, weights, T(1),
                          logits_adjoint);
  };
  return record_training_terms(
      yolo_training(kept->heads(), kept->view(), truths, input_height, input_width, options), options,
      adjoint_of, logits);
}
}  // namespace detail

template <std::floating_point T>
YoloTrainingTerms yolo_training(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                                const Truths& truths, std::size_t input_height, std::size_t input_width,
                                const YoloTrainingOptions& options) {
  detail::require_truths("yolo_training", heads, logits, truths, input_height, input_width,
                         detail::require_family);
  return detail::batch_terms(truths.size(), static_cast<double>(truths.size()), options, [&](std::size_t n) {
    return detail::image_terms(Predictions<T>{heads, logits, n, input_height, input_width}, truths[n],
                               options);
  });
}

template <std::floating_point T>
void yolo_training_adjoint(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                           const Truths& truths, std::size_t input_height, std::size_t input_width,
                           const YoloTrainingOptions& options, T total_adjoint,
                           const LogitsAdjoint<T>& logits_adjoint) {
  detail::require_truths("yolo_training_adjoint", heads, logits, truths, input_height, input_width,
                         detail::require_family);
  require_adjoint("yolo_training_adjoint", Predictions<T>{heads, logits, 0, input_height, input_width},
                  logits_adjoint);
  const double adjoint = static_cast<double>(total_adjoint) / static_cast<double>(truths.size());
  parallel_for(truths.size(), [&](std::size_t n) {
    detail::image_terms_adjoint(Predictions<T>{heads, logits, n, input_height, input_width}, truths[n],
                                options, adjoint, logits_adjoint);
  });
}
}  // namespace tapestry::loss
