#pragma once
#include <tapestry/camouflage/view_store.hpp>
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>
#include <tapestry/image/transform/chain.hpp>

/// \file
/// The first header of evaluate/: the effect of a camouflage on a detector, and how certain it is.
///
///   found    a box of the car's class overlaps the car with IoU ≥ ½, above a threshold of confidence
///   P@0.5    share of the pictures in which the car is found
///   effect   best confidence under a control minus that under the camouflage, mean over the same views
///
///   views × textures --> Meter --> Measurement of each texture --> differences with intervals
///                        one picture                               paired_bootstrap
///
/// Noise alone hides cars from weak detectors, so each measurement includes controls, see controls.hpp.
///
/// Read next: meter.hpp, detection_rate.hpp, controls.hpp, paired_bootstrap.hpp.

namespace tapestry::evaluate {
/// Photographs of views: some of each view, each under conditions of its own.
struct Photography {
  image::Conditions conditions{};
  std::size_t draws = 1;  ///< photographs of each view
  std::uint64_t seed = 1;
};

/// Results of one texture over a set of views.
struct Measurement {
  std::string name;
  std::size_t draws = 1;                   ///< pictures of each view, one behind the other
  std::vector<bool> found{};               ///< one entry a picture: the car found at IoU ≥ ½
  std::vector<double> best_confidence{};   ///< one entry a picture, see best_confidence()
  std::vector<ViewOutcome> outcomes{};     ///< one entry a picture
  FateCounts fates{};                      ///< of the outcomes
  std::vector<std::string> class_names{};  ///< the detector's names, if it has some
  DetectionRate rate{};
  double mean_best_confidence = 0;     ///< over the pictures, 0 without any: shows more than a rate
  std::vector<DetectionRate> sweep{};  ///< the rate at each threshold of the meter's sweep
  std::vector<std::vector<BoxOnTarget>> ranked{};  ///< one entry a picture, see ViewResult
  PrecisionSummary precision{};                    ///< of them
};

/// One measured picture.
struct MeasuredPicture {
  const std::string& texture;      ///< the measurement's name
  const Array<float, 3>& picture;  ///< [H, W, 3]
  const camouflage::View<float>& view;
  const detect::Box& target;  ///< where the car is in the picture
  const ViewResult& result;
};

/// A picture of a view, and where the car is in it.
struct Photograph {
  Array<float, 3> picture;  ///< [H, W, 3]
  detect::Box target;
};

/// The picture of a view in a paint, or the untouched frame when `paint` is null; photographed if
/// `photography` is on: the same conditions for every paint, the same print of a paint in every view.
///
/// \param view_index, draw  which view and which photograph of it: another one is under other conditions
[[nodiscard]] Photograph photograph_of(const camouflage::View<float>& view, std::size_t view_index,
                                       const camouflage::Paint<float>* paint, const Photography& photography,
                                       std::size_t draw);

/// The texels of photographs of a paint, see camouflage::texels_of(): one array for each draw where each has
/// a print of its own, else one for all. They serve all views of a car.
/// \throws ShapeError as camouflage::printed()
[[nodiscard]] std::vector<Array<float, 2>> photographed_texels(const camouflage::View<float>& view,
                                                               const camouflage::Paint<float>& paint,
                                                               const Photography& photography);

/// photograph_of() from the photographed_texels() of this draw, or the untouched frame when `texels` is null.
[[nodiscard]] Photograph photograph_of_texels(const camouflage::View<float>& view, std::size_t view_index,
                                              const Array<float, 2>* texels, const Photography& photography,
                                              std::size_t draw);

namespace detail {
/// Mean of the numbers; 0 without any.
[[nodiscard]] inline double mean_of(const std::vector<double>& numbers) {
  return numbers.empty()
             ? 0
             : std::accumulate(numbers.begin(), numbers.end(), 0.0) / static_cast<double>(numbers.size());
}

/// Appends the result of a picture.
inline void add_result(const ViewResult& result, Measurement& measurement) {
  measurement.found.push_back(result.found);
  measurement.best_confidence.push_back(result.best_confidence);
  measurement.outcomes.push_back(result.outcome);
  measurement.ranked.push_back(result.ranked);
}

/// Computes rates and means of the results, without the sweep.
inline void summarise(Measurement& measurement) {
  measurement.rate = detection_rate(measurement.found, {measurement.draws});
  measurement.fates = fate_counts(measurement.outcomes);
  measurement.precision = target_precision(measurement.ranked);
  measurement.mean_best_confidence = mean_of(measurement.best_confidence);
}
}  // namespace detail

/// Measures one paint, or the untouched frames when `paint` is null, in some views: several pictures at once,
/// each on a thread of its own.
///
/// \param views        indices in the store
/// \param visit        called with each MeasuredPicture in order, to show or keep it; may throw to give up
/// \param photography  conditions of the photographs; if left out, the views are measured unchanged
/// \throws DomainError if no picture of each view is drawn
template <std::invocable<const MeasuredPicture&> Visit>
[[nodiscard]] Measurement measure(const std::string& name, Meter& meter, camouflage::ViewStore<float>& store,
                                  const std::vector<std::size_t>& views,
                                  const camouflage::Paint<float>* paint, Visit&& visit,
                                  const Photography& photography = {}) {
  if (photography.draws == 0) throw DomainError("measure: no photographs of a view");
  Measurement measurement{name, photography.draws};
  measurement.class_names = meter.detector().names();
  std::vector<double> found_confidence;
  const std::size_t draws = photography.draws;
  using ViewPointer = camouflage::ViewStore<float>::ViewPointer;
  std::vector<ViewPointer> shown(views.size());  // views whose pictures are being made
  const auto making = std::make_unique<std::mutex[]>(views.size());
  const auto view_of = [&](std::size_t place) {
    const std::lock_guard lock(making[place]);
    if (!shown[place]) shown[place] = store.view(views[place]);
    return shown[place];
  };
  const bool is_painted = paint != nullptr && !views.empty();
  const auto texels =
      is_painted ? photographed_texels(*view_of(0), *paint, photography) : std::vector<Array<float, 2>>{};
  struct Examined {
    ViewPointer view;
    Photograph photograph;
    ViewResult result;
  };
  const auto examine = [&](std::size_t i) {
    const std::size_t place = i / draws;
    Examined examined{view_of(place), {}, {}};
    const auto* const drawn = texels.empty() ? nullptr : &texels[texels.size() > 1 ? i % draws : 0];
    examined.photograph = photograph_of_texels(*examined.view, views[place], drawn, photography, i % draws);
    examined.result =
        meter.examine(examined.photograph.picture, examined.view->name, examined.photograph.target);
    return examined;
  };
  for_each_in_order(views.size() * draws, examine, [&](std::size_t i, const Examined& examined) {
    const auto& [view, photograph, result] = examined;
    detail::add_result(result, measurement);
    found_confidence.push_back(result.found_confidence);
    visit(MeasuredPicture{name, photograph.picture, *view, photograph.target, result});
    if ((i + 1) % draws == 0) shown[i / draws].reset();
  });
  detail::summarise(measurement);
  measurement.sweep = rates_above(meter.settings().sweep, found_confidence, {draws});
  return measurement;
}

/// Effect of a camouflage beyond a control: the control's figures minus the camouflage's, over the same
/// views. Intervals are over the views and, if a control has several draws, over its draws.
struct Effect {
  std::string control;                 ///< its name
  PairedDifference best_confidence{};  ///< of the means of best_confidence()
  PairedDifference p_at_50{};          ///< of the share of views with a found car
  std::size_t draws = 1;               ///< of the control, measured in the same views
  std::size_t draws_at_most = 0;       ///< draws with at most the camouflage's confidence
  PairedRatio odds_ratio{1, {0, std::numeric_limits<double>::infinity()}};  ///< see evaluate::odds_ratio()
};

namespace detail {
/// The mean of each view's pictures, so that a view counts once however often it was photographed.
template <class Value>
std::vector<double> means_of_views(const std::vector<Value>& of_pictures, std::size_t draws) {
  std::vector<double> means(of_pictures.size() / draws);
  for (std::size_t i = 0; i < of_pictures.size(); ++i)
    means[i / draws] += static_cast<double>(of_pictures[i]) / static_cast<double>(draws);
  return means;
}
}  // namespace detail

/// \param control, adversarial  measured in the same views, in the same order
/// \throws ShapeError if they do not have as many views; DomainError as paired_bootstrap()
[[nodiscard]] Effect effect_beyond(const Measurement& control, const Measurement& adversarial,
                                   const BootstrapSettings& settings = {});

/// The textures that a survey compares.
struct SurveyedTextures {
  camouflage::Paint<float> clean;                       ///< no paint, the car's own colours
  std::optional<camouflage::Paint<float>> adversarial;  ///< the camouflage, if there is one
  std::vector<Control> controls;
  /// The same views with the car in the camouflage's shape; the camouflage and its controls are measured on
  /// them. Below, the same for the other run. Null: the original shape. They must outlive the survey.
  camouflage::ViewStore<float>* reshaped = nullptr;
  camouflage::ViewStore<float>* reshaped_by_other = nullptr;

