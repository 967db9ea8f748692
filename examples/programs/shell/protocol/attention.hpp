#pragma once
#include "../heat_map_picture.hpp"
#include "../inputs.hpp"
#include "digital.hpp"
#include "measurement.hpp"

namespace tapestry::shell {
/// Share of a detector's heat that lies on the car; 0 if there is no heat.
inline double attention_share(const Array<float, 3>& picture, const camouflage::View<float>& view,
                              const FurtherDetector& detector, HeatMap heat_map) {
  auto car = zeros<float, 2>({picture.shape(0), picture.shape(1)});
  const auto& coverage = view.paint_to_picture->coverage;
  for (std::size_t y = 0; y < coverage.shape(0); ++y)
    for (std::size_t x = 0; x < coverage.shape(1); ++x)
      car(view.window.top + y, view.window.left + x) = coverage(y, x);
  const auto heat = heat_of_input(picture, detector.detector, detector.class_index, heat_map);
  return detect::share_within(heat, car).value_or(0);
}

inline Figure attention_figure(const Protocol&, const ProtocolResult& result) {
  Figure figure{"How much of each detector's attention lies on the car",
                {},
                {{{"class=\"third\"", "the car's share of the picture: even attention"}}},
                2};
  for (const auto& section : result.sections) {
    std::vector<TextureBar> bars;
    for (std::size_t k = 0; k < result.textures.size(); ++k)
      bars.push_back({section.attention[k].mean, {}, section.car_share});
    figure.panels.push_back(texture_panel(result, section.name, bars));
  }
  return figure;
}

/// Some of the photographs with the heat of each texture laid over them. There is a row for each texture that
/// figures show: clean, the camouflage, the noise matched to it, the untouched photograph.
inline Bitmap attention_sheet(std::size_t column, const Protocol& protocol, const ProtocolResult& result,
                              const std::vector<evaluate::Control>& textures,
                              const evaluate::ProtocolOutcomes& outcomes, const ProtocolSource& source,
                              const FurtherDetector& detector, HeatMap heat_map) {
  constexpr std::size_t most = 6, side = 240;
  std::vector<std::size_t> measured;
  for (std::size_t frame = 0; frame < protocol.frames.size(); ++frame)
    if (protocol.frames[frame].column == column && outcomes.state_of(frame) == evaluate::FrameState::measured)
      measured.push_back(frame);
  const std::size_t columns = std::min(most, measured.size());
  std::vector<FrameViews> frames;
  for (std::size_t i = 0; i < columns; ++i)
    frames.push_back(source.views(measured[(2 * i + 1) * measured.size() / (2 * columns)]));
  std::vector<Bitmap> pictures;
  for (const std::size_t texture : result.shown_textures())
    for (const auto& views : frames) {
      const std::size_t first_draw = outcomes.first_column(texture);
      const auto picture =
          picture_with(views.of(textures, first_draw), textures[first_draw], source.random(0));
      const auto shown = image::from_bytes<float>(
          heated(picture, heat_of_input(picture, detector.detector, detector.class_index, heat_map)));
      const std::size_t longer = std::max(shown.shape(0), shown.shape(1));
      pictures.push_back(image::to_bytes(
          image::resize_bilinear(shown, shown.shape(0) * side / longer, shown.shape(1) * side / longer)));
    }
  return contact_sheet(pictures, columns);
}

/// Heat maps before and after: the share of a detector's evidence for the car that lies on the car.
inline Protocol attention_protocol(const ProtocolSettings& settings, std::uint64_t,
                                   const ProtocolSubject& subject) {
  Protocol protocol = photograph_protocol("attention", "What detectors look at", subject);
  protocol.maps_attention = true;
  protocol.notes = {
      "Attention: a heat map (" + settings.heat_map_kind +
          ") over the last layer that all heads see, of the score of the surest candidate of the car's class "
          "anywhere in the picture, however unsure; its share on the silhouette is its sum over the car by "
          "that over the picture, and counts as none where there is no heat at all. Differences to clean: 95 "
          "% by paired bootstrap over photographs.",
      protocol.bare_name + ": the untouched photograph."};
  protocol.figure = attention_figure;
  return protocol;
}
}  // namespace tapestry::shell
