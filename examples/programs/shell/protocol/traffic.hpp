#pragma once
#include "../../../scenes/drawn_frames.hpp"
#include "../../../scenes/make_scene.hpp"
#include "occlusion.hpp"
#include "street.hpp"

namespace tapestry::shell {
/// The street of a frame without its car, and the mask of its part that other vehicles do not hide. Draws
/// scenes until that share is in the frame's group. If none of some hundred is: a frame without a visible
/// car, which is left out.
inline io::Frame traffic_street(const scenes::Vehicle& vehicle, const evaluate::ProtocolFrame& frame,
                                std::size_t size_px, Random random) {
  constexpr std::size_t attempts = 300;
  scenes::SceneOptions options = street_options(vehicle, frame);
  options.has_blocker = true;
  const auto make = [&](Random& numbers) { return scenes::make_scene(numbers, options); };
  const auto [least_hidden, most_hidden] = evaluate::hidden_shares.at(frame.row);
  auto street =
      scenes::find_frame(random, make, 1 - most_hidden, 1 - least_hidden, size_px, size_px, false, attempts);
  if (!street) {
    io::Frame hidden;
    hidden.image = zeros<std::uint8_t, 3>({size_px, size_px, 3});
    hidden.mask = zeros<std::uint8_t, 2>({size_px, size_px});
    hidden.camera = evaluate::protocol_camera(frame);
    return hidden;
  }
  street->name = name_of_view(frame) + ", " + evaluate::occlusion_group_names.at(frame.row);
  return std::move(*street);
}

/// Cars in drawn streets behind other vehicles: table 4 with things that really stand before a car.
inline Protocol traffic_protocol(const ProtocolSettings& settings, std::uint64_t seed,
                                 const ProtocolSubject&) {
  evaluate::ViewGrid grid{{4, 5.5, 7}, {4, 12}, settings.quick ? 60U : 20U};
  Protocol protocol{"traffic", "Behind other vehicles", evaluate::occlusion_table(grid),
                    evaluate::occlusion_frames(grid)};
  protocol.bare_name = "no car";
  protocol.notes = {
      "Drawn streets, in each another vehicle between the camera and the car, and up to three elsewhere. The "
      "hidden share is that of the car's silhouette, by the meshes: 5 to 30, 30 to 70 and 70 to 95 %.",
      "A box counts by its overlap with what still shows of the car.",
      protocol.bare_name +
          ": the same streets without the car, but with its shadow. What is found there is another vehicle, "
          "and as much of the other rows may be."};
  const Random random = Random(seed).fork(0x74726166666963ULL);
  protocol.street = [random, frames = protocol.frames](const scenes::Vehicle& vehicle, std::size_t frame,
                                                       std::size_t size_px) {
    return traffic_street(vehicle, frames[frame], size_px, random.fork(frame));
  };
  protocol.change = [](const camouflage::View<float>& view, std::size_t) {
    return std::optional(FrameChange{view.hidden_share, [](Array<float, 3>&) {}});
  };
  protocol.figure = occlusion_figure;
  return protocol;
}
}  // namespace tapestry::shell