  /// Pictures of each view that a survey measures at each draw, the untouched frame among them.
  [[nodiscard]] std::size_t pictures_a_view() const { return 2 + (adversarial ? 1U : 0U) + controls.size(); }
};

/// Results of each texture over the same views.
struct Survey {
  Measurement photo;  ///< the untouched frames
  Measurement clean;
  std::optional<Measurement> adversarial;
  std::vector<Measurement> controls;
  AttackSuccess asr;             ///< share of the views found in `clean` that `adversarial` hides
  std::optional<Effect> effect;  ///< beyond matched noise, where that is among the controls
  std::optional<Effect> effect_beyond_other_run;  ///< if the other run is among the controls
};

/// Measures the untouched frames as "photo", the car in its own colours as "clean", the camouflage as
/// "adversarial", if there is one, and the controls by their names, in this order; parameters as measure().
/// If the camouflage moves the shape, too, its controls have that shape, so that an effect beyond them
/// belongs to the texture; photo and clean show the unchanged car.
template <std::invocable<const MeasuredPicture&> Visit>
[[nodiscard]] Survey survey(Meter& meter, camouflage::ViewStore<float>& store,
                            const std::vector<std::size_t>& views, const SurveyedTextures& textures,
                            Visit&& visit, const Photography& photography = {}) {
  const auto measured = [&](const std::string& name, const camouflage::Paint<float>* paint,
                            camouflage::ViewStore<float>* shape) {
    return measure(name, meter, shape != nullptr ? *shape : store, views, paint, visit, photography);
  };
  Survey survey;
  survey.photo = measured("photo", nullptr, nullptr);
  survey.clean = measured("clean", &textures.clean, nullptr);
  if (textures.adversarial) {
    survey.adversarial = measured("adversarial", &*textures.adversarial, textures.reshaped);
    survey.asr =
        attack_success_rate(survey.clean.found, survey.adversarial->found, {survey.adversarial->draws});
  }
  for (const auto& [name, paint, share_in_place] : textures.controls) {
    const bool is_other = name == other_run_name;
    survey.controls.push_back(
        measured(name, &paint, is_other ? textures.reshaped_by_other : textures.reshaped));
    if (!survey.adversarial) continue;
    if (name == matched_noise_name || is_other)
      (is_other ? survey.effect_beyond_other_run : survey.effect) =
          effect_beyond(survey.controls.back(), *survey.adversarial);
  }
  return survey;
}
}  // namespace tapestry::evaluate
