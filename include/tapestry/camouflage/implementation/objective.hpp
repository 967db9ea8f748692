#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/kept_layers.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/objective_terms.hpp>
#include <tapestry/camouflage/photo_session.hpp>
#include <tapestry/camouflage/profile.hpp>
#include <tapestry/camouflage/redrawn_view.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/heat_map_variable.hpp>
#include <tapestry/detect/pass_pool.hpp>
#include <tapestry/image/colour_space_variable.hpp>
#include <tapestry/image/over_variable.hpp>
#include <tapestry/image/transform/chain_variable.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <tapestry/loss/attention_variable.hpp>
#include <tapestry/loss/printability_variable.hpp>
#include <tapestry/loss/smoothness_variable.hpp>
#include <tapestry/raster/mip_pyramid_variable.hpp>
#include <tapestry/raster/texture_operator_variable.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

template <class T>
void Objective<T>::join(const detect::Detector<T>& detector, std::size_t class_index) {
  loss::require_raw_logits("objective", detector.heads());
  detect::require_class("objective", detector.heads(), class_index);
  const auto& first = members_.empty() ? detector : *members_.front().detector;
  if (detector.input_height() != first.input_height() || detector.input_width() != first.input_width())
    throw ShapeError("objective: the ensemble's detectors take pictures of different extents");
  members_.push_back({&detector, class_index});
}

template <class T>
void Objective<T>::print_by(std::shared_ptr<const Array<double, 2>> palette,
                            std::shared_ptr<const Array<T, 2>> used) {
  palette_ = std::move(palette);
  printed_texels_ = std::move(used);
}

template <class T>
void Objective<T>::keep_layers(std::size_t bytes, double least_share) {
  layer_bytes_ = bytes;
  least_share_kept_ = least_share;
}

template <class T>
Variable<T> Objective<T>::operator()(const ArrayVariable<T, 2>& parameter, Views views,
                                     const PhotoSession* session) {
  if (views.empty()) throw DomainError("objective: no views");
  if (session != nullptr && session->shots.size() != views.size())
    throw ShapeError("objective: a photo session of " + std::to_string(session->shots.size()) +
                     " shots for " + std::to_string(views.size()) + " views");
  const auto space = space_of(views);
  StageClock<T> clock(times_, parameter.is_active());
  const auto paint = method_colours(method_, parameter);
  const auto colours =
      session != nullptr && session->print ? printed(method_, paint, *session->print) : paint;
  clock.end_of(&StepTimes::update);
  const auto texels = raster::stored_texels(pyramid_of(views), image::in_space(space, colours));
  std::optional<ArrayVariable<T, 2>> steps;
  if (method_.shape) steps = shape_steps(*method_.shape, parameter);
  const Drawn drawn = steps ? redrawn_of(views, texels, *steps) : drawn_of(views, texels);
  clock.end_of(&StepTimes::render);
  const auto pictures = photographed(
      steps ? in_batch(drawn.pictures) : image::over(drawn.renders, backdrops_of(views), space), session);
  clock.end_of(&StepTimes::composite);
  const auto adversarial = adversarial_of(pictures, views, session, clock);
  const Variable<T> smoothness =
      used_texels_
          ? loss::atlas_smoothness(colours, used_texels_)
          : loss::smoothness(seen(space, drawn.renders), drawn.interiors) / static_cast<T>(views.size());
  Variable<T> total = adversarial.total + static_cast<T>(options_.smoothness * smoothness_unit) * smoothness;
  if (steps) total += static_cast<T>(method_.shape->stiffness) * shape_roughness(*method_.shape, *steps);
  Variable<T> printability = T(0);
  if (palette_) {
    printability = loss::non_printability(paint, printed_texels_, palette_);
    total += static_cast<T>(options_.printability) * printability;
  }
  clock.end_of(&StepTimes::losses);
  const auto number = [](const Variable<T>& term) { return static_cast<double>(term.value()); };
  terms_ = {number(adversarial.iou),
            number(adversarial.objectness),
            number(adversarial.classification),
            number(adversarial.max_score),
            number(smoothness),
            number(printability),
            number(total)};
  return total;
}

template <class T>
image::ColourSpace Objective<T>::space_of(Views views) {
  for (const auto& view : views)
    if (view->space != views[0]->space) throw DomainError("objective: views in different colour spaces");
  return views[0]->space;
}

template <class T>
std::shared_ptr<const raster::MipPyramid> Objective<T>::pyramid_of(Views views) {
  for (const auto& view : views)
    if (view->pyramid != views[0]->pyramid) throw DomainError("objective: views of different pyramids");
  return views[0]->pyramid;
}

template <class T>
typename Objective<T>::Drawn Objective<T>::drawn_of(Views views, const ArrayVariable<T, 2>& texels) {
  const auto operators = parts_of(views, [](const View<T>& view) { return &view.paint_to_picture; });
  return {raster::render(operators, texels), interiors_of(views)};
}

template <class T>
typename Objective<T>::Drawn Objective<T>::redrawn_of(Views views, const ArrayVariable<T, 2>& texels,
                                                      const ArrayVariable<T, 2>& steps) const {
  const auto positions = shape_positions(*method_.shape, steps);
  Drawn drawn;
  for (const auto& view : views) {
    auto anew = redrawn(*view, *method_.shape, texels, positions);
    drawn.renders.push_back(std::move(anew.render));
    drawn.interiors.push_back(std::move(anew.interior));
    drawn.pictures.push_back(std::move(anew.picture));
  }
  return drawn;
}

template <class T>
ArrayVariable<T, 4> Objective<T>::in_batch(const std::vector<ArrayVariable<T, 3>>& pictures) {
  std::vector<ArrayVariable<T, 4>> batch;
  for (const auto& picture : pictures) {
    const auto& [height, width, channels] = picture.shape();
    batch.push_back(reshape(picture, Extents<4>{1, height, width, channels}));
  }
  return concatenate(std::span<const ArrayVariable<T, 4>>(batch), 0);
}

template <class T>
std::vector<image::Backdrop<T>> Objective<T>::backdrops_of(Views views) {
  std::vector<image::Backdrop<T>> backdrops;
  for (const auto& view : views)
    backdrops.push_back({{view, &view->background},
                         {view, &view->paint_to_picture.coverage},
                         view->window.top,
                         view->window.left});
  return backdrops;
}

template <class T>
ArrayVariable<T, 4> Objective<T>::photographed(ArrayVariable<T, 4> pictures, const PhotoSession* session) {
  if (session == nullptr) return pictures;
  std::vector<image::TransformationChain> chains;
  for (const Shot& shot : session->shots) chains.push_back(shot.chain);
  return image::transformed(pictures, chains);
}

template <class T>
std::vector<loss::Target> Objective<T>::targets_of(Views views, const PhotoSession* session,
                                                   std::size_t class_index) {
  std::vector<loss::Target> targets;
  for (std::size_t i = 0; i < views.size(); ++i)
    targets.push_back({class_index, session == nullptr ? views[i]->target : session->shots[i].target});
  return targets;
}

template class Objective<float>;
template class Objective<double>;

}  // namespace tapestry::camouflage
