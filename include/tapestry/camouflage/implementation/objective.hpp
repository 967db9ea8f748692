#pragma once
#include <memory>
#include <optional>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/drawn_views.hpp>
#include <tapestry/camouflage/objective.hpp>
#include <tapestry/camouflage/photo_session_variable.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/loss/printability_variable.hpp>
#include <tapestry/loss/smoothness_variable.hpp>

namespace tapestry::camouflage {

template <class T>
Variable<T> Objective<T>::operator()(const ArrayVariable<T, 2>& parameter, Views views,
                                     const PhotoSession* session) {
  require_shots(session, views.size());
  StageClock<T> clock(times_, parameter.is_active());
  const auto paint = method_colours(method_, parameter);
  const auto colours = session && session->print ? printed(method_, paint, *session->print) : paint;
  clock.end_of(&StepTimes::update);
  std::optional<ArrayVariable<T, 2>> steps;
  if (method_.shape) steps = shape_steps(*method_.shape, parameter);
  const auto drawn =
      steps ? drawn_views(views, colours, *method_.shape, *steps) : drawn_views(views, colours);
  clock.end_of(&StepTimes::render);
  const auto pictures = photographed(laid_over(views, drawn), session);
  clock.end_of(&StepTimes::composite);
  const auto adversarial =
      ensemble_({pictures, views, session, steps.has_value()}, options_, method_.attention, clock);
  const auto smoothness =
      used_texels_ ? loss::atlas_smoothness(colours, used_texels_) : smoothness_of(views, drawn);
  Variable<T> total = adversarial.total + static_cast<T>(options_.smoothness * smoothness_unit) * smoothness;
  if (steps) total += static_cast<T>(method_.shape->stiffness) * shape_roughness(*method_.shape, *steps);
  Variable<T> printability = T(0);
  if (palette_) printability = loss::non_printability(paint, printed_texels_, palette_);
  if (palette_) total += static_cast<T>(options_.printability) * printability;
  clock.end_of(&StepTimes::losses);
  terms_ = numbers_of(adversarial, smoothness, printability, total);
  return total;
}

template class Objective<float>;
template class Objective<double>;

}  // namespace tapestry::camouflage
