#pragma once
#include "protocol.hpp"
#include "settings.hpp"

namespace tapestry::shell {
/// Results of one texture as rings of distances around the car, seen from above with its front upwards.
class PolarPanel {
 public:
  PolarPanel(const Protocol& protocol, const ProtocolResult& result, std::size_t texture)
      : table_(protocol.table), result_(result), texture_(texture) {}

  [[nodiscard]] Panel draw() {
    const auto& all = result_.sections.front().cell.textures[texture_].rate;
    svg_ = svg_text(middle_x, 18, "title middle", result_.textures[texture_]);
    svg_ += svg_text(middle_x, 34, "muted middle",
                     "found in " + std::to_string(all.detected) + " of " + std::to_string(all.views) +
                         (all.views > 0 ? " (" + fixed(100 * all.p_at_50, 1) + " %)" : ""));
    for (std::size_t row = 0; row < table_.rows.size(); ++row)
      for (std::size_t column = 0; column < table_.columns.size(); ++column) draw_cell(row, column);
    draw_car();
    svg_ += svg_text(middle_x, middle_y - radius - 7, "muted middle", "front, 0°");
    svg_ += svg_text(middle_x, middle_y + radius + 17, "muted middle", "rear, 180°");
    svg_ += svg_text(middle_x - radius - 18, middle_y - 3, "muted middle", "left");
    svg_ += svg_text(middle_x - radius - 18, middle_y + 11, "muted middle", "90°");
    svg_ += svg_text(middle_x + radius + 18, middle_y - 3, "muted middle", "right");
    svg_ += svg_text(middle_x + radius + 18, middle_y + 11, "muted middle", "270°");
    return {width, height, svg_};
  }

  static constexpr double width = 358, height = 390;

 private:
  static constexpr double middle_x = width / 2, middle_y = 212, radius = 132, hole = 27;

  /// A point at a distance from the middle and an azimuth, which grows counter-clockwise.
  [[nodiscard]] static std::string point(double r, double azimuth_deg) {
    const double angle = azimuth_deg * std::numbers::pi / 180;
    return detail::coordinate(middle_x - r * std::sin(angle)) + " " +
           detail::coordinate(middle_y - r * std::cos(angle));
  }

  void draw_cell(std::size_t row, std::size_t column) {
    const auto& cell = result_.cells[row * table_.columns.size() + column];
    const auto& rate = cell.textures[texture_].rate;
    const double ring = (radius - hole) / static_cast<double>(table_.columns.size());
    const double inner = hole + ring * static_cast<double>(column), outer = inner + ring;
    const double sector = 360.0 / static_cast<double>(table_.rows.size());
    const double begin = sector * static_cast<double>(row), end = begin + sector;
    const std::string far = detail::coordinate(outer), near = detail::coordinate(inner);
    svg_ +=
        "<path d=\"M" + point(outer, begin) + "A" + far + " " + far + " 0 0 0 " + point(outer, end) + "L" +
        point(inner, end) + "A" + near + " " + near + " 0 0 1 " + point(inner, begin) + "Z\" " +
        (rate.views > 0 ? "class=\"cell\" fill=\"" + colour_text(rate.p_at_50) + "\"" : "class=\"none\"") +
        "><title>" +
        escaped(result_.textures[texture_] + ", azimuth " + table_.rows[row] + ", distance " +
                table_.columns[column] + ": found in " + std::to_string(rate.detected) + " of " +
                std::to_string(rate.views)) +
        "</title></path>\n";
    const double angle = (begin + end) / 2 * std::numbers::pi / 180, r = (inner + outer) / 2;
    const double aside = column % 2 == 0 ? 4 : -4;  // so that numbers of narrow rings do not touch
    const std::string style = rate.views == 0 ? "muted" : rate.p_at_50 > 0.55 ? "on-light" : "on-dark";
    svg_ += svg_text(middle_x - r * std::sin(angle) - aside * std::cos(angle),
                     middle_y - r * std::cos(angle) + aside * std::sin(angle) + 3.5, "value middle " + style,
                     rate.views > 0 ? fixed(100 * rate.p_at_50, 0) : "-");
  }

  void draw_car() {
    svg_ += svg_rectangle(middle_x - 8, middle_y - 19, 16, 38, "rx=\"5\" class=\"body\"");
    svg_ += svg_rectangle(middle_x - 6, middle_y - 9, 12, 6, "rx=\"2\" class=\"glass\"");
    svg_ += svg_rectangle(middle_x - 5, middle_y + 10, 10, 4, "rx=\"1.5\" class=\"glass\"");
  }

  const evaluate::ProtocolTable& table_;
  const ProtocolResult& result_;
  std::size_t texture_;
  std::string svg_;
};

inline Figure views_figure(const Protocol& protocol, const ProtocolResult& result) {
  const std::string rings = listed(protocol.table.columns);
  Figure figure{
      "Where the detector finds the car",
      {},
      {{},
       "views in which the car is found (P@0.5), per cent; rings, from the middle: distances " + rings,
       {340, 34, share_scale(14, 4, 312)}},
      3};
  for (const std::size_t texture : result.shown_textures())
    figure.panels.push_back(PolarPanel(protocol, result, texture).draw());
  return figure;
}

/// FCA's table 3: where around the car, and how far from it, the detector finds it.
inline Protocol views_protocol(const ProtocolSettings& settings, std::uint64_t, const ProtocolSubject&) {
  const auto grid = settings.quick ? evaluate::ViewGrid::quick() : evaluate::ViewGrid{};
  Protocol protocol{"views", "Views and distances", evaluate::view_table(grid), evaluate::view_frames(grid)};
  protocol.notes = {
      "A cell is 45 degrees of azimuth (0 in front, growing to the car's left) at one distance; a frame is "
      "the car alone before a plain background, every " +
      std::to_string(grid.azimuth_step_deg) + " degrees at " + std::to_string(grid.elevations_deg.size()) +
      " elevations up to " + evaluate::detail::short_number(grid.elevations_deg.back()) + " degrees."};
  protocol.figure = views_figure;
  return protocol;
}
}  // namespace tapestry::shell
