#pragma once
#include <tapestry/detect/class_score.hpp>
#include <tapestry/detect/heat_map.hpp>

namespace tapestry::detect {
namespace detail {
/// max(0, Σ_c weight_c · A_c), [H, W].
template <std::floating_point T, class Weight>
Array<T, 2> weighted_map(const Array<T, 3>& values, Weight weight) {
  const std::size_t pixels = values.shape(1) * values.shape(2);
  auto map = zeros<T, 2>({values.shape(1), values.shape(2)});
  for (std::size_t c = 0; c < values.shape(0); ++c)
    for (std::size_t i = 0; i < pixels; ++i) map.data()[i] += weight(c, i) * values.data()[c * pixels + i];
  for (T& value : map.storage()) value = std::max(value, T(0));
  return map;
}

/// Positive part of the gradient of the surest candidate's score of an image in the first observed layer, [C,
/// H, W]; zeros if there is no candidate.
template <std::floating_point T>
[[nodiscard]] Array<T, 3> positive_layer_adjoint(const Detector<T>& detector, Pass<T>& pass,
                                                 std::size_t class_index, std::size_t image) {
  std::vector<const Array<T, 4>*> logits;
  for (const auto& head : pass.logits) logits.push_back(&head);
  const auto best = best_candidate(detector.heads(), logits, image, {class_index}, detector.input_height(),
                                   detector.input_width());
  if (!best) return zeros<T, 3>(detector.layer_values(pass, 0, image).shape());
  const auto adjoints = score_adjoint(detector.heads(), pass.logits, image, class_index, *best);
  std::vector<const Array<T, 4>*> pointers;
  for (const auto& head : adjoints) pointers.push_back(&head);
  auto heat = detector.layer_adjoint(pass, pointers, 0, image);
  for (T& value : heat.storage()) value = std::max(value, T(0));
  return heat;
}
}  // namespace detail

template <std::floating_point T>
std::optional<BestCandidate> best_candidate(const std::vector<Head>& heads,
                                            const std::vector<const Array<T, 4>*>& logits, std::size_t image,
                                            const CandidateSearch& search, std::size_t height,
                                            std::size_t width) {
  require_class("best_candidate", heads, search.class_index);
  if (logits.size() != heads.size())
    throw ShapeError({"best_candidate: logits of ", logits.size(), " heads, expected ", heads.size()});
  std::optional<BestCandidate> best;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const Head& head = heads[h];
    require_layout("best_candidate", head);
    require_shape("best_candidate", "logits", *logits[h],
                  {logits[h]->shape(0), head.channel_count(), head.grid_height, head.grid_width});
    if (image >= logits[h]->shape(0))
      throw DomainError({"best_candidate: image ", image, " of a batch of ", logits[h]->shape(0)});
    const auto objectness_channel = head.objectness_channel();
    const std::size_t cells = head.grid_height * head.grid_width;
    const T* const of_image = logits[h]->data() + image * head.channel_count() * cells;
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const T* const first = of_image + anchor * head.candidate_channel_count() * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double least = best ? best->confidence : 0;
      const double objectness = objectness_channel ? probability(head, logit(*objectness_channel)) : 1.0;
      if (!(objectness > least)) continue;  // the other factor is at most 1
      const double confidence = objectness * ClassScores(head, logit)(search.class_index);
      if (!(confidence > least)) continue;
      const CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width,
                                 static_cast<double>(width), static_cast<double>(height)};
      if (!search.target || iou(decode_box(head, place, logit), *search.target) >= search.iou_threshold)
        best = {h, candidate, confidence};
    }
  }
  return best;
}

template <std::floating_point T>
Array<T, 2> grad_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("grad_cam", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  std::vector<T> means(values.shape(0), T(0));
  for (std::size_t c = 0; c < means.size(); ++c) {
    for (std::size_t i = 0; i < pixels; ++i) means[c] += adjoint.data()[c * pixels + i];
    means[c] /= static_cast<T>(pixels);
  }
  return detail::weighted_map(values, [&](std::size_t c, std::size_t) { return means[c]; });
}

