#pragma once
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::evaluate {
// The views of FCA's table 3: pure renders of the car all around, from several heights and distances.
// Distances are units of the renderer: a mesh from geometry::normalise_mesh() has the half length 1. Half the
// field of view is 30°, Neural Mesh Renderer's default. The paper states neither, but its pictures fit both.
// Source: Wang et al., FCA (AAAI 2022), "Robustness of long distance".

/// Half of the field of view of a protocol's camera, across and up.
inline constexpr double protocol_half_fov_deg = 30;

/// A camera of a protocol, and its place in the protocol's table.
struct ProtocolFrame {
  double distance = 1;       ///< from the car's middle, in half lengths of the car
  double elevation_deg = 0;  ///< above the horizon
  double azimuth_deg = 0;    ///< 0 in front of the car, 90 at its left
  std::size_t row = 0;       ///< row of the table
  std::size_t column = 0;
};

/// A table whose cells are sets of frames.
struct ProtocolTable {
  std::string row_title;
  std::vector<std::string> rows;
  std::string column_title;
  std::vector<std::string> columns;
  /// For each row, the number of consecutive frames that are pictures of one view; 1 for a row without entry.
  std::vector<std::size_t> pictures_a_view{};

  [[nodiscard]] std::size_t cell_count() const { return rows.size() * columns.size(); }
  [[nodiscard]] std::size_t pictures_of_row(std::size_t row) const {
    return row < pictures_a_view.size() ? pictures_a_view[row] : 1;
  }
  [[nodiscard]] std::size_t cell_of(const ProtocolFrame& frame) const {
    return frame.row * columns.size() + frame.column;
  }
};

inline constexpr std::size_t sector_count = 8;  ///< each of 45°

/// The sector of an azimuth: 45·k ≤ azimuth < 45·(k + 1) degrees, modulo full turns.
/// \throws DomainError unless the azimuth is finite
[[nodiscard]] std::size_t sector_of(double azimuth_deg);

/// Distances × elevations × azimuths. The default has the 4,320 views of the paper.
struct ViewGrid {
  std::vector<double> distances{1.5, 3, 5, 10, 15, 20};
  std::vector<double> elevations_deg{0, 10, 20, 30, 40, 50};
  std::size_t azimuth_step_deg = 3;

  /// The 432 views for a first look: every 15 degrees at half of the elevations.
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
    throw DomainError(
        {operation, ": azimuths every ", grid.azimuth_step_deg, " degrees do not divide a full turn"});
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

/// Settings of a protocol's pictures.
struct ProtocolPicture {
  std::size_t height = 0;  ///< of the network's input, pixels
  std::size_t width = 0;
  std::size_t samples_per_axis = 2;
  image::Fit fit{};                           ///< fit of the square picture into it
  std::array<double, 3> background{1, 1, 1};  ///< one colour, in [0, 1]; the paper's is white
};

/// The car alone before a plain background, in the default raster::Light, which is Neural Mesh Renderer's.
/// Its target is the box around its visible part; where visible_pixels is 0 there is none.
///
/// \param car  of half length 1, around the origin; see geometry::normalise_mesh()
/// \throws DomainError as protocol_camera() and raster::texture_operator()
[[nodiscard]] camouflage::View<float> protocol_view(const ProtocolFrame& frame,
                                                    const raster::PaintedMesh& car,
                                                    const ProtocolPicture& picture);

// The partly hidden cars of FCA's table 4. The paper does not state how it hides them; here rectangles lie
// over the picture, and the hidden share of the silhouette is measured. Source: Wang et al., FCA (AAAI 2022),
// "Robustness of partial occlusion".

/// Groups of the hidden share of a car.
enum class OcclusionGroup : std::uint8_t { small, middle, large };
/// Names of the groups, in the order of OcclusionGroup.
inline constexpr std::array<const char*, 3> occlusion_group_names{"small", "middle", "large"};

/// Least and largest hidden share of the pictures that are drawn for each group.
inline constexpr std::array<std::array<double, 2>, 3> hidden_shares{{{0.05, 0.3}, {0.3, 0.7}, {0.7, 0.95}}};

/// Small: at most 30 %. Large: at least 70 %. Middle: between them.
/// \param hidden_share  of the car's silhouette, in [0, 1]
[[nodiscard]] constexpr OcclusionGroup occlusion_group(double hidden_share) {
  if (hidden_share <= 0.3) return OcclusionGroup::small;
  return hidden_share < 0.7 ? OcclusionGroup::middle : OcclusionGroup::large;
}

/// A rectangle before the car, of one colour, or of two in stripes or squares.
struct Occluder {
  image::PixelWindow window;      ///< in the picture
  std::array<float, 3> colour{};  ///< in [0, 1]
  std::array<float, 3> other{};   ///< the second colour
  std::size_t period_x = 0;       ///< pixels until the colours change along a row; 0: they do not
  std::size_t period_y = 0;       ///< the same along a column
};

/// The hidden pixels of a car, and their share of its silhouette.
class HiddenPixels {
 public:
  /// \param coverage  [h, w], share of each pixel that shows the car; must outlive this
  /// \param place     where that lies in the picture, h × w pixels
  HiddenPixels(const Array<float, 2>& coverage, const image::PixelWindow& place);

  /// The hidden coverage over all of it; 0 where nothing shows.
  [[nodiscard]] double share() const { return share_with(0); }

  /// The share if `gain` more coverage were hidden.
  [[nodiscard]] double share_with(double gain) const {
    return total_ > 0 ? std::min(1.0, (hidden_ + gain) / total_) : 0.0;
  }

  /// Coverage that a rectangle would hide in addition.
  [[nodiscard]] double gain_of(const image::PixelWindow& window) const;

  void hide(const image::PixelWindow& window);

 private:
  /// Visits the pixels that a window of the picture shares with the place, by their row and column in the
  /// place.
  template <class Visit>
  void for_each_pixel(const image::PixelWindow& window, Visit visit) const {
    const std::size_t top = std::max(window.top, place_.top), left = std::max(window.left, place_.left);
    const std::size_t bottom = std::min(window.top + window.height, place_.top + place_.height);
    const std::size_t right = std::min(window.left + window.width, place_.left + place_.width);
    for (std::size_t y = top; y < bottom; ++y)
      for (std::size_t x = left; x < right; ++x) visit(y - place_.top, x - place_.left);
  }

  const Array<float, 2>& coverage_;
  image::PixelWindow place_;
  Array<std::uint8_t, 2> is_hidden_;
  double total_ = 0, hidden_ = 0;
};

/// Rectangles over a car, and the share of its silhouette that they hide.
struct Occlusion {
  std::vector<Occluder> occluders{};
  double hidden_share = 0;
};

/// Draws rectangles over a car until a share of the group's range, chosen uniformly from it, is hidden: 5 to
/// 30, 30 to 70 or 70 to 95 %. A rectangle that would hide more than the group allows is drawn anew, and
/// smaller.
///
/// \param coverage       [h, w], share of each pixel that shows the car
/// \param place          where that lies in a picture of height × width pixels
/// \returns  nothing if no such share is possible: the car shows in no or few pixels
/// \throws ShapeError if the place has another size than the coverage or leaves the picture
[[nodiscard]] std::optional<Occlusion> draw_occlusion(const Array<float, 2>& coverage,
                                                      const image::PixelWindow& place, std::size_t height,
                                                      std::size_t width, OcclusionGroup group, Random random);

/// Paints rectangles over a picture, [H, W, 3], the last on top.
/// \throws ShapeError if one leaves the picture
void lay_occluders(Array<float, 3>& picture, const std::vector<Occluder>& occluders);

/// The views whose cars are partly hidden, each once for every group: 3 × 360 of them.
[[nodiscard]] inline ViewGrid occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 10, 20, 30, 40, 50}, 24}; }

/// 3 × 72 views for a first look.
[[nodiscard]] inline ViewGrid quick_occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 20, 40}, 60}; }

/// Groups × distances.
[[nodiscard]] ProtocolTable occlusion_table(const ViewGrid& grid);

/// The frames of every group, whose number is their row, by group, then as view_frames().
/// \throws DomainError as view_frames()
[[nodiscard]] std::vector<ProtocolFrame> occlusion_frames(const ViewGrid& grid);
}  // namespace tapestry::evaluate
