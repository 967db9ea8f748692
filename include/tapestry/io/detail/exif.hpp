#pragma once
#include <string_view>
#include <tapestry/core/array.hpp>

namespace tapestry::io {
namespace detail {

/// Integers of an EXIF block, in its own byte order.
class ExifReader {
 public:
  explicit ExifReader(std::string_view tiff) : tiff_(tiff), is_little_(tiff.starts_with("II")) {}

  /// The orientation of the first picture; 1 if the block states no valid one.
  [[nodiscard]] int orientation() const {
    const std::size_t value = value_of(number(4, 4), 0x0112, 3);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }

  /// Focal length of the lens as if on 35 mm film, mm; 0 if the block does not state it.
  [[nodiscard]] std::size_t focal_length_35mm() const {
    return value_of(value_of(number(4, 4), 0x8769, 4), 0xA405, 3);
  }

 private:
  /// The first value of this tag and type, 3 (two bytes) or 4 (four), in a directory; 0 if there is none.
  [[nodiscard]] std::size_t value_of(std::size_t directory, std::size_t tag, std::size_t type) const {
    if (directory == 0 || (!is_little_ && !tiff_.starts_with("MM"))) return 0;
    const std::size_t entries = number(directory, 2);
    for (std::size_t i = 0; i < entries && directory + 2 + 12 * i + 12 <= tiff_.size(); ++i) {
      const std::size_t entry = directory + 2 + 12 * i;
      if (number(entry, 2) == tag && number(entry + 2, 2) == type)
        return number(entry + 8, type == 3 ? 2 : 4);
    }
    return 0;
  }

  /// The integer there; 0 beyond the end of the block.
  [[nodiscard]] std::size_t number(std::size_t at, std::size_t bytes) const {
    if (at > tiff_.size() || tiff_.size() - at < bytes) return 0;
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8U | static_cast<unsigned char>(tiff_[at + (is_little_ ? bytes - 1 - i : i)]);
    return value;
  }

  std::string_view tiff_;
  bool is_little_;
};

}  // namespace detail

/// A picture, [H, W, C], turned upright by its EXIF orientation. 1 returns it without a copy, 2 mirrors it
/// left to right, 4 top to bottom, and 3 turns it by half a circle. 5 to 8 exchange rows and columns; 6 turns
/// it clockwise by a quarter, 8 counterclockwise.
template <class Element>
[[nodiscard]] Array<Element, 3> turned_upright(Array<Element, 3> stored, int orientation) {
  if (orientation == 1) return stored;
  const auto [rows, columns, channels] = stored.shape();
  const bool exchanges = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Array<Element, 3> upright(Extents<3>{exchanges ? columns : rows, exchanges ? rows : columns, channels});
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t row = from_bottom ? rows - 1 - y : y;
      const std::size_t column = from_right ? columns - 1 - x : x;
      for (std::size_t c = 0; c < channels; ++c)
        upright(exchanges ? column : row, exchanges ? row : column, c) = stored(y, x, c);
    }
  return upright;
}

}  // namespace tapestry::io
