#pragma once
#include "detector_inputs.hpp"
#include "drawn_boxes.hpp"

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

/// Detections with their boxes cut at the edge of a picture of these extents; those beyond it are left out.
inline std::vector<detect::Detection> cut_at_picture(std::vector<detect::Detection> detections,
                                                     std::size_t height, std::size_t width) {
  const auto picture =
      detect::box_from_corners(0, 0, static_cast<double>(width), static_cast<double>(height));
  std::erase_if(detections, [&](const auto& d) { return detect::intersection(d.box, picture) == 0; });
  for (auto& detection : detections) {
    detect::Box& box = detection.box;
    if (box.left() < picture.left() || box.top() < picture.top() || box.right() > picture.right() ||
        box.bottom() > picture.bottom())
      box = detect::clipped(box, picture);
  }
  return detections;
}

/// A picture with boxes in the colours of their classes, each with name and score.
inline MarkedPicture marked(Bitmap picture, const std::vector<detect::Detection>& detections,
                            const std::vector<std::string>& names) {
  MarkedPicture result{std::move(picture)};
  for (const auto& d : detections)
    result.boxes.push_back(
        {d.box, label_of(class_name(d.class_index, names), d.confidence), class_colour(d.class_index)});
  return result;
}
}  // namespace tapestry::shell
