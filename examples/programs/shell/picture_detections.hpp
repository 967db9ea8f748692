#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/image/colour_space.hpp>
#include <vector>

#include "detector_inputs.hpp"
#include "settings.hpp"

namespace tapestry::shell {

/// Detections in a picture, most confident first; boxes in pixels of the picture.
/// \param name  of the picture, for messages
/// \throws NumericError for logits that are not finite
inline std::vector<detect::Detection> detections_in(const std::string& name,
                                                    const Array<std::uint8_t, 3>& picture,
                                                    const DetectorSettings& settings,
                                                    const detect::Detector<float>& detector,
                                                    detect::Pass<float>& pass) {
  detector.forward(detector.input(image::from_bytes<float>(picture)), pass);
  detect::require_finite_logits(pass.logits, name);
  return detector.in_photograph(detector.detections(pass.logits, 0, settings.confidence, settings.nms),
                                picture.shape(0), picture.shape(1));
}

/// The name of a class, or its number where there is none.
inline std::string class_name(std::size_t class_index, const std::vector<std::string>& names) {
  return class_index < names.size() ? names[class_index] : std::to_string(class_index);
}

}  // namespace tapestry::shell
