#pragma once
#include <iterator>
#include <tapestry/camouflage/detail/drawn_views.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/heat_map.hpp>
#include <tapestry/loss/attention.hpp>
#include <tapestry/loss/printability.hpp>
#include <tapestry/loss/smoothness.hpp>

namespace tapestry::camouflage {
template <std::floating_point T>
std::vector<detect::KeptPicture<T>*> KeptLayers<T>::of(const detect::Detector<T>& detector, Views views,
                                                       double least_share) {
  std::vector<detect::KeptPicture<T>*> pictures;
  for (const auto& view : views) {
    const std::lock_guard lock(*mutex_);
    const auto [found, is_new] = views_.try_emplace(view->name);
    Kept& kept = found->second;
    if (is_new) kept.share = detector.share_kept(view->window);
    if (is_new && !is_full_ && kept.share >= least_share) kept.picture.emplace(view->window);
    pictures.push_back(kept.picture && kept.picture->window() == view->window ? &*kept.picture : nullptr);
  }
  if (std::ranges::count(pictures, nullptr) == std::ssize(pictures)) pictures.clear();
  return pictures;
}

template <std::floating_point T>
void KeptLayers<T>::limit_to(std::size_t bytes, Views views) {
  const std::lock_guard lock(*mutex_);
  for (const auto& view : views) {
    Kept& kept = views_[view->name];
    kept.bytes = kept.picture ? kept.picture->bytes() : 0;
  }
  if (this->bytes() <= bytes) return;
  for (const auto& view : views) views_[view->name] = {};
  is_full_ = true;
}

template <std::floating_point T>
std::size_t KeptLayers<T>::bytes() const {
  std::size_t sum = 0;
  for (const auto& [name, kept] : views_) sum += kept.bytes;
  return sum;
}

template <std::floating_point T>
std::size_t KeptLayers<T>::kept_count() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(views_, [](const auto& entry) { return entry.second.picture.has_value(); }));
}

template <std::floating_point T>
double KeptLayers<T>::share() const {
  double sum = 0;
  for (const auto& [name, kept] : views_) sum += kept.picture ? kept.share : 0;
  return views_.empty() ? 0 : sum / static_cast<double>(views_.size());
}

template <std::floating_point T>
void Ensemble<T>::join(const detect::Detector<T>& detector, std::size_t class_index) {
  loss::require_raw_logits("objective", detector.heads());
  detect::require_class("objective", detector.heads(), class_index);
  const auto& first = members_.empty() ? detector : *members_.front().detector;
  if (detector.input_height() != first.input_height() || detector.input_width() != first.input_width())
    throw ShapeError("objective: the ensemble's detectors take pictures of different extents");
  members_.push_back({&detector, class_index});
}

template <std::floating_point T>
std::size_t Ensemble<T>::weight_count() const {
  std::size_t sum = 0;
  for (const Member& member : members_) sum += member.detector->network().weights().size();
  return sum;
}

template <std::floating_point T>
void Ensemble<T>::keep_layers(std::size_t bytes, double least_share) {
  layer_bytes_ = bytes;
  least_share_kept_ = least_share;
}

template <std::floating_point T>
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

template <std::floating_point T>
auto Ensemble<T>::explained(Member& member, const ShownPictures<T>& shown, double weight) -> Explained {
  auto explained =
      detect::explained_forward(*member.detector, shown.pictures, member.class_index, member.passes.take());
  Variable<T> sum = T(0);
  for (const auto& heat : explained.heat) sum += loss::attention(heat);
  return {std::move(explained.logits),
          static_cast<T>(weight / static_cast<double>(explained.heat.size())) * sum};
}

template <std::floating_point T>
auto Ensemble<T>::logits_of(Member& member, const ShownPictures<T>& shown) -> Logits {
  std::vector<detect::KeptPicture<T>*> kept;
  if (layer_bytes_ > 0 && shown.session == nullptr && !shown.is_redrawn)
    kept = member.kept.of(*member.detector, shown.views, least_share_kept_);
  if (kept.empty()) return detect::forward(*member.detector, shown.pictures, member.passes.take());
  auto logits = detect::forward_within(*member.detector, shown.pictures, kept, member.passes.take());
  member.kept.limit_to(layer_bytes_ / members_.size(), shown.views);
  return logits;
}

template <std::floating_point T>
std::pair<DrawnPaint<T>, Evaluated<T>> Objective<T>::paint_of(const ArrayVariable<T, 2>& parameter,
                                                              Views views, const PhotoSession* session) {
  StageClock<T> clock(times_, parameter.is_active());
  const auto own = method_colours(method_, parameter);
  const auto colours = session && session->print ? printed(method_, own, *session->print) : own;
  DrawnPaint<T> paint{drawn_texels(views, colours)};
  clock.end_of(&StepTimes::update);
  Evaluated<T> found{T(0), {}};
  if (used_texels_)
    found.add(&ObjectiveTerms::smoothness, loss::atlas_smoothness(colours, used_texels_),
              options_.smoothness * smoothness_unit);
  if (method_.shape) {
    const auto steps = shape_steps(*method_.shape, parameter);
    paint.positions = shape_positions(*method_.shape, steps);
    found.add(nullptr, shape_roughness(*method_.shape, steps), method_.shape->stiffness);
  }
  if (palette_)
    found.add(&ObjectiveTerms::printability, loss::non_printability(own, printed_texels_, palette_),
              options_.printability);
  clock.end_of(&StepTimes::losses);
  return {std::move(paint), std::move(found)};
}

template <std::floating_point T>
Evaluated<T> Objective<T>::evaluate(const DrawnPaint<T>& paint, Views views, const PhotoSession* session) {
  if (session != nullptr && session->shots.size() != views.size())
    throw ShapeError(
        {"objective: a photo session of ", session->shots.size(), " shots for ", views.size(), " views"});
  StageClock<T> clock(times_, paint.texels.is_active() || paint.positions.is_active());
  const auto drawn = drawn_views(views, paint, method_.shape.get());
  clock.end_of(&StepTimes::render);
  const auto laid = laid_over(views, drawn);
  clock.end_of(&StepTimes::composite);
  // Recorded before the detectors, so that the sweep adds it to their sum: a detector that
  // joins twice has the same bits.
  Variable<T> smoothness = T(0);
  if (!used_texels_) smoothness = smoothness_of(views, drawn, laid);
  clock.end_of(&StepTimes::losses);
  const auto pictures = photographed(laid, session);
  clock.end_of(&StepTimes::composite);
  const auto adversarial =
      ensemble_({pictures, views, session, method_.shape != nullptr}, options_, method_.attention, clock);
  Evaluated<T> found{adversarial.total, numbers_of(adversarial)};
  if (!used_texels_)
    found.add(&ObjectiveTerms::smoothness, smoothness, options_.smoothness * smoothness_unit);
  clock.end_of(&StepTimes::losses);
  return found;
}

template <std::floating_point T>
Variable<T> Objective<T>::operator()(const ArrayVariable<T, 2>& parameter, Views views,
                                     const PhotoSession* session) {
  const auto [paint, of_paint] = paint_of(parameter, views, session);
  const auto [loss, terms] = evaluate(paint, views, session);
  terms_ = terms;
  terms_.add(of_paint.terms);
  return loss + of_paint.loss;
}
}  // namespace tapestry::camouflage
