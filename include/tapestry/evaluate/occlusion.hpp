#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
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
  HiddenPixels(const Array<T, 2>& coverage, const image::PixelWindow& place);

  /// The hidden coverage over all of it; 0 where nothing shows.
  [[nodiscard]] double share() const { return share_with(0); }

  /// The share with some more coverage hidden.
  [[nodiscard]] double share_with(double gain) const {
    return total_ > 0 ? std::min(1.0, (hidden_ + gain) / total_) : 0.0;
  }

  /// The coverage that a rectangle would hide beyond what is hidden.
  [[nodiscard]] double gain_of(const image::PixelWindow& window) const;

  void hide(const image::PixelWindow& window);

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
                                                      std::size_t width, OcclusionGroup group, Random random);

/// Paints rectangles over a picture, [H, W, 3], the last on top.
/// \throws ShapeError if one leaves the picture
template <std::floating_point T>
void lay_occluders(Array<T, 3>& picture, const std::vector<Occluder>& occluders);

/// The views whose cars are hidden in part, each once for every group: 3 × 360 of them.
[[nodiscard]] inline ViewGrid occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 10, 20, 30, 40, 50}, 24}; }

/// 3 × 72 views for a first look.
[[nodiscard]] inline ViewGrid quick_occlusion_grid() { return {{1.5, 3, 5, 10}, {0, 20, 40}, 60}; }

/// Groups × distances.
[[nodiscard]] ProtocolTable occlusion_table(const ViewGrid& grid);

/// The frames of every group, whose number is their row, by group, then as view_frames().
/// \throws DomainError as view_frames()
[[nodiscard]] std::vector<ProtocolFrame> occlusion_frames(const ViewGrid& grid);

extern template class HiddenPixels<float>;
extern template class HiddenPixels<double>;

}  // namespace tapestry::evaluate
