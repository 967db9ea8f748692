#pragma once
#include <cstddef>
#include <optional>
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
[[nodiscard]] ProtocolTable physical_table(const PhysicalGrid& grid);

/// The frames of a grid, by surroundings, then distance, then direction; of each view its photographs, then
/// itself.
/// \throws DomainError unless the azimuths divide a full turn and there is a photograph
[[nodiscard]] std::vector<ProtocolFrame> physical_frames(const PhysicalGrid& grid);

/// What the frame-th of physical_frames() shows.
[[nodiscard]] PhysicalFrame physical_frame(const PhysicalGrid& grid, std::size_t frame);

}  // namespace tapestry::evaluate
