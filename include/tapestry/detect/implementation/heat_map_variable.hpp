#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/best_candidate.hpp>
#include <tapestry/detect/heat_map.hpp>
#include <tapestry/detect/heat_map_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

/// What the score of an image's surest candidate asks of the first told layer, without what is negative,
/// [C, H, W]; zeros if there is no candidate.
template <class T>
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
  auto asked = detector.layer_adjoint(pass, pointers, 0, image);
  for (T& value : asked.storage()) value = std::max(value, T(0));
  return asked;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

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

template decltype(explained_forward<float>) explained_forward<float>;
template decltype(explained_forward<double>) explained_forward<double>;

}  // namespace tapestry::detect
