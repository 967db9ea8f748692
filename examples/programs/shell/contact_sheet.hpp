#pragma once
#include "drawn_boxes.hpp"

namespace tapestry::shell {
/// Whether the picture at `index` is one of `shown` evenly spread ones among `pictures`.
inline bool is_shown(std::size_t index, std::size_t shown, std::size_t pictures) {
  return (index + 1) * shown / pictures > index * shown / pictures;
}

/// Indices of `most` evenly spread ones of some pictures.
inline std::vector<std::size_t> shown_places(std::size_t most, std::size_t pictures) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < pictures; ++i)
    if (is_shown(i, std::min(most, pictures), pictures)) places.push_back(i);
  return places;
}

inline std::size_t sheet_columns(std::size_t pictures) { return pictures > 12 ? 8 : 3; }

/// Most pictures of `side` pixels on a sheet, so that neither side of the sheet exceeds the 16,384 pixels of
/// a picture file.
inline std::size_t most_on_a_sheet(std::size_t side) {
  constexpr std::size_t limit = 16384 - 4, most = 160;
  const std::size_t along = limit / (side + 4);
  return along >= 8 ? std::min(most, 8 * along) : std::clamp<std::size_t>(3 * along, 1, 12);
}

/// Pictures, each as drawn() says, side by side on white with a small gap, `columns` to a row; columns are as
/// wide as the widest, rows as high as their highest.
template <class Picture>
Bitmap contact_sheet(const std::vector<Picture>& pictures, std::size_t columns) {
  if (pictures.empty()) return Bitmap(Extents<3>{1, 1, 3}, std::uint8_t(255));
  constexpr std::size_t gap = 4;
  columns = std::min(columns, pictures.size());
  std::size_t width = 0;
  std::vector<std::size_t> tops{gap};  // of the rows
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (i % columns == 0) tops.push_back(0);
    width = std::max(width, bitmap_of(pictures[i]).shape(1));
    tops.back() = std::max(tops.back(), tops.end()[-2] + bitmap_of(pictures[i]).shape(0) + gap);
  }
  auto sheet = filled<std::uint8_t, 3>({tops.back(), columns * (width + gap) + gap, 3}, std::uint8_t(255));
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    const Bitmap& picture = drawn(pictures[i]);
    const std::size_t top = tops[i / columns], left = gap + i % columns * (width + gap);
    for (std::size_t y = 0; y < picture.shape(0); ++y)
      std::copy_n(&picture(y, 0, 0), 3 * picture.shape(1), &sheet(top + y, left, 0));
  }
  return sheet;
}

/// `columns` of the views, evenly spread, in two rows: `before` above `after`.
template <class Picture>
Bitmap comparison(const std::vector<Picture>& before, const std::vector<Picture>& after,
                  std::size_t columns) {
  columns = std::min(columns, before.size());
  std::vector<Picture> pictures;
  for (const auto* row : {&before, &after})
    for (std::size_t i = 0; i < columns; ++i)
      pictures.push_back((*row)[(2 * i + 1) * row->size() / (2 * columns)]);
  return contact_sheet(pictures, columns);
}
}  // namespace tapestry::shell
