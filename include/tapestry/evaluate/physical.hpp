#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/views.hpp>
#include <vector>

namespace tapestry::evaluate {

// The photographs of FCA's table 2: a painted toy car from eight directions, at three distances, in three
// surroundings. The paper prints its camouflages, glues them on and takes 144 photographs, two of each of
// these 72 settings; it states neither distances nor heights. Source: Wang et al., FCA (AAAI 2022), "Physical
// Adversarial Attack".

/// Surroundings × distances × directions, each photographed some times and, to compare with, seen as it is.
struct PhysicalGrid {
  std::size_t surroundings = 3;
  std::vector<double> distances{3, 4.5, 6};  ///< as ProtocolFrame's
  std::size_t azimuth_step_deg = 45;
  double elevation_deg = 20;
  std::size_t photographs = 2;  ///< of each view

  /// A first look: half of the directions, one photograph each.
  [[nodiscard]] static PhysicalGrid quick() { return {3, PhysicalGrid{}.distances, 90, 20, 1}; }

  /// Frames of each view: its photographs, then itself.
  [[nodiscard]] std::size_t frames_a_view() const { return photographs + 1; }
};

/// What a frame of physical_frames() shows.
struct PhysicalFrame {
  std::size_t view = 0;                     ///< its number in the grid
  std::size_t surroundings = 0;             ///< where the car stands
  std::optional<std::size_t> photograph{};  ///< which one of the view; none: the view as it is
};

/// Surroundings × distances: first those photographed, then the same as they are.
[[nodiscard]] inline ProtocolTable physical_table(const PhysicalGrid& grid) {
  ProtocolTable table{"surroundings", {}, "distance", detail::short_numbers(grid.distances)};
  for (const char* as_it_is : {"", " as it is"})
    for (std::size_t place = 0; place < grid.surroundings; ++place)
      table.rows.push_back("street " + std::to_string(place + 1) + as_it_is);
  table.pictures_a_view.assign(grid.surroundings, grid.photographs);
  return table;
}

/// The frames of a grid, by surroundings, then distance, then direction; of each view its photographs, then
/// itself.
/// \throws DomainError unless the azimuths divide a full turn and there is a photograph
[[nodiscard]] inline std::vector<ProtocolFrame> physical_frames(const PhysicalGrid& grid) {
  if (grid.photographs == 0) throw DomainError("physical_frames: no photographs of a view");
  const ViewGrid views{grid.distances, {grid.elevation_deg}, grid.azimuth_step_deg};
  std::vector<ProtocolFrame> frames;
  for (std::size_t place = 0; place < grid.surroundings; ++place)
    detail::for_each_view(
        "physical_frames", views, [&](std::size_t column, double distance, double elevation, double azimuth) {
          frames.insert(frames.end(), grid.photographs, {distance, elevation, azimuth, place, column});
          frames.push_back({distance, elevation, azimuth, grid.surroundings + place, column});
        });
  return frames;
}

/// What the frame-th of physical_frames() shows.
[[nodiscard]] inline PhysicalFrame physical_frame(const PhysicalGrid& grid, std::size_t frame) {
  const std::size_t view = frame / grid.frames_a_view(), picture = frame % grid.frames_a_view();
  const std::size_t views_a_place = grid.distances.size() * (360 / grid.azimuth_step_deg);
  PhysicalFrame shown{view, view / views_a_place};
  if (picture < grid.photographs) shown.photograph = picture;
  return shown;
}

}  // namespace tapestry::evaluate
