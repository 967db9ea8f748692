#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/effect.hpp>
#include <tapestry/evaluate/measurement.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

/// What a survey compares.
template <class T>
struct SurveyedTextures {
  camouflage::Paint<T> clean;                       ///< no paint, the car's own colours
  std::optional<camouflage::Paint<T>> adversarial;  ///< the camouflage, if there is one
  std::vector<Control<T>> controls;

  /// Pictures of each view that a survey measures at each draw, the untouched frame among them.
  [[nodiscard]] std::size_t pictures_a_view() const { return 2 + (adversarial ? 1U : 0U) + controls.size(); }
};

/// How the same views fare with each texture.
struct Survey {
  Measurement photo;  ///< the untouched frames
  Measurement clean;
  std::optional<Measurement> adversarial;
  std::vector<Measurement> controls;
  AttackSuccess asr;             ///< of the views found in `clean`, those not found in `adversarial`
  std::optional<Effect> effect;  ///< beyond matched noise, where that is among the controls
  std::optional<Effect> effect_beyond_other_run;  ///< where that is among the controls
};

/// Measures the untouched frames as "photo", the car in its own colours as "clean", the camouflage as
/// "adversarial", if there is one, and the controls by their names, in this order; parameters as measure().
template <class T, std::invocable<const MeasuredPicture<T>&> Visit>
[[nodiscard]] Survey survey(Meter<T>& meter, camouflage::ViewStore<T>& store,
                            const std::vector<std::size_t>& views, const SurveyedTextures<T>& textures,
                            Visit&& visit, const Photography& photography = {}) {
  const auto measured = [&](const std::string& name, const camouflage::Paint<T>* paint) {
    return measure(name, meter, store, views, paint, visit, photography);
  };
  Survey survey;
  survey.photo = measured("photo", nullptr);
  survey.clean = measured("clean", &textures.clean);
  if (textures.adversarial) {
    survey.adversarial = measured("adversarial", &*textures.adversarial);
    survey.asr = attack_success_rate(survey.clean.found, survey.adversarial->found, photography.draws);
  }
  for (const Control<T>& control : textures.controls) {
    survey.controls.push_back(measured(control.name, &control.paint));
    if (!survey.adversarial) continue;
    if (control.name == matched_noise_name)
      survey.effect = effect_beyond(survey.controls.back(), *survey.adversarial);
    if (control.name == other_run_name)
      survey.effect_beyond_other_run = effect_beyond(survey.controls.back(), *survey.adversarial);
  }
  return survey;
}

}  // namespace tapestry::evaluate
