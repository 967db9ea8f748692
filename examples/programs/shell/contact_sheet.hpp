#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/image/colour_space.hpp>
#include <vector>

namespace tapestry::shell {

using Bitmap = Array<std::uint8_t, 3>;  // [H, W, 3], RGB

/// Draws the outline of a box, two pixels wide, inside the picture.
inline void draw_box(Bitmap& bitmap, const detect::Box& box, const std::array<std::uint8_t, 3>& colour) {
  const auto height = static_cast<long>(bitmap.shape(0));
  const auto width = static_cast<long>(bitmap.shape(1));
  const auto pixel = [](double value, long last) { return std::clamp(std::lround(value), 0L, last); };
  const long left = pixel(box.left(), width - 1);
  const long right = pixel(box.right() - 1, width - 1);
  const long top = pixel(box.top(), height - 1);
  const long bottom = pixel(box.bottom() - 1, height - 1);
  for (long y = top; y <= bottom; ++y)
    for (long x = left; x <= right; ++x) {
      const bool edge = y - top < 2 || bottom - y < 2 || x - left < 2 || right - x < 2;
      for (std::size_t c = 0; edge && c < 3; ++c)
        bitmap(static_cast<std::size_t>(y), static_cast<std::size_t>(x), c) = colour[c];
    }
}

/// Columns of a sheet of so many pictures.
inline std::size_t sheet_columns(std::size_t pictures) { return pictures > 12 ? 8 : 3; }

/// Most pictures of `side` pixels on a sheet, so that neither side of the sheet exceeds the 16,384 pixels of
/// a picture file.
inline std::size_t most_on_a_sheet(std::size_t side) {
  constexpr std::size_t limit = 16384 - 4, most = 160;
  const std::size_t along = limit / (side + 4);
  return along >= 8 ? std::min(most, 8 * along) : std::clamp<std::size_t>(3 * along, 1, 12);
}

/// Pictures of one size side by side on white with a small gap, `columns` in a row.
inline Bitmap contact_sheet(const std::vector<Bitmap>& pictures, std::size_t columns) {
  if (pictures.empty()) return Bitmap(Extents<3>{1, 1, 3}, std::uint8_t(255));
  constexpr std::size_t gap = 4;
  columns = std::min(columns, pictures.size());
  const std::size_t rows = (pictures.size() + columns - 1) / columns;
  const std::size_t height = pictures.front().shape(0);
  const std::size_t width = pictures.front().shape(1);
  auto sheet = filled<std::uint8_t, 3>({rows * (height + gap) + gap, columns * (width + gap) + gap, 3},
                                       std::uint8_t(255));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const std::size_t top = gap + i / columns * (height + gap);
    const std::size_t left = gap + i % columns * (width + gap);
    for (std::size_t y = 0; y < height; ++y)
      std::copy_n(&pictures[i](y, 0, 0), 3 * width, &sheet(top + y, left, 0));
  }
  return sheet;
}

/// `columns` of the views, evenly spread, in two rows: `before` above `after`.
inline Bitmap comparison(const std::vector<Bitmap>& before, const std::vector<Bitmap>& after,
                         std::size_t columns) {
  columns = std::min(columns, before.size());
  std::vector<Bitmap> pictures;
  for (const auto* row : {&before, &after})
    for (std::size_t i = 0; i < columns; ++i)
      pictures.push_back((*row)[(2 * i + 1) * row->size() / (2 * columns)]);
  return contact_sheet(pictures, columns);
}

}  // namespace tapestry::shell
