#pragma once
#include <tapestry/detect/detector.hpp>
#include <tapestry/evaluate/average_precision.hpp>

#include "../../scenes/labelled_scene.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {

/// The detector's classes of objects in drawn scenes, in the order car, van, clutter; none for
/// one that it does not know.
using SceneClasses = std::array<std::optional<std::size_t>, 3>;

/// Quality of a detector on drawn scenes.
struct ScenePrecision {
  std::optional<double> ap50;  ///< AP at IoU ≥ 0.5, mean over the classes that occur and are known
  double false_alarms = 0;     ///< a picture: boxes of the car's class above the confidence, on no vehicle
};

/// Measures a detector on labelled scenes of its input's size. A van may be called a car by a detector that
/// knows no vans.
/// \param confidence  of a false alarm
inline ScenePrecision scene_precision(const detect::Detector<float>& network, double nms, double confidence,
                                      const SceneClasses& classes,
                                      const std::vector<scenes::LabelledScene>& drawn) {
  constexpr double least_confidence = 0.001;  // low, because precision counts weak detections, too
  const std::size_t size = network.input_width();
  const std::size_t car = classes[scenes::class_car].value();
  std::vector<evaluate::TruthBox> truths;
  std::vector<evaluate::ScoredBox> found;
  std::size_t alarms = 0;
  detect::Pass<float> pass;
  Array<float, 4> batch(Extents<4>{1, size, size, 3});
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    StopSignal::throw_if_arrived();
    scenes::put_into_batch(drawn[i].colours, 0, {}, batch);
    network.forward(batch, pass);
    detect::require_finite_logits(pass.logits, "test scene " + std::to_string(i));
    for (const auto& [class_index, box] : drawn[i].truths) {
      const bool is_unknown_van = class_index == scenes::class_van && !classes[class_index];
      if (classes[class_index] || is_unknown_van)
        truths.push_back({i, classes[class_index].value_or(car), box, box.w * box.h, false, is_unknown_van});
    }
    const auto is_on_vehicle = [&](const detect::Box& box) {
      return std::ranges::any_of(drawn[i].truths, [&](const auto& truth) {
        return truth.class_index != scenes::class_clutter && detect::iou(truth.box, box) >= 0.1;
      });
    };
    for (const auto& one : network.detections(pass.logits, 0, least_confidence, nms)) {
      if (std::ranges::find(classes, std::optional(one.class_index)) == classes.end()) continue;
      found.push_back({i, one.class_index, one.box, one.confidence});
      alarms += one.class_index == car && one.confidence > confidence && !is_on_vehicle(one.box) ? 1U : 0U;
    }
  }
  return {evaluate::average_precision(truths, found, network.heads().front().classes).mean.ap50,
          static_cast<double>(alarms) / static_cast<double>(drawn.size())};
}

}  // namespace tapestry::shell
