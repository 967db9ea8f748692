#pragma once
#include "../../../scenes/drawn_frames.hpp"
#include "../../../scenes/make_scene.hpp"
#include "bars.hpp"
#include "settings.hpp"
#include "street.hpp"

namespace tapestry::shell {
/// The street of a frame: the same light, sky, road and verges in all frames of a surrounding, and nothing
/// else but buildings and hills. A scene that hides part of the car is drawn again.
inline io::Frame physical_street(const scenes::Vehicle& vehicle, const evaluate::ProtocolFrame& frame,
                                 const Random& place, std::size_t size_px) {
  scenes::SceneOptions options = street_options(vehicle, frame);
  options.most_vehicles = options.most_props = 0;
  std::uint64_t attempt = 0;
  const auto make = [&](Random&) {
    Random numbers = place.fork(attempt++);
    return scenes::make_scene(numbers, options);
  };
  Random unused(0);
  auto street = scenes::make_frame(unused, make, 0.97, 2, size_px, size_px);
  street.name = name_of_view(frame);
  return street;
}

inline Figure physical_figure(const Protocol& protocol, const ProtocolResult& result) {
  Figure figure{"How often the detector finds the printed and photographed car", {}, bar_legend(result), 3};
  const auto& table = protocol.table;
  for (const auto& part : protocol.parts)
    for (std::size_t column = 0; column < table.columns.size(); ++column)
      figure.panels.push_back(bar_panel(
          protocol, result,
          {column, part.first_row, part.row_count,
           part.name + ", " + table.column_title + " " + table.columns[column]},
          [&](std::size_t row, const evaluate::Cell& cell) {
            return std::array{table.rows[row - part.first_row], std::to_string(cell.measured) + " frames"};
          }));
  return figure;
}

inline std::vector<std::string> physical_notes(const evaluate::PhysicalGrid& grid) {
  const auto number = evaluate::detail::short_number;
  const image::Conditions& all = image::physical_conditions;
  return {std::to_string(360 / grid.azimuth_step_deg) + " directions, " +
              std::to_string(grid.distances.size()) + " distances, " + std::to_string(grid.surroundings) +
              " surroundings, from " + number(grid.elevation_deg) +
              " degrees above the horizon; of each view " + std::to_string(grid.photographs) +
              (grid.photographs == 1 ? " photograph" : " photographs") +
              ", and the render as it is. A surrounding is a drawn street of one light, sky and road; "
              "buildings differ from view to view. The car is taken to be " +
              number(street_car_length_m) + " m long.",
          "Each photograph: the paint (not the clean car) printed with blacks up to " +
              number(all.printed_range) + " and whites down to " + number(1 - all.printed_range) +
              ", its colours mixed with errors up to " + number(all.printed_error) +
              ", the same print in all first photographs, another in all second ones; the picture turned by "
              "up to " +
              number(all.turn_degrees) +
              " degrees and moved as by a camera of 90 degrees that turns as far, unless half of the car "
              "would leave it, its focal length changed by up to " +
              number(100 * all.zoom) + " %; the light by up to " + number(all.exposure_stops) + " stop and " +
              number(100 * all.colour_cast) + " % of colour, in half of them with a shadow of up to " +
              number(100 * all.shadow) + " %; blur of up to " + number(all.blur_px) +
              " pixels, the sensor's noise of up to " + number(all.noise) +
              " at mid grey, contrast and saturation by up to " + number(100 * all.contrast) +
              " %, JPEG of quality " + std::to_string(all.worst_quality) +
              " to 95. The same draws for every texture. Ranges are ours, not those of a printer or a camera "
              "that was measured.",
          "A view counts once in intervals, however often it was photographed."};
}

/// FCA's table 2, simulated: effect of a camouflage after it is printed and photographed.
inline Protocol physical_protocol(const ProtocolSettings& settings, std::uint64_t seed,
                                  const ProtocolSubject&) {
  const auto grid = settings.quick ? evaluate::PhysicalGrid::quick() : evaluate::PhysicalGrid{};
  Protocol protocol{"physical", "Printed and photographed", evaluate::physical_table(grid),
                    evaluate::physical_frames(grid)};
  protocol.parts = {{"photographed", 0, grid.surroundings},
                    {"as it is", grid.surroundings, grid.surroundings}};
  protocol.notes = physical_notes(grid);
  const Random places = Random(seed).fork(0x706879736963616CULL);
  protocol.street = [=, frames = protocol.frames](const scenes::Vehicle& vehicle, std::size_t frame,
                                                  std::size_t size_px) {
    return physical_street(vehicle, frames[frame],
                           places.fork(evaluate::physical_frame(grid, frame).surroundings), size_px);
  };
  protocol.view_of = [=](std::size_t frame) { return evaluate::physical_frame(grid, frame).view; };
  protocol.photograph = [=](const camouflage::View<float>& view, std::size_t frame,
                            const camouflage::Paint<float>& paint) {
    const auto shown = evaluate::physical_frame(grid, frame);
    evaluate::Photography photography;
    photography.seed = seed;
    if (shown.photograph) photography.conditions = image::physical_conditions;
    return evaluate::photograph_of(view, shown.view, &paint, photography, shown.photograph.value_or(0));
  };
  protocol.figure = physical_figure;
  return protocol;
}
}  // namespace tapestry::shell
