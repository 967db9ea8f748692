#pragma once
#include <tapestry/detect/heat_map.hpp>
#include <tapestry/image/batch.hpp>
#include "contact_sheet.hpp"
#include "detector_inputs.hpp"

namespace tapestry::shell {
/// Function of a layer's activations and the gradient of a score with respect to them.
using HeatMap = Array<float, 2> (*)(const Array<float, 3>&, const Array<float, 3>&);

inline constexpr std::array<std::pair<const char*, HeatMap>, 3> heat_maps{
    {{"layer_cam", &detect::layer_cam<float>},
     {"grad_cam", &detect::grad_cam<float>},
     {"grad_cam_plus_plus", &detect::grad_cam_plus_plus<float>}}};

/// \throws Error (usage) that lists the names
inline HeatMap heat_map_by_name(const std::string& name) {
  for (const auto& [kind, heat_map] : heat_maps)
    if (name == kind) return heat_map;
  throw Error(ErrorKind::usage, {"--heat-map-kind is '", name, "'; expected one of ",
                                 listed(heat_maps, [](const auto& known) { return known.first; })});
}

/// Heat of the first observed layer for the score of a class: of its most confident candidate, however low
/// the confidence. The heat is resized to the input, [H, W]; zeros if there is no candidate.
///
/// \param input     [H, W, 3], as the network takes it
/// \param heat_map  one of heat_maps. A detector's score belongs to a place, but heat maps with one weight
///                  for a whole channel show the channels rather than the place
inline Array<float, 2> heat_of_input(const Array<float, 3>& input, const detect::Detector<float>& detector,
                                     std::size_t class_index, HeatMap heat_map) {
  const std::size_t height = detector.input_height(), width = detector.input_width();
  detect::Pass<float> pass;
  detector.forward(image::batch_of(input), pass, detect::Mode::input_gradient);
  auto heat = zeros<float, 2>({height, width});
  const auto best =
      detect::best_candidate(detector.heads(), loss::to_read(pass.logits), 0, {class_index}, height, width);
  if (!best) return heat;
  const auto adjoints = detect::score_adjoint(detector.heads(), pass.logits, 0, class_index, *best);
  const auto map = heat_map(detector.layer_values(pass, 0, 0),
                            detector.layer_adjoint(pass, loss::to_read(adjoints), 0, 0));
  Array<float, 3> single(Extents<3>{map.shape(0), map.shape(1), 1});
  std::copy_n(map.data(), map.size(), single.data());
  const auto spread = image::resize_bilinear(single, height, width);
  std::copy_n(spread.data(), spread.size(), heat.data());
  return heat;
}

/// A picture, [H, W, 3], with heat, [H, W], laid over it, from clear over red to yellow at the hottest place.
inline Bitmap heated(Array<float, 3> picture, const Array<float, 2>& heat) {
  const float greatest = *std::max_element(heat.begin(), heat.end());
  for (std::size_t pixel = 0; greatest > 0 && pixel < heat.size(); ++pixel) {
    const float share_of_greatest = heat.data()[pixel] / greatest;
    const float share = 0.7F * std::min(1.0F, 2 * share_of_greatest);
    const float colour[3] = {1, std::clamp(2 * share_of_greatest - 1, 0.0F, 1.0F), 0};
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = picture.data()[3 * pixel + c];
      value = (1 - share) * value + share * colour[c];
    }
  }
  return image::to_bytes(picture);
}

/// A picture of any extents with heat_of_input() laid over it.
inline Bitmap heat_map_picture(const Bitmap& picture, const detect::Detector<float>& detector,
                               std::size_t class_index, HeatMap heat_map) {
  const std::size_t height = detector.input_height(), width = detector.input_width();
  auto shown = image::from_bytes<float>(picture);
  const auto heat =
      heat_of_input(image::fitted(shown, height, width, detector.fit()), detector, class_index, heat_map);
  Array<float, 3> single(Extents<3>{height, width, 1});
  std::copy_n(heat.data(), heat.size(), single.data());
  const auto place = image::placement(picture.shape(0), picture.shape(1), height, width, detector.fit().kind);
  const auto of_picture =
      image::resize_bilinear(image::crop(single, {place.top, place.left, place.height, place.width}),
                             picture.shape(0), picture.shape(1));
  Array<float, 2> heat_of_picture(Extents<2>{picture.shape(0), picture.shape(1)});
  std::copy_n(of_picture.data(), of_picture.size(), heat_of_picture.data());
  return heated(std::move(shown), heat_of_picture);
}
}  // namespace tapestry::shell
