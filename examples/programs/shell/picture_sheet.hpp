#pragma once
#include <tapestry/image/resize.hpp>
#include "contact_sheet.hpp"

namespace tapestry::shell {
/// Shrinks a picture and its boxes until no side is longer than `side` pixels.
inline MarkedPicture fitted_within(MarkedPicture marked, std::size_t side) {
  const auto longer = [&] { return std::max(marked.picture.shape(0), marked.picture.shape(1)); };
  const auto shorter = [&] { return std::min(marked.picture.shape(0), marked.picture.shape(1)); };
  while (longer() >= 2 * side && shorter() >= 2) marked = halved(marked);
  if (longer() <= side) return marked;
  const double rows = static_cast<double>(marked.picture.shape(0));
  const double columns = static_cast<double>(marked.picture.shape(1));
  const auto shrunk = [scale = static_cast<double>(side) / static_cast<double>(longer())](double extent) {
    return std::max<std::size_t>(1, static_cast<std::size_t>(std::lround(scale * extent)));
  };
  marked.picture = image::to_bytes(
      image::resize_bilinear(image::from_bytes<float>(marked.picture), shrunk(rows), shrunk(columns)));
  const double down = static_cast<double>(marked.picture.shape(0)) / rows;
  const double across = static_cast<double>(marked.picture.shape(1)) / columns;
  for (auto& [box, label, colour] : marked.boxes)
    box = {across * box.cx, down * box.cy, across * box.w, down * box.h};
  return marked;
}

/// A sheet of pictures of any extents with their boxes, each under its name.
class PictureSheet {
 public:
  /// \param pictures  how many there are; of more than 160, evenly spread ones are shown
  /// \param columns   0: as many as fit the pictures
  explicit PictureSheet(std::size_t pictures, std::size_t columns = 0)
      : pictures_(pictures),
        shown_(std::min(pictures, most_)),
        columns_(columns > 0 ? columns : sheet_columns(shown_)),
        side_(columns_ > 3 ? 320 : 640) {}

  [[nodiscard]] bool shows(std::size_t index) const {
    return shown_ > 0 && is_shown(index, shown_, pictures_);
  }
  [[nodiscard]] std::size_t side() const { return side_; }

  /// \param marked  of fitted_within(…, side())
  void add(std::string name, MarkedPicture marked) {
    cells_.emplace_back(std::move(name), std::move(marked));
  }
  [[nodiscard]] std::size_t count() const { return cells_.size(); }

  /// White where there is no picture.
  [[nodiscard]] Bitmap bitmap() const {
    constexpr std::size_t name_height = glyph_height + 4;
    std::size_t width = 1;
    for (const auto& cell : cells_) width = std::max(width, cell.second.picture.shape(1));
    const std::size_t characters = std::max<std::size_t>(1, width / static_cast<std::size_t>(glyph_advance));
    std::vector<Bitmap> named;
    for (const auto& [name, marked] : cells_) {
      const Bitmap picture = drawn(marked);
      named.push_back(filled<std::uint8_t, 3>({name_height + picture.shape(0), width, 3}, std::uint8_t(255)));
      draw_text(named.back(), 0, 2, name.substr(0, characters), 1, {0, 0, 0});
      for (std::size_t y = 0; y < picture.shape(0); ++y)
        std::copy_n(&picture(y, 0, 0), 3 * picture.shape(1), &named.back()(name_height + y, 0, 0));
    }
    return contact_sheet(named, columns_);
  }

 private:
  static constexpr std::size_t most_ = 160;
  std::size_t pictures_, shown_, columns_, side_;
  std::vector<std::pair<std::string, MarkedPicture>> cells_;
};
}  // namespace tapestry::shell