template <std::floating_point T>
Array<T, 2> grad_cam_plus_plus(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("grad_cam_plus_plus", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  std::vector<T> weights(values.shape(0), T(0));
  for (std::size_t c = 0; c < weights.size(); ++c) {
    const T *const a = values.data() + c * pixels, *const g = adjoint.data() + c * pixels;
    T sum = 0;
    for (std::size_t i = 0; i < pixels; ++i) sum += a[i];
    for (std::size_t i = 0; i < pixels; ++i) {
      const T denominator = 2 + sum * g[i];  // g² has been divided out
      if (g[i] > 0 && denominator != 0) weights[c] += g[i] / denominator;
    }
  }
  return detail::weighted_map(values, [&](std::size_t c, std::size_t) { return weights[c]; });
}

template <std::floating_point T>
Array<T, 2> layer_cam(const Array<T, 3>& values, const Array<T, 3>& adjoint) {
  require_shape("layer_cam", "adjoint", adjoint, values.shape());
  const std::size_t pixels = values.shape(1) * values.shape(2);
  return detail::weighted_map(
      values, [&](std::size_t c, std::size_t i) { return std::max(adjoint.data()[c * pixels + i], T(0)); });
}

template <std::floating_point T>
std::optional<double> share_within(const Array<T, 2>& heat, const Array<T, 2>& mask) {
  require_shape("share_within", "mask", mask, heat.shape());
  double within = 0, whole = 0;
  for (std::size_t i = 0; i < heat.size(); ++i) {
    within += static_cast<double>(heat.data()[i]) * static_cast<double>(mask.data()[i]);
    whole += static_cast<double>(heat.data()[i]);
  }
  if (!(whole > 0)) return std::nullopt;
  return std::min(within / whole, 1.0);
}

template <std::floating_point T>
std::vector<Array<T, 4>> score_adjoint(const std::vector<Head>& heads, const std::vector<Array<T, 4>>& logits,
                                       std::size_t image, std::size_t class_index,
                                       const BestCandidate& best) {
  std::vector<Array<T, 4>> adjoints;
  for (const auto& of_head : logits) adjoints.push_back(zeros<T, 4>(of_head.shape()));
  const Head& head = heads.at(best.head);
  const std::size_t cells = head.grid_height * head.grid_width;
  const std::size_t anchor = best.candidate / cells, cell = best.candidate % cells;
  T* const first = adjoints.at(best.head).data() + image * head.channel_count() * cells +
                   anchor * head.candidate_channel_count() * cells + cell;
  first[head.class_channel(class_index) * cells] = 1;
  if (const auto objectness = head.objectness_channel()) first[*objectness * cells] = 1;
  return adjoints;
}

template <std::floating_point T>
ExplainedLogits<T> explained_forward(const Detector<T>& detector, const ArrayVariable<T, 4>& images,
                                     std::size_t class_index, std::shared_ptr<Pass<T>> pass) {
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward(images.value(), *pass, Mode::input_gradient);
  ExplainedLogits<T> explained{detail::record_logits(detector, pass, images), {}};
  for (std::size_t image = 0; image < pass->images; ++image) {
    const auto weights = std::make_shared<const Array<T, 3>>(
        detail::positive_layer_adjoint(detector, *pass, class_index, image));
    auto heat = layer_cam(detector.layer_values(*pass, 0, image), *weights);
    const auto pullback = [&detector, pass, weights, image, kept = heat](const Array<T, 2>& heat_adjoint,
                                                                         Array<T, 4>* images_adjoint) {
      Array<T, 3> layer_adjoint = *weights;
      for (std::size_t i = 0; i < layer_adjoint.size(); ++i) {
        const std::size_t place = i % kept.size();
        layer_adjoint.data()[i] *= kept.data()[place] > T(0) ? heat_adjoint.data()[place] : T(0);
      }
      detector.pull_back_layer(*pass, 0, image, layer_adjoint, *images_adjoint);
    };
    explained.heat.push_back(record_array(std::move(heat), pullback, images));
  }
  return explained;
}
}  // namespace tapestry::detect
