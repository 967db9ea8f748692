#pragma once

#include "survey_watch.hpp"
#include "wild_boxes.hpp"

namespace tapestry::shell {

struct CleanViews {
  std::size_t views = 0, found = 0;  ///< pictures; those with a found car
  /// Pictures where it finds another class there, by its name.
  std::map<std::string, std::size_t> others{};
  WildBoxes boxes{};
};

/// Runs the detector on clean views: at most eight of the measured ones, evenly spread.
/// \throws Error (mismatch) if none of them shows the car, and as views_with_car()
inline CleanViews examine_clean_views(const Inputs& inputs, const SceneSettings& scene,
                                      const DetectorSettings& settings) {
  const auto& detector = inputs.detector;
  camouflage::ViewStore<float> store(
      inputs.car.painted, store_settings(inputs, scene, settings, 1024),
      frame_loaders(thinned(inputs.frames.test, 8), inputs.mask, inputs.frames.posed));
  std::vector<std::string> warnings;  // a run repeats them
  const auto usable = views_with_car(store, scene.mesh, inputs.car, warnings);
  if (usable.empty()) throw no_car_shown(scene.frames, inputs.car);
  evaluate::Meter meter(detector, inputs.class_index, {settings.confidence, settings.nms});
  const auto clean = camouflage::without_paint(camouflage::own_colours<float>(inputs.car.painted));
  CleanViews seen{usable.size()};
  static_cast<void>(evaluate::measure("clean", meter, store, usable, &clean, [&](const auto& measured) {
    using evaluate::Fate;
    const auto& outcome = measured.result.outcome;
    if (outcome.fate == Fate::found) ++seen.found;
    if (outcome.fate == Fate::related || outcome.fate == Fate::renamed)
      ++seen.others[class_name(outcome.class_index, detector.names(), "class ")];
    seen.boxes.add(measured.result.detections, detector.input_height(), detector.input_width());
  }));
  return seen;
}

/// Prints the number of clean views with a found car, and other classes found there.
/// \throws Error (mismatch) if in none, or if most boxes are wild
inline void require_car_found(const Inputs& inputs, const SceneSettings& scene,
                              const DetectorSettings& settings, std::vector<std::string>& warnings) {
  const CleanViews seen = examine_clean_views(inputs, scene, settings);
  const std::string name = in_quotes(class_name(inputs.class_index, inputs.detector.names()));
  std::string others;
  std::size_t renamed = 0;
  for (const auto& [other, count] : seen.others) {
    others += ", as " + in_quotes(other) + " in " + std::to_string(count);
    renamed += count;
  }
  const std::string views = std::to_string(seen.views) + " clean views";
  if (const std::string wild = seen.boxes.word(); !wild.empty())
    throw Error(ErrorKind::mismatch, {settings.weights, ": of ", views, ", ", wild});
  if (seen.found == 0)
    throw Error(
        ErrorKind::mismatch,
        {settings.weights, ": the car is found as ", name, " in none of ", views, others,
         others.empty() ? ", and as nothing else; see --detector, --fit and --confidence" : "; see --class"});
  if (renamed > seen.found || 2 * seen.found < seen.views)
    warnings.push_back("the car is found as " + name + " in " + std::to_string(seen.found) + " of " + views +
                       " only" + others + ": are --class, --detector and --confidence right?");
  else
    remark("the car is found as " + name + " in " + std::to_string(seen.found) + " of " + views + others);
}

}  // namespace tapestry::shell
