#pragma once

#include "../report.hpp"
#include "comparison.hpp"

namespace tapestry::shell {

namespace detail {

/// One column: for each row the share of pictures in which the car is found with the camouflage and with its
/// noises, and the odds between them; of an attention, the share that lies on the car instead. "-" stands for
/// what was not measured, and for odds that cannot be read.
inline Panel comparison_panel(const Comparison& comparison, std::size_t column) {
  std::size_t longest = 15;  // name of a row
  for (const auto& row : comparison.rows) longest = std::max(longest, row.name.size());
  const double left = 25 + 7.5 * static_cast<double>(longest), right = left + 270, top = 34, row_height = 38;
  const auto shown = [&](const ComparedTexture& texture) {
    return comparison.maps_attention ? texture.attention : texture.rate.p_at_50;
  };
  const double bottom = top + row_height * static_cast<double>(comparison.rows.size());
  const auto x = [=](double share) { return left + share * (right - left); };
  std::string svg = svg_text(14, 18, "title", comparison.columns[column]) + share_axis(x, top, bottom);
  for (const auto& [name, cells] : comparison.plain)
    if (name == "clean" && column < cells.size() && cells[column])
      svg += svg_line(x(shown(*cells[column])), top, x(shown(*cells[column])), bottom, "ink");
  if (!comparison.maps_attention) svg += svg_text(right + 14, top - 6, "muted", "odds, times");
  for (std::size_t i = 0; i < comparison.rows.size(); ++i) {
    const auto& row = comparison.rows[i];
    const double middle = top + row_height * (static_cast<double>(i) + 0.5);
    svg += svg_text(left - 8, middle + 4, "end", row.name);
    if (column >= row.cells.size() || !row.cells[column]) {
      svg += svg_text(left + 6, middle + 4, "muted", "- not measured");
      continue;
    }
    const ComparedCell& cell = *row.cells[column];
    const auto bar = [&](double y, const ComparedTexture& texture, const char* style) {
      svg += svg_rectangle(left, middle + y, x(shown(texture)) - left, 9, style);
      if (!comparison.maps_attention) svg += svg_interval(x, texture.rate.interval, middle + y + 4.5);
    };
    bar(-15, cell.camouflage, "class=\"second\"");
    bar(-5, cell.noise, "class=\"third\"");
    if (cell.picture_noise) bar(5, cell.picture_noise->texture, "class=\"first\"");
    if (!comparison.maps_attention)
      svg += svg_text(right + 14, middle + 4, "", odds_text(cell.effect.odds_ratio));
  }
  return {right + (comparison.maps_attention ? 30 : 190), bottom + 26, svg};
}

}  // namespace detail

/// How often the car is found in every row, or how much of the attention lies on it, a panel for each column.
inline Figure comparison_figure(const Comparison& comparison, const std::string& title) {
  Figure figure{
      title,
      {},
      {{{"class=\"second\"", "camouflage"}, {"class=\"third\"", "its matched noise"}},
       comparison.maps_attention
           ? "attention on the car, share of the heat map; the line is the clean car's"
           : "pictures in which the car is found; lines: 95 %, upright the clean car's; odds of being found, "
             "matched noise over camouflage, 95 %: - where they may be below a tenth as well as above ten"},
      2};
  for (std::size_t column = 0; column < comparison.columns.size(); ++column)
    figure.panels.push_back(detail::comparison_panel(comparison, column));
  if (has_picture_noise(comparison))
    figure.legend.keys.emplace_back("class=\"first\"", "noise drawn in each picture");
  return figure;
}

}  // namespace tapestry::shell
