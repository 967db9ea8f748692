#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <numbers>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::evaluate {

// The views of FCA's table 3: pure renders of the car all around, from several heights and distances.
// Distances are units of the renderer, in which a mesh out of geometry::normalise_mesh() has the half length
// 1, and half the field of view is 30°, Neural Mesh Renderer's default; the paper states neither, but its
// pictures fit both. Source: Wang et al., FCA (AAAI 2022), "Robustness of long distance".

/// Half of the field of view of a protocol's camera, across and up.
inline constexpr double protocol_half_fov_deg = 30;

/// A camera of a protocol, and its place in the protocol's table.
struct ProtocolFrame {
  double distance = 1;       ///< from the middle of the car, whose half length is 1
  double elevation_deg = 0;  ///< above the horizon
  double azimuth_deg = 0;    ///< 0 in front of the car, 90 at its left
  std::size_t row = 0;       ///< of the table
  std::size_t column = 0;
};

/// A table whose cells are sets of frames.
struct ProtocolTable {
  std::string row_title;
  std::vector<std::string> rows;
  std::string column_title;
  std::vector<std::string> columns;
  /// Of each row, the frames that are pictures of one view and follow one another; one where it has no entry.
  std::vector<std::size_t> pictures_a_view{};

  [[nodiscard]] std::size_t cell_count() const { return rows.size() * columns.size(); }
  [[nodiscard]] std::size_t pictures_of_row(std::size_t row) const {
    return row < pictures_a_view.size() ? pictures_a_view[row] : 1;
  }
  [[nodiscard]] std::size_t cell_of(const ProtocolFrame& frame) const {
    return frame.row * columns.size() + frame.column;
  }
};

inline constexpr std::size_t sector_count = 8;  ///< of 45° each

/// The sector that an azimuth lies in: 45·k ≤ azimuth < 45·(k + 1) degrees, full turns taken off.
/// \throws DomainError unless the azimuth is finite
[[nodiscard]] std::size_t sector_of(double azimuth_deg);

/// Distances × elevations × azimuths. The default has the 4,320 views of the paper.
struct ViewGrid {
  std::vector<double> distances{1.5, 3, 5, 10, 15, 20};
  std::vector<double> elevations_deg{0, 10, 20, 30, 40, 50};
  std::size_t azimuth_step_deg = 3;

  /// The 432 views of a first look: every 15 degrees at half of the elevations.
  [[nodiscard]] static ViewGrid quick() { return {ViewGrid{}.distances, {0, 20, 40}, 15}; }
};

namespace detail {
/// "1.5" or "20".
[[nodiscard]] std::string short_number(double value);

[[nodiscard]] std::vector<std::string> short_numbers(const std::vector<double>& values);

/// Calls visit(column, distance, elevation in degrees, azimuth in degrees), azimuths innermost.
template <class Visit>
void for_each_view(const char* operation, const ViewGrid& grid, Visit visit) {
  if (grid.azimuth_step_deg == 0 || 360 % grid.azimuth_step_deg != 0)
    throw DomainError(std::string(operation) + ": azimuths every " + std::to_string(grid.azimuth_step_deg) +
                      " degrees do not divide a full turn");
  for (std::size_t column = 0; column < grid.distances.size(); ++column)
    for (const double elevation_deg : grid.elevations_deg)
      for (std::size_t azimuth_deg = 0; azimuth_deg < 360; azimuth_deg += grid.azimuth_step_deg)
        visit(column, grid.distances[column], elevation_deg, static_cast<double>(azimuth_deg));
}
}  // namespace detail

/// Sectors × distances.
[[nodiscard]] ProtocolTable view_table(const ViewGrid& grid);

/// The frames of a grid, by distance, then elevation, then azimuth.
/// \throws DomainError unless the azimuths divide a full turn
[[nodiscard]] std::vector<ProtocolFrame> view_frames(const ViewGrid& grid);

/// The camera of a frame, for square pictures; it looks at the origin.
/// \throws DomainError if the distance is not positive
[[nodiscard]] geometry::Camera protocol_camera(const ProtocolFrame& frame);

/// How a protocol's pictures are made.
struct ProtocolPicture {
  std::size_t height = 0;  ///< of the network's input, pixels
  std::size_t width = 0;
  std::size_t samples_per_axis = 2;
  image::Fit fit{};                           ///< of the square picture in it
  std::array<double, 3> background{1, 1, 1};  ///< one colour, in [0, 1]; the paper's is white
};

/// The car alone before a plain background, in the default raster::Light, which is Neural Mesh Renderer's.
/// Its target is the box around what shows of the car; nothing does where visible_pixels is 0.
///
/// \param car  of half length 1, around the origin; see geometry::normalise_mesh()
/// \throws DomainError as protocol_camera() and raster::texture_operator()
template <std::floating_point T>
[[nodiscard]] camouflage::View<T> protocol_view(const ProtocolFrame& frame, const raster::PaintedMesh& car,
                                                const ProtocolPicture& picture);

}  // namespace tapestry::evaluate
