#pragma once
#include <cmath>
#include "formatted.hpp"
#include "pdf_file.hpp"

/// \file Additions to the content of a printed sheet: marks to cut at, a ruler, and colours to measure.

namespace tapestry::shell {
/// A size of paper, centimetres, upright.
struct Paper {
  const char* name;
  double width, height;
};

inline constexpr std::array papers{Paper{"a4", 21, 29.7}, Paper{"a3", 29.7, 42}, Paper{"a0", 84.1, 118.9},
                                   Paper{"letter", 21.59, 27.94}};

inline const char* name_of(const Paper& paper) { return paper.name; }

inline constexpr double margin_cm = 1, band_cm = 1.8, overlap_cm = 1;

/// The tiles of a panel, in rows from the top.
struct TileGrid {
  double paper_width = 0, paper_height = 0;  ///< the paper may lie on its side
  double columns = 1, rows = 1;              ///< whole numbers, of any size

  /// The part of the page that shows the panel.
  [[nodiscard]] PageBox window() const {
    return {margin_cm, margin_cm + band_cm, paper_width - 2 * margin_cm,
            paper_height - 2 * margin_cm - band_cm};
  }
};

inline TileGrid tile_grid(double width_cm, double height_cm, double paper_width, double paper_height) {
  TileGrid grid{paper_width, paper_height};
  const auto count = [](double side, double window) {
    return std::max(1.0, std::ceil((side - overlap_cm) / (window - overlap_cm) - 1e-9));
  };
  grid.columns = count(width_cm, grid.window().width);
  grid.rows = count(height_cm, grid.window().height);
  return grid;
}

/// Marks in the margin: at the window's corners, where the tile is cut, and a step inside, where the cut
/// edge of the next tile lies.
inline void draw_marks(PdfPage& page, const TileGrid& grid, const std::array<std::size_t, 2>& tile) {
  const PageBox window = grid.window();
  const double right = window.left + window.width, top = window.bottom + window.height;
  constexpr double near = 0.1, far = 0.45, step = overlap_cm;
  const auto mark_column = [&](double x) {
    page.line({x, window.bottom - far}, {x, window.bottom - near});
    page.line({x, top + near}, {x, top + far});
  };
  const auto mark_row = [&](double y) {
    page.line({window.left - far, y}, {window.left - near, y});
    page.line({right + near, y}, {right + far, y});
  };
  for (const double x : {window.left, right}) mark_column(x);
  for (const double y : {window.bottom, top}) mark_row(y);
  if (tile[1] > 0) mark_column(window.left + step);
  if (static_cast<double>(tile[1] + 1) < grid.columns) mark_column(right - step);
  if (tile[0] > 0) mark_row(top - step);
  if (static_cast<double>(tile[0] + 1) < grid.rows) mark_row(window.bottom + step);
}

/// Five centimetres, to check the scale of the print.
inline void draw_ruler(PdfPage& page) {
  constexpr double y = 1.4, left = margin_cm;
  page.line({left, y}, {left + 5, y});
  for (int cm = 0; cm <= 5; ++cm) page.line({left + cm, y - 0.15}, {left + cm, y + 0.15});
  page.text({left + 5.1, y - 0.1}, 7, "5 cm");
}

/// Colours of known sRGB values, which a measurement of the print compares with.
inline void draw_colours(PdfPage& page) {
  constexpr std::array colours{0x00FFFF, 0xFF00FF, 0xFFFF00, 0xFF0000, 0x00FF00, 0x0000FF,
                               0x000000, 0x404040, 0x808080, 0xC0C0C0, 0xFFFFFF};
  constexpr double left = 7.6, bottom = 1.25, width = 1.05, height = 0.55;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const int r = colours[i] / 0x10000, g = colours[i] / 0x100 % 0x100, b = colours[i] % 0x100;
    const double x = left + width * static_cast<double>(i);
    page.area({x, bottom, width, height}, {r / 255.0, g / 255.0, b / 255.0});
    page.text({x + 0.05, 1.0}, 5, formatted("%d %d %d", r, g, b));
  }
  const double right = left + width * static_cast<double>(colours.size());
  page.line({left, bottom}, {right, bottom}, 0.3);
  page.line({left, bottom + height}, {right, bottom + height}, 0.3);
  page.line({right, bottom}, {right, bottom + height}, 0.3);
}
}  // namespace tapestry::shell
