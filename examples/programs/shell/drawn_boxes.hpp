#pragma once
#include <numbers>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/image/colour_space.hpp>
#include "formatted.hpp"
#include "pixel_font.hpp"

namespace tapestry::shell {
/// Colour of a class, the same in every picture. Hues of successive classes lie far apart, in turn bright,
/// pale, deep and dark; the greens about found_colour are left out.
///
///   hue = 150° + 300° · frac(0.7125 + k (√2 − 1))
inline Colour class_colour(std::size_t class_index) {
  constexpr std::array<std::array<double, 2>, 4> saturation_and_value{
      {{0.85, 1}, {0.5, 1}, {0.95, 0.9}, {0.9, 0.6}}};
  const auto [saturation, value] = saturation_and_value[class_index % 4];
  double whole = 0;
  const double share =
      std::modf(0.7125 + static_cast<double>(class_index) * (std::numbers::sqrt2 - 1), &whole);
  const double sector = (150 + 300 * share) / 60;  // of the hexagon red, yellow, green, cyan, blue, magenta
  Colour colour{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double at = std::fmod(5 - 2 * static_cast<double>(c) + sector, 6);
    const double absent = std::clamp(std::min(at, 4 - at), 0.0, 1.0);
    colour[c] = static_cast<std::uint8_t>(std::lround(255 * value * (1 - saturation * absent)));
  }
  return colour;
}

/// Colour of the car's box where the car is found.
inline constexpr Colour found_colour{40, 220, 60};

/// Black or white, whichever contrasts more. Source: WCAG 2.1, relative luminance; above 0.179 black does.
inline Colour text_colour_on(const Colour& background) {
  constexpr std::array<double, 3> weights{0.2126, 0.7152, 0.0722};
  double luminance = 0;
  for (std::size_t c = 0; c < 3; ++c) luminance += weights[c] * image::linearised(background[c] / 255.0);
  return luminance > 0.179 ? Colour{0, 0, 0} : Colour{255, 255, 255};
}

struct LabelledBox {
  detect::Box box{};  ///< pixels of the picture
  std::string label{};
  Colour colour{};
};

/// Name and score, "car 0.93".
inline std::string label_of(const std::string& name, double confidence) {
  return name + formatted(" %.2f", confidence);
}

namespace detail {
/// Whole pixels, right and bottom beyond them.
struct PixelRectangle {
  long left, top, right, bottom;

