#pragma once
#include <string_view>
#include <tapestry/core/array.hpp>

/// \file
/// Text in pictures, in a font of our own: each glyph is five pixels wide, seven high and two more where it
/// goes below the line, and is drawn as it stands or with each of its pixels as a square of several.

namespace tapestry::shell {
using Bitmap = Array<std::uint8_t, 3>;  // [H, W, 3], RGB
using Colour = std::array<std::uint8_t, 3>;

inline constexpr long glyph_width = 5, glyph_height = 9, glyph_advance = glyph_width + 1;

namespace detail {
/// Printable ASCII from the space on, then a box for what is none: rows of five pixels from the top, each
/// after a space.
// clang-format off
inline constexpr std::array<std::string_view, 96> glyphs{
    "", "..#.. ..#.. ..#.. ..#.. ..#.. ..... ..#..",  // space !
    ".#.#. .#.#. .#.#.", ".#.#. .#.#. ##### .#.#. ##### .#.#. .#.#.",  // " #
    "..#.. .#### #.#.. .###. ..#.# ####. ..#..", "##..# ##..# ...#. ..#.. .#... #..## #..##",  // $ %
    ".##.. #..#. #..#. .##.. #.#.# #..#. .##.#", "..#.. ..#.. .#...",  // & '
    "...#. ..#.. .#... .#... .#... ..#.. ...#.", ".#... ..#.. ...#. ...#. ...#. ..#.. .#...",  // ( )
    "..... ..#.. #.#.# .###. #.#.# ..#..", "..... ..#.. ..#.. ##### ..#.. ..#..",  // * +
    "..... ..... ..... ..... ..... .##.. ..#.. .#...", "..... ..... ..... .###.",  // , -
    "..... ..... ..... ..... ..... .##.. .##..", "....# ....# ...#. ..#.. .#... #.... #....",  // . /
    ".###. #...# #..## #.#.# ##..# #...# .###.", "..#.. .##.. ..#.. ..#.. ..#.. ..#.. .###.",  // 0 1
    ".###. #...# ....# ...#. ..#.. .#... #####", ".###. #...# ....# ..##. ....# #...# .###.",  // 2 3
    "...#. ..##. .#.#. #..#. ##### ...#. ...#.", "##### #.... ####. ....# ....# #...# .###.",  // 4 5
    "..##. .#... #.... ####. #...# #...# .###.", "##### ....# ...#. ..#.. ..#.. .#... .#...",  // 6 7
    ".###. #...# #...# .###. #...# #...# .###.", ".###. #...# #...# .#### ....# ...#. .##..",  // 8 9
    "..... .##.. .##.. ..... .##.. .##..", "..... .##.. .##.. ..... .##.. ..#.. .#...",  // : ;
    "...#. ..#.. .#... #.... .#... ..#.. ...#.", "..... ..... ##### ..... #####",  // < =
    ".#... ..#.. ...#. ....# ...#. ..#.. .#...", ".###. #...# ....# ...#. ..#.. ..... ..#..",  // > ?
    ".###. #...# #.### #.#.# #.### #.... .###.", ".###. #...# #...# ##### #...# #...# #...#",  // @ A
    "####. #...# #...# ####. #...# #...# ####.", ".###. #...# #.... #.... #.... #...# .###.",  // B C
    "####. #...# #...# #...# #...# #...# ####.", "##### #.... #.... ####. #.... #.... #####",  // D E
    "##### #.... #.... ####. #.... #.... #....", ".###. #...# #.... #.### #...# #...# .####",  // F G
    "#...# #...# #...# ##### #...# #...# #...#", ".###. ..#.. ..#.. ..#.. ..#.. ..#.. .###.",  // H I
    "..### ...#. ...#. ...#. ...#. #..#. .##..", "#...# #..#. #.#.. ##... #.#.. #..#. #...#",  // J K
    "#.... #.... #.... #.... #.... #.... #####", "#...# ##.## #.#.# #.#.# #...# #...# #...#",  // L M
    "#...# ##..# ##..# #.#.# #..## #..## #...#", ".###. #...# #...# #...# #...# #...# .###.",  // N O
    "####. #...# #...# ####. #.... #.... #....", ".###. #...# #...# #...# #.#.# #..#. .##.#",  // P Q
    "####. #...# #...# ####. #.#.. #..#. #...#", ".#### #.... #.... .###. ....# ....# ####.",  // R S
    "##### ..#.. ..#.. ..#.. ..#.. ..#.. ..#..", "#...# #...# #...# #...# #...# #...# .###.",  // T U
    "#...# #...# #...# #...# #...# .#.#. ..#..", "#...# #...# #...# #.#.# #.#.# ##.## #...#",  // V W
    "#...# #...# .#.#. ..#.. .#.#. #...# #...#", "#...# #...# .#.#. ..#.. ..#.. ..#.. ..#..",  // X Y
    "##### ....# ...#. ..#.. .#... #.... #####", ".###. .#... .#... .#... .#... .#... .###.",  // Z [
    "#.... #.... .#... ..#.. ...#. ....# ....#", ".###. ...#. ...#. ...#. ...#. ...#. .###.",  // backslash ]
    "..#.. .#.#. #...#", "..... ..... ..... ..... ..... ..... ..... #####",  // ^ _
    ".#... ..#..", "..... ..... .###. ....# .#### #...# .####",  // ` a
    "#.... #.... ####. #...# #...# #...# ####.", "..... ..... .###. #...# #.... #...# .###.",  // b c
    "....# ....# .#### #...# #...# #...# .####", "..... ..... .###. #...# ##### #.... .###.",  // d e
    "..##. .#..# .#... ###.. .#... .#... .#...",  // f
    "..... ..... .#### #...# #...# #...# .#### ....# .###.",  // g
    "#.... #.... #.##. ##..# #...# #...# #...#", "..#.. ..... .##.. ..#.. ..#.. ..#.. .###.",  // h i
    "...#. ..... ..##. ...#. ...#. ...#. ...#. #..#. .##..",  // j
    "#.... #.... #..#. #.#.. ##... #.#.. #..#.", ".##.. ..#.. ..#.. ..#.. ..#.. ..#.. .###.",  // k l
    "..... ..... ##.#. #.#.# #.#.# #.#.# #.#.#", "..... ..... #.##. ##..# #...# #...# #...#",  // m n
    "..... ..... .###. #...# #...# #...# .###.",  // o
    "..... ..... ####. #...# #...# #...# ####. #.... #....",  // p
    "..... ..... .#### #...# #...# #...# .#### ....# ....#",  // q
    "..... ..... #.##. ##..# #.... #.... #....", "..... ..... .#### #.... .###. ....# ####.",  // r s
    ".#... .#... ###.. .#... .#... .#..# ..##.", "..... ..... #...# #...# #...# #..## .##.#",  // t u
    "..... ..... #...# #...# #...# .#.#. ..#..", "..... ..... #...# #...# #.#.# #.#.# .#.#.",  // v w
    "..... ..... #...# .#.#. ..#.. .#.#. #...#",  // x
    "..... ..... #...# #...# #...# #..## .##.# ....# .###.",  // y
    "..... ..... ##### ...#. ..#.. .#... #####", "...#. ..#.. ..#.. .#... ..#.. ..#.. ...#.",  // z {
    "..#.. ..#.. ..#.. ..#.. ..#.. ..#.. ..#.. ..#.. ..#..",  // |
    ".#... ..#.. ..#.. ...#. ..#.. ..#.. .#...", "..... ..... .##.# #..#.",  // } ~
    "##### #...# #...# #...# #...# #...# #####"};  // any other
// clang-format on

inline bool continues_character(unsigned char byte) { return (byte & 0xC0U) == 0x80U; }
}  // namespace detail

/// Fills the part of a rectangle that lies in the picture; right and bottom lie beyond it.
inline void fill_rectangle(Bitmap& bitmap, long left, long top, long right, long bottom,
                           const Colour& colour) {
  right = std::min(right, static_cast<long>(bitmap.shape(1)));
  bottom = std::min(bottom, static_cast<long>(bitmap.shape(0)));
  for (long y = std::max(top, 0L); y < bottom; ++y)
    for (long x = std::max(left, 0L); x < right; ++x)
      std::ranges::copy(colour, &bitmap(static_cast<std::size_t>(y), static_cast<std::size_t>(x), 0));
}

/// Columns that a text takes.
/// \param scale  side of a glyph's pixel in pixels of the picture
inline long text_width(std::string_view text, long scale) {
  const auto characters = static_cast<long>(std::ranges::count_if(
      text, [](char c) { return !detail::continues_character(static_cast<unsigned char>(c)); }));
  return characters == 0 ? 0 : (glyph_advance * characters - 1) * scale;
}

/// Draws the part of a text, UTF-8, that lies in the picture; each character outside ASCII becomes a box.
inline void draw_text(Bitmap& bitmap, long left, long top, std::string_view text, long scale,
                      const Colour& colour) {
  for (const char c : text) {
    if (detail::continues_character(static_cast<unsigned char>(c))) continue;
    const std::string_view rows =
        c < 0x20 || c > 0x7E ? detail::glyphs.back() : detail::glyphs[static_cast<std::size_t>(c - 0x20)];
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const long x = left + static_cast<long>(i % 6) * scale, y = top + static_cast<long>(i / 6) * scale;
      if (rows[i] == '#') fill_rectangle(bitmap, x, y, x + scale, y + scale, colour);
    }
    left += glyph_advance * scale;
  }
}
}  // namespace tapestry::shell
