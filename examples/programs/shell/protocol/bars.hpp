#pragma once
#include "protocol.hpp"

namespace tapestry::shell {
inline constexpr std::array<const char*, 4> bar_styles{"first", "second", "third", "fourth"};

/// Style of a texture's bar: clean, the camouflage, matched noise and unpainted.
inline std::string bar_style(const ProtocolResult& result, std::size_t texture) {
  const std::size_t style = result.is_bare(texture) ? bar_styles.size() - 1 : texture;
  return std::string("class=\"") + bar_styles[style] + "\"";
}

/// Cells of a table that a panel shows: some rows of one column.
struct BarCells {
  std::size_t column = 0;
  std::size_t first_row = 0;
  std::size_t row_count = 0;
  std::string title;
};

/// Bars of the textures for every row, with their intervals.
/// \param words_of  returns the two lines of text under the bars, from a row and its cell
template <class WordsOf>
Panel bar_panel(const Protocol& protocol, const ProtocolResult& result, const BarCells& shown_cells,
                WordsOf words_of) {
  constexpr double left = 52, right = 330, top = 40, bottom = 190;
  const auto& table = protocol.table;
  const auto y = [=](double share) { return bottom - share * (bottom - top); };
  std::string svg = svg_text(14, 18, "title", shown_cells.title);
  for (int tick = 0; tick <= 4; ++tick) {
    svg += svg_line(left, y(tick / 4.0), right, y(tick / 4.0), tick == 0 ? "ink" : "grid");
    svg += svg_text(left - 6, y(tick / 4.0) + 4, "muted end",
                    std::to_string(25 * tick) + (tick == 4 ? " %" : ""));
  }
  const auto shown = result.shown_textures();
  const double group_width = (right - left) / static_cast<double>(shown_cells.row_count);
  const double bar_width = 0.8 * group_width / static_cast<double>(shown.size());
  for (std::size_t group = 0; group < shown_cells.row_count; ++group) {
    const std::size_t row = shown_cells.first_row + group;
    const auto& cell = result.cells[row * table.columns.size() + shown_cells.column];
    const double group_left = left + group_width * (static_cast<double>(group) + 0.1);
    for (std::size_t i = 0; i < shown.size(); ++i) {
      const auto& rate = cell.textures[shown[i]].rate;
      const double x = group_left + bar_width * static_cast<double>(i), middle = x + bar_width / 2 - 1;
      if (rate.views == 0) {
        svg += svg_text(middle, bottom - 4, "muted middle", "-");
        continue;
      }
      svg += svg_rectangle(x, y(rate.p_at_50), bar_width - 2, bottom - y(rate.p_at_50),
                           bar_style(result, shown[i]));
      const double low = y(rate.interval[0]), high = y(rate.interval[1]), from = middle - 3, to = middle + 3;
      svg += svg_strokes({{middle, low}, {middle, high}, {from, low}, {to, low}, {from, high}, {to, high}},
                         "ink");
    }
    const double middle = left + group_width * (static_cast<double>(group) + 0.5);
    const auto [words, muted] = words_of(row, cell);
    svg += svg_text(middle, bottom + 17, "middle", words);
    svg += svg_text(middle, bottom + 32, "muted middle", muted);
  }
  return {350, 236, svg};
}

inline Legend bar_legend(const ProtocolResult& result) {
  Legend legend{{}, "bars: frames in which the car is found (P@0.5); lines: 95 % intervals (Wilson)"};
  for (const std::size_t texture : result.shown_textures())
    legend.keys.emplace_back(bar_style(result, texture), result.textures[texture]);
  return legend;
}
}  // namespace tapestry::shell
