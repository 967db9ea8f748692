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
#include <vector>

namespace tapestry::evaluate {

/// What a survey compares.
template <class T>
struct SurveyedTextures {
  camouflage::Paint<T> clean;                       ///< no paint, the car's own colours
  std::optional<camouflage::Paint<T>> adversarial;  ///< the camouflage, if there is one
  std::vector<Control<T>> controls;
  /// The same views of the car in the shape that the camouflage has given it, in which it and its controls
  /// are measured; and in that of the other run. Null: the car as it is. They must outlive the survey.
  camouflage::ViewStore<T>* reshaped = nullptr;
  camouflage::ViewStore<T>* reshaped_by_other = nullptr;

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
/// Where the camouflage moves the shape, too, its controls have that shape, so that an effect beyond them is
/// the texture's; photo and clean are of the car as it is.
template <class T, std::invocable<const MeasuredPicture<T>&> Visit>
[[nodiscard]] Survey survey(Meter<T>& meter, camouflage::ViewStore<T>& store,
                            const std::vector<std::size_t>& views, const SurveyedTextures<T>& textures,
                            Visit&& visit, const Photography& photography = {}) {
  const auto measured = [&](const std::string& name, const camouflage::Paint<T>* paint,
                            camouflage::ViewStore<T>* shape = nullptr) {
    return measure(name, meter, shape != nullptr ? *shape : store, views, paint, visit, photography);
  };
  Survey survey;
  survey.photo = measured("photo", nullptr);
  survey.clean = measured("clean", &textures.clean);
  if (textures.adversarial) {
    survey.adversarial = measured("adversarial", &*textures.adversarial, textures.reshaped);
    survey.asr = attack_success_rate(survey.clean.found, survey.adversarial->found, photography.draws);
  }
  for (const Control<T>& control : textures.controls) {
    survey.controls.push_back(
        measured(control.name, &control.paint,
                 control.name == other_run_name ? textures.reshaped_by_other : textures.reshaped));
    if (!survey.adversarial) continue;
    if (control.name == matched_noise_name)
      survey.effect = effect_beyond(survey.controls.back(), *survey.adversarial);
    if (control.name == other_run_name)
      survey.effect_beyond_other_run = effect_beyond(survey.controls.back(), *survey.adversarial);
  }
  return survey;
}

}  // namespace tapestry::evaluate
