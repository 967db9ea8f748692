#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/evaluate/views.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <vector>

namespace tapestry::evaluate {

// The partly hidden cars of FCA's table 4. The paper does not say how it hides them; here rectangles lie over
// the picture, and what they hide is measured on the silhouette. Source: Wang et al., FCA (AAAI 2022),
// "Robustness of partial occlusion".

/// How much of the car is hidden.
enum class OcclusionGroup : std::uint8_t { small, middle, large };
inline constexpr std::array<const char*, 3> occlusion_group_names{"small", "middle", "large"};

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

/// Which pixels of a car are hidden, and how much of its silhouette they are.
template <std::floating_point T>
class HiddenPixels {
 public:
  /// \param coverage  [h, w], share of each pixel that shows the car; must outlive this
  /// \param place     where that lies in the picture, h × w pixels
  HiddenPixels(const Array<T, 2>& coverage, const image::PixelWindow& place)
      : coverage_(coverage), place_(place), is_hidden_(zeros<std::uint8_t, 2>(coverage.shape())) {
    require_shape("HiddenPixels", "coverage", coverage, {place.height, place.width});
    for (const T share : coverage.storage()) total_ += static_cast<double>(share);
  }

  /// The hidden coverage over all of it; 0 where nothing shows.
  [[nodiscard]] double share() const { return share_with(0); }

  /// The share with some more coverage hidden.
  [[nodiscard]] double share_with(double gain) const {
    return total_ > 0 ? std::min(1.0, (hidden_ + gain) / total_) : 0.0;
  }

  /// The coverage that a rectangle would hide beyond what is hidden.
  [[nodiscard]] double gain_of(const image::PixelWindow& window) const {
    double gain = 0;
    for_each_pixel(window, [&](std::size_t y, std::size_t x) {
      if (is_hidden_(y, x) == 0) gain += static_cast<double>(coverage_(y, x));
    });
    return gain;
  }

  void hide(const image::PixelWindow& window) {
    hidden_ += gain_of(window);
    for_each_pixel(window, [&](std::size_t y, std::size_t x) { is_hidden_(y, x) = 1; });
  }

 private:
  /// Of a window in the picture, the pixels within the place, by their row and column there.
  template <class Visit>
  void for_each_pixel(const image::PixelWindow& window, Visit visit) const {
    const std::size_t top = std::max(window.top, place_.top), left = std::max(window.left, place_.left);
    const std::size_t bottom = std::min(window.top + window.height, place_.top + place_.height);
    const std::size_t right = std::min(window.left + window.width, place_.left + place_.width);
    for (std::size_t y = top; y < bottom; ++y)
      for (std::size_t x = left; x < right; ++x) visit(y - place_.top, x - place_.left);
  }

