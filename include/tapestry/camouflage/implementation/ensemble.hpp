#pragma once
#include <cstddef>
#include <optional>
#include <tapestry/camouflage/ensemble.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/heat_map_variable.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <tapestry/loss/attention_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

template <class T>
void Ensemble<T>::join(const detect::Detector<T>& detector, std::size_t class_index) {
  loss::require_raw_logits("objective", detector.heads());
  detect::require_class("objective", detector.heads(), class_index);
  const auto& first = members_.empty() ? detector : *members_.front().detector;
  if (detector.input_height() != first.input_height() || detector.input_width() != first.input_width())
    throw ShapeError("objective: the ensemble's detectors take pictures of different extents");
  members_.push_back({&detector, class_index});
}

template <class T>
void Ensemble<T>::keep_layers(std::size_t bytes, double least_share) {
  layer_bytes_ = bytes;
  least_share_kept_ = least_share;
}

template <class T>
loss::AdversarialTerms<Variable<T>> Ensemble<T>::operator()(const ShownPictures<T>& shown,
                                                            const ObjectiveOptions& options, double attention,
                                                            StageClock<T>& clock) {
  std::vector<loss::AdversarialTerms<Variable<T>>> of_members;
  for (Member& member : members_) {
    std::optional<Explained> explanation;
    if (attention > 0) explanation = explained(member, shown, attention);
    const Logits logits = explanation ? std::move(explanation->logits) : logits_of(member, shown);
    clock.end_of(&StepTimes::detector_forward, &StepTimes::detector_backward);
    of_members.push_back(loss::adversarial(*member.detector, logits,
                                           targets_of(shown.views, shown.session, member.class_index),
                                           options.kind, options.weights));
    if (explanation) of_members.back().total = explanation->attention;
    clock.end_of(&StepTimes::losses);
  }
  return loss::mean_of(of_members);
}

template <class T>
auto Ensemble<T>::explained(Member& member, const ShownPictures<T>& shown, double weight) -> Explained {
  auto explained =
      detect::explained_forward(*member.detector, shown.pictures, member.class_index, member.passes.take());
  Variable<T> sum = T(0);
  for (const auto& heat : explained.heat) sum += loss::attention(heat);
  return {std::move(explained.logits),
          static_cast<T>(weight / static_cast<double>(explained.heat.size())) * sum};
}

template <class T>
auto Ensemble<T>::logits_of(Member& member, const ShownPictures<T>& shown) -> Logits {
  std::vector<detect::KeptPicture<T>*> kept;
  if (layer_bytes_ > 0 && shown.session == nullptr && !shown.is_redrawn)
    kept = member.kept.of(*member.detector, shown.views, least_share_kept_);
  if (kept.empty()) return detect::forward(*member.detector, shown.pictures, member.passes.take());
  auto logits = detect::forward_within(*member.detector, shown.pictures, kept, member.passes.take());
  member.kept.limit_to(layer_bytes_ / members_.size(), shown.views);
  return logits;
}

template class Ensemble<float>;
template class Ensemble<double>;

}  // namespace tapestry::camouflage