  [[nodiscard]] bool meets(const PixelRectangle& other) const {
    return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
  }
};

/// The pixels of a box that lie in the picture, at least one a side.
inline PixelRectangle pixels_of(const detect::Box& box, const Bitmap& bitmap) {
  const auto range = [](double first, double last, std::size_t extent) {
    const auto most = static_cast<double>(extent);
    const long from = std::lround(std::clamp(first, 0.0, most - 1));
    return std::array{from, std::max(from + 1, std::lround(std::clamp(last, 0.0, most)))};
  };
  const auto [left, right] = range(box.left(), box.right(), bitmap.shape(1));
  const auto [top, bottom] = range(box.top(), box.bottom(), bitmap.shape(0));
  return {left, top, right, bottom};
}

inline void draw_outline(Bitmap& bitmap, const PixelRectangle& at, long thickness, const Colour& colour) {
  const long across = std::min(thickness, (at.right - at.left + 1) / 2);
  const long down = std::min(thickness, (at.bottom - at.top + 1) / 2);
  fill_rectangle(bitmap, at.left, at.top, at.right, at.top + down, colour);
  fill_rectangle(bitmap, at.left, at.bottom - down, at.right, at.bottom, colour);
  fill_rectangle(bitmap, at.left, at.top, at.left + across, at.bottom, colour);
  fill_rectangle(bitmap, at.right - across, at.top, at.right, at.bottom, colour);
}

/// Place of a label: above its box, inside at the top, below, or inside at the bottom. Takes the first that
/// lies in the picture and meets none of `taken`, else the first that lies in the picture.
inline PixelRectangle label_place(const PixelRectangle& box, long width, long height, const Bitmap& bitmap,
                                  const std::vector<PixelRectangle>& taken) {
  const auto rows = static_cast<long>(bitmap.shape(0)), columns = static_cast<long>(bitmap.shape(1));
  const long left = std::max(0L, std::min(box.left, columns - width));
  const auto from = [&](long top) { return PixelRectangle{left, top, left + width, top + height}; };
  PixelRectangle place = from(std::clamp(box.top, 0L, std::max(0L, rows - height)));
  bool is_first = true;
  for (const long top : {box.top - height, box.top, box.bottom, box.bottom - height}) {
    if (top < 0 || top + height > rows) continue;
    const PixelRectangle candidate = from(top);
    if (std::none_of(taken.begin(), taken.end(), [&](const auto& other) { return candidate.meets(other); }))
      return candidate;
    if (is_first) place = candidate;
    is_first = false;
  }
  return place;
}
}  // namespace detail

/// Draws boxes, cut at the edge of the picture, and labels filled with their boxes' colours.
/// \param boxes  surest first: the surer of two lies on top, and its label is placed first
inline void draw_boxes(Bitmap& bitmap, const std::vector<LabelledBox>& boxes) {
  const auto longer = static_cast<double>(std::max(bitmap.shape(0), bitmap.shape(1)));
  const long scale = std::max(1L, std::lround(longer / 400));  // side of a glyph's pixel
  const long height = (glyph_height + 2) * scale;
  std::vector<detail::PixelRectangle> places;
  for (const auto& box : boxes)
    places.push_back(detail::label_place(detail::pixels_of(box.box, bitmap),
                                         text_width(box.label, scale) + 4 * scale, height, bitmap, places));
  for (std::size_t i = boxes.size(); i-- > 0;)
    detail::draw_outline(bitmap, detail::pixels_of(boxes[i].box, bitmap), 1 + scale, boxes[i].colour);
  for (std::size_t i = boxes.size(); i-- > 0;) {
    const auto& [left, top, right, bottom] = places[i];
    if (boxes[i].label.empty()) continue;
    fill_rectangle(bitmap, left, top, right, bottom, boxes[i].colour);
    draw_text(bitmap, left + 2 * scale, top + scale, boxes[i].label, scale, text_colour_on(boxes[i].colour));
  }
}

/// A picture and the boxes to draw into it, surest first. They stay apart until the picture has its final
/// size, so that labels stay readable.
struct MarkedPicture {
  Bitmap picture{};
  std::vector<LabelledBox> boxes{};
};

/// The mean of every 2 × 2 pixels.
inline Bitmap halved(const Bitmap& picture) {
  Bitmap small(Extents<3>{picture.shape(0) / 2, picture.shape(1) / 2, 3});
  for (std::size_t y = 0; y < small.shape(0); ++y)
    for (std::size_t x = 0; x < small.shape(1); ++x)
      for (std::size_t c = 0; c < 3; ++c)
        small(y, x, c) =
            static_cast<std::uint8_t>((picture(2 * y, 2 * x, c) + picture(2 * y + 1, 2 * x, c) +
                                       picture(2 * y, 2 * x + 1, c) + picture(2 * y + 1, 2 * x + 1, c) + 2) /
                                      4);
  return small;
}

inline MarkedPicture halved(const MarkedPicture& marked) {
  MarkedPicture small{halved(marked.picture), marked.boxes};
  for (auto& [box, label, colour] : small.boxes) box = {box.cx / 2, box.cy / 2, box.w / 2, box.h / 2};
  return small;
}

inline const Bitmap& drawn(const Bitmap& bitmap) { return bitmap; }
inline const Bitmap& bitmap_of(const Bitmap& bitmap) { return bitmap; }
inline const Bitmap& bitmap_of(const MarkedPicture& marked) { return marked.picture; }

inline Bitmap drawn(const MarkedPicture& marked) {
  Bitmap bitmap = marked.picture;
  draw_boxes(bitmap, marked.boxes);
  return bitmap;
}
}  // namespace tapestry::shell
