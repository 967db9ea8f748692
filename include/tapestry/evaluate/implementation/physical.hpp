#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/physical.hpp>
#include <tapestry/evaluate/views.hpp>
#include <vector>

namespace tapestry::evaluate {

ProtocolTable physical_table(const PhysicalGrid& grid) {
  ProtocolTable table{"surroundings", {}, "distance", detail::short_numbers(grid.distances)};
  for (const char* as_it_is : {"", " as it is"})
    for (std::size_t place = 0; place < grid.surroundings; ++place)
      table.rows.push_back("street " + std::to_string(place + 1) + as_it_is);
  table.pictures_a_view.assign(grid.surroundings, grid.photographs);
  return table;
}

std::vector<ProtocolFrame> physical_frames(const PhysicalGrid& grid) {
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

PhysicalFrame physical_frame(const PhysicalGrid& grid, std::size_t frame) {
  const std::size_t view = frame / grid.frames_a_view(), picture = frame % grid.frames_a_view();
  const std::size_t views_a_place = grid.distances.size() * (360 / grid.azimuth_step_deg);
  PhysicalFrame shown{view, view / views_a_place};
  if (picture < grid.photographs) shown.photograph = picture;
  return shown;
}

}  // namespace tapestry::evaluate
