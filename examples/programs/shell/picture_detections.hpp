#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/finite_logits.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

#include "detector_inputs.hpp"
#include "settings.hpp"

namespace tapestry::shell {

/// What a detector finds in a picture, most confident first; boxes in pixels of the picture.
/// \param name  of the picture, for messages
/// \throws NumericError for logits that are not finite
inline std::vector<detect::Detection> detections_in(const std::string& name,
                                                    const Array<std::uint8_t, 3>& picture,
                                                    const DetectorSettings& settings,
                                                    const Detector& detector, detect::Pass<float>& pass) {
  const auto& network = *detector.network;
  const std::size_t height = network.input_height();
  const std::size_t width = network.input_width();
  const auto input = image::fitted(image::from_bytes<float>(picture), height, width, detector.fit);
  network.forward(image::batch_of(input), pass);
  detect::require_finite_logits(pass.logits, name);
  auto detections =
      detect::suppress(detect::decode(network.heads(), pass.logits, 0, settings.confidence, height, width),
                       settings.nms, true, network.suppression_measure());
  const auto back =
      image::picture_from_canvas(picture.shape(0), picture.shape(1), height, width, detector.fit.kind);
  for (auto& detection : detections) {
    auto& box = detection.box;
    box = {back.x(box.cx), back.y(box.cy), back.width(box.w), back.height(box.h)};
  }
  return detections;
}

/// The name of a class, or its number where there is none.
inline std::string class_name(std::size_t class_index, const std::vector<std::string>& names) {
  return class_index < names.size() ? names[class_index] : std::to_string(class_index);
}

}  // namespace tapestry::shell
