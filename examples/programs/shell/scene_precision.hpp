#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/evaluate/average_precision.hpp>
#include <vector>

#include "../../scenes/labelled_scene.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {

/// Labelled street scenes of size × size pixels; equal for equal random numbers.
inline std::vector<scenes::LabelledScene> draw_scenes(const Random& source, std::size_t count,
                                                      std::size_t size) {
  std::vector<scenes::LabelledScene> drawn(count);
  parallel_for(count, [&](std::size_t i) {
    StopSignal::throw_if_arrived();
    drawn[i] = scenes::draw_labelled(source.fork(i), {}, size);
  });
  return drawn;
}

/// AP at IoU ≥ 0.5 of a detector on labelled scenes of its input's size; mean over the classes that occur.
inline std::optional<double> scene_precision(const detect::Detector<float>& network, double nms,
                                             const std::vector<scenes::LabelledScene>& drawn) {
  constexpr double least_confidence = 0.001;  // low, because precision counts weak detections, too
  const std::size_t size = network.input_width();
  std::vector<evaluate::TruthBox> truths;
  std::vector<evaluate::ScoredBox> found;
  detect::Pass<float> pass;
  Array<float, 4> batch(Extents<4>{1, size, size, 3});
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    StopSignal::throw_if_arrived();
    scenes::put_into_batch(drawn[i], 0, {}, batch);
    network.forward(batch, pass);
    detect::require_finite_logits(pass.logits, "test scene " + std::to_string(i));
    for (const auto& truth : drawn[i].truths)
      truths.push_back({i, truth.class_index, truth.box, truth.box.w * truth.box.h});
    for (const auto& one :
         detect::suppress(detect::decode(network.heads(), pass.logits, 0, least_confidence, size, size), nms,
                          true, network.suppression_measure()))
      found.push_back({i, one.class_index, one.box, one.confidence});
  }
  return evaluate::average_precision(truths, found, network.heads().front().classes).mean.ap50;
}

}  // namespace tapestry::shell