  const Array<T, 2>& coverage_;
  image::PixelWindow place_;
  Array<std::uint8_t, 2> is_hidden_;
  double total_ = 0, hidden_ = 0;
};

/// Rectangles over a car, and the share of its silhouette that they hide.
struct Occlusion {
  std::vector<Occluder> occluders{};
  double hidden_share = 0;
};

namespace detail {
/// A rectangle around some point of a place, cut to the picture.
/// \param scale  its largest extent in those of the place
[[nodiscard]] inline Occluder random_occluder(const image::PixelWindow& place, std::size_t height,
                                              std::size_t width, double scale, Random& random) {
  const auto span = [&](std::size_t first, std::size_t count, std::size_t all) {
    const auto whole = static_cast<double>(count);
    const double extent = std::max(1.0, scale * whole * random.uniform(0.4, 1));
    const double begin = static_cast<double>(first) + random.uniform(0, whole) - extent / 2;
    const auto low =
        static_cast<std::size_t>(std::clamp(std::round(begin), 0.0, static_cast<double>(all - 1)));
    const auto high =
        static_cast<std::size_t>(std::clamp(std::round(begin + extent), 0.0, static_cast<double>(all)));
    return std::array<std::size_t, 2>{low, std::max(high, low + 1) - low};
  };
  const auto [top, rows] = span(place.top, place.height, height);
  const auto [left, columns] = span(place.left, place.width, width);
  Occluder occluder{{top, left, rows, columns}};
  for (auto* colour : {&occluder.colour, &occluder.other})
    for (float& channel : *colour) channel = static_cast<float>(random.uniform());
  const std::size_t period = 1 + random.index(1 + std::max(rows, columns) / 4);
  const std::size_t kind = random.index(6);  // as often plain as textured
  if (kind == 3 || kind == 5) occluder.period_x = period;
  if (kind == 4 || kind == 5) occluder.period_y = period;
  return occluder;
}
}  // namespace detail

/// Draws rectangles over a car until a share of the group's range, chosen uniformly from it, is hidden: 5 to
/// 30, 30 to 70 or 70 to 95 %. A rectangle that would hide more than the group allows is drawn anew, and
/// smaller.
///
/// \param coverage       [h, w], share of each pixel that shows the car
/// \param place          where that lies in a picture of height × width pixels
/// \returns  nothing where no such share can be had: the car does not show, or in a few pixels only
/// \throws ShapeError if the place has another size than the coverage or leaves the picture
template <std::floating_point T>
[[nodiscard]] std::optional<Occlusion> draw_occlusion(const Array<T, 2>& coverage,
                                                      const image::PixelWindow& place, std::size_t height,
                                                      std::size_t width, OcclusionGroup group,
                                                      Random random) {
  image::require_window("draw_occlusion", place, height, width);
  HiddenPixels<T> hidden(coverage, place);
  constexpr std::array<std::array<double, 2>, 3> ranges{{{0.05, 0.3}, {0.3, 0.7}, {0.7, 0.95}}};
  const auto [low, high] = ranges[static_cast<std::size_t>(group)];
  const double wanted = random.uniform(low, high);
  double scale = std::sqrt(wanted);
  Occlusion occlusion;
  constexpr int most_attempts = 400;
  for (int attempt = 0; attempt < most_attempts && place.height > 0 && place.width > 0; ++attempt) {
    const Occluder occluder = detail::random_occluder(place, height, width, scale, random);
    const double gain = hidden.gain_of(occluder.window);
    if (!(gain > 0)) continue;
    const double share = hidden.share_with(gain);
    if (share > high || occlusion_group(share) > group) {
      scale *= 0.8;
      continue;
    }
    hidden.hide(occluder.window);
    occlusion.occluders.push_back(occluder);
    occlusion.hidden_share = hidden.share();
    if (occlusion.hidden_share >= wanted && occlusion_group(occlusion.hidden_share) == group)
      return occlusion;
  }
  return std::nullopt;
}

/// Paints rectangles over a picture, [H, W, 3], the last on top.
/// \throws ShapeError if one leaves the picture
template <std::floating_point T>
void lay_occluders(Array<T, 3>& picture, const std::vector<Occluder>& occluders) {
  for (const Occluder& occluder : occluders) {
    const auto& [top, left, height, width] = occluder.window;
    image::require_window("lay_occluders", occluder.window, picture.shape(0), picture.shape(1));
    for (std::size_t y = 0; y < height; ++y)
      for (std::size_t x = 0; x < width; ++x) {
        const bool odd_x = occluder.period_x > 0 && x / occluder.period_x % 2 != 0;
        const bool odd_y = occluder.period_y > 0 && y / occluder.period_y % 2 != 0;
        const auto& colour = odd_x != odd_y ? occluder.other : occluder.colour;
        for (std::size_t c = 0; c < 3; ++c) picture(top + y, left + x, c) = static_cast<T>(colour[c]);
      }
  }
}

/// The views whose cars are hidden in part, each once for every group: 3 × 360 of them.
[[nodiscard]] inline ViewGrid occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 10, 20, 30, 40, 50}, 24}; }

/// 3 × 72 views for a first look.
[[nodiscard]] inline ViewGrid quick_occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 20, 40}, 60}; }

/// Groups × distances.
[[nodiscard]] inline ProtocolTable occlusion_table(const ViewGrid& grid) {
  return {"occlusion",
          {"small (<= 30 %)", "middle (30-70 %)", "large (>= 70 %)"},
          "distance",
          detail::short_numbers(grid.distances)};
}

/// The frames of every group, whose number is their row, by group, then as view_frames().
/// \throws DomainError as view_frames()
[[nodiscard]] inline std::vector<ProtocolFrame> occlusion_frames(const ViewGrid& grid) {
  std::vector<ProtocolFrame> frames;
  for (std::size_t group = 0; group < occlusion_group_names.size(); ++group)
    detail::for_each_view("occlusion_frames", grid,
                          [&](std::size_t column, double distance, double elevation, double azimuth) {
                            frames.push_back({distance, elevation, azimuth, group, column});
                          });
  return frames;
}

}  // namespace tapestry::evaluate
