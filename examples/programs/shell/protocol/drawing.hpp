#pragma once
#include <algorithm>
#include "../formatted.hpp"

namespace tapestry::shell {
/// A part of a figure, in its own coordinates.
struct Panel {
  double width = 0;
  double height = 0;
  std::string svg;
};

/// Explanation of a figure.
struct Legend {
  std::vector<std::pair<std::string, std::string>> keys{};  ///< style of a mark, and its words
  std::string words{};                                      ///< below the keys
  Panel further{};                                          ///< below both
};

/// Panels side by side, as many as fit, below a legend.
struct Figure {
  std::string title;
  std::vector<Panel> panels;
  Legend legend;
  std::size_t columns = 1;  ///< of panels, in a separate picture; a page wraps them
};

/// Colours for light and dark pages. Text on a coloured cell has the same colour on both.
inline constexpr const char* figure_style = R"(svg text { font: 12px sans-serif; fill: #24292f }
svg .heading { font-size: 15px; font-weight: bold } svg .title { font-size: 13px; font-weight: bold }
svg .muted { fill: #57606a } svg .middle { text-anchor: middle } svg .end { text-anchor: end }
svg .value { font-size: 9px } svg .on-dark { fill: #fff } svg .on-light { fill: #14181d }
svg .paper { fill: #fff } svg .cell { stroke: #fff; stroke-width: 1 }
svg .none { fill: #eceff2; stroke: #fff } svg .ink { stroke: #24292f; fill: none }
svg .grid { stroke: #d8dee4; fill: none }
svg .body { fill: #8c959f } svg .glass { fill: #fff }
svg .first { fill: #8c959f } svg .second { fill: #d1730c } svg .third { fill: #2f81c7 }
svg .fourth { fill: #fff; stroke: #57606a }
@media (prefers-color-scheme: dark) {
svg text { fill: #e6edf3 } svg .muted { fill: #9da7b3 }
svg .on-dark { fill: #fff } svg .on-light { fill: #14181d }
svg .paper { fill: #0d1117 } svg .cell { stroke: #0d1117 } svg .none { fill: #21262d; stroke: #0d1117 }
svg .ink { stroke: #e6edf3 } svg .grid { stroke: #30363d } svg .glass { fill: #0d1117 }
svg .fourth { fill: #0d1117; stroke: #9da7b3 }
}
)";

namespace detail {
inline std::string coordinate(double value) { return fixed(value, 2); }
}  // namespace detail

/// Text for a page or a drawing, with special characters escaped.
inline std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<'   ? "&lt;"
           : c == '>' ? "&gt;"
           : c == '&' ? "&amp;"
           : c == '"' ? "&quot;"
                      : std::string(1, c);
  return out;
}

inline std::string svg_text(double x, double y, const std::string& style, const std::string& words) {
  return "<text x=\"" + detail::coordinate(x) + "\" y=\"" + detail::coordinate(y) + "\" class=\"" + style +
         "\">" + escaped(words) + "</text>\n";
}

/// A line through pairs of points: from, to, from, to.
inline std::string svg_strokes(const std::vector<std::array<double, 2>>& points, const std::string& style) {
  std::string path;
  for (std::size_t i = 0; i < points.size(); ++i)
    path +=
        (i % 2 == 0 ? "M" : "L") + detail::coordinate(points[i][0]) + " " + detail::coordinate(points[i][1]);
  return "<path d=\"" + path + "\" class=\"" + style + "\"/>\n";
}

inline std::string svg_line(double x1, double y1, double x2, double y2, const std::string& style) {
  return svg_strokes({{x1, y1}, {x2, y2}}, style);
}

/// Text from y on, broken at spaces into lines of at most a width; y moves to the line below.
/// \param style  heading, or one of the usual size
inline std::string svg_lines(double x, double& y, double width, const std::string& style,
                             const std::string& words) {
  const double letter = style == "heading" ? 9.5 : 6.5, line = style == "heading" ? 20 : 16;
  const auto most = static_cast<std::size_t>(width / letter);
  std::string svg;
  for (std::size_t begin = 0; begin < words.size(); y += line) {
    std::size_t end = begin + most < words.size() ? words.rfind(' ', begin + most) : words.size();
    if (end == std::string::npos || end <= begin) end = std::min(words.find(' ', begin + 1), words.size());
    svg += svg_text(x, y, style, words.substr(begin, end - begin));
    begin = end + 1;
  }
  return svg;
}

/// Upright lines at quarters from 0 to 1, with their numbers below. \param x  returns the place of a share
template <class Place>
std::string share_axis(Place x, double top, double bottom) {
  std::string svg;
  for (int tick = 0; tick <= 4; ++tick)
    svg += svg_line(x(tick / 4.0), top, x(tick / 4.0), bottom, tick == 0 ? "ink" : "grid") +
           svg_text(x(tick / 4.0), bottom + 16, "muted middle",
                    std::to_string(25 * tick) + (tick == 4 ? " %" : ""));
  return svg;
}

/// A level interval with a stroke at each end.
/// \param x  returns the place of a share
template <class Place>
std::string svg_interval(Place x, const std::array<double, 2>& interval, double y) {
  const double low = x(interval[0]), high = x(interval[1]);
  return svg_strokes({{low, y}, {high, y}, {low, y - 3}, {low, y + 3}, {high, y - 3}, {high, y + 3}}, "ink");
}

inline std::string svg_rectangle(double x, double y, double width, double height,
                                 const std::string& attributes) {
  return "<rect x=\"" + detail::coordinate(x) + "\" y=\"" + detail::coordinate(y) + "\" width=\"" +
         detail::coordinate(width) + "\" height=\"" + detail::coordinate(height) + "\" " + attributes +
         "/>\n";
}

/// The colours of the shares 0, ¼, ½, ¾ and 1: dark blue to pale yellow, lighter all the way.
inline constexpr std::array<std::array<double, 3>, 5> share_stops{
    {{43, 48, 99}, {38, 92, 128}, {41, 138, 133}, {126, 187, 106}, {247, 226, 122}}};

inline std::string colour_text(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (share_stops.size() - 1);
  const std::size_t first = std::min(static_cast<std::size_t>(at), share_stops.size() - 2);
  const double part = at - static_cast<double>(first);
  std::string text;
  for (std::size_t c = 0; c < 3; ++c)
    text += (c == 0 ? "rgb(" : ",") +
            fixed(share_stops[first][c] + part * (share_stops[first + 1][c] - share_stops[first][c]), 0);
  return text + ")";
}

/// A scale of the colours of shares, with its ends.
inline std::string share_scale(double left, double top, double width) {
  std::string svg = "<linearGradient id=\"shares\">";
  for (const double share : {0.0, 0.25, 0.5, 0.75, 1.0})
    svg += "<stop offset=\"" + detail::coordinate(share) + "\" stop-color=\"" + colour_text(share) + "\"/>";
  svg += "</linearGradient>\n" + svg_rectangle(left, top, width, 12, "fill=\"url(#shares)\"");
  for (int tick = 0; tick <= 4; ++tick) {
    const char* anchor = tick == 0 ? "muted" : tick == 4 ? "muted end" : "muted middle";
    svg += svg_text(left + width * tick / 4, top + 27, anchor,
                    std::to_string(25 * tick) + (tick == 4 ? " %" : ""));
  }
  return svg;
}

/// The beginning of a drawing with its size, which viewers need beside the viewBox.
inline std::string svg_begin(double width, double height, const std::string& attributes) {
  const std::string w = detail::coordinate(width), h = detail::coordinate(height);
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + w + " " + h + "\" width=\"" + w +
         "\" height=\"" + h + "\" role=\"img\" " + attributes + ">\n";
}

/// A legend as a panel of this width, with as many keys beside each other as fit.
inline Panel legend_panel(const Legend& legend, double width) {
  double x = 14, y = 18;
  std::string svg;
  for (const auto& [style, words] : legend.keys) {
    const double end = x + 18 + 7 * static_cast<double>(words.size());
    if (end > width && x > 14) x = 14, y += 20;
    svg += svg_rectangle(x, y - 10, 12, 12, style) + svg_text(x + 18, y, "", words);
    x += 40 + 7 * static_cast<double>(words.size());
  }
  if (!legend.keys.empty()) y += 20;
  svg += svg_lines(14, y, width - 28, "muted", legend.words);
  svg +=
      "<g transform=\"translate(0 " + detail::coordinate(y - 16) + ")\">\n" + legend.further.svg + "</g>\n";
  return {width, y - 8 + legend.further.height, svg};
}

/// The figure as a separate picture.
inline std::string figure_svg(const Figure& figure) {
  const double cell_width = figure.panels.empty() ? 0 : figure.panels.front().width;
  const double cell_height = figure.panels.empty() ? 0 : figure.panels.front().height;
  const std::size_t columns = std::max<std::size_t>(1, std::min(figure.columns, figure.panels.size()));
  const std::size_t rows = (figure.panels.size() + columns - 1) / columns;
  const double width = std::max(static_cast<double>(columns) * cell_width, figure.legend.further.width);
  double y = 22;
  const std::string heading = svg_lines(14, y, width - 28, "heading", figure.title);
  const Panel legend = legend_panel(figure.legend, width);
  const double legend_top = y - 14, panels_top = legend_top + legend.height;
  std::string svg = svg_begin(width, panels_top + static_cast<double>(rows) * cell_height,
                              "aria-label=\"" + escaped(figure.title) + "\"") +
                    "<style>\n" + figure_style +
                    "</style>\n<rect width=\"100%\" height=\"100%\" class=\"paper\"/>\n" + heading;
  const auto place = [&](double left, double top, const Panel& panel) {
    svg += "<g transform=\"translate(" + detail::coordinate(left) + " " + detail::coordinate(top) + ")\">\n" +
           panel.svg + "</g>\n";
  };
  place(0, legend_top, legend);
  for (std::size_t i = 0; i < figure.panels.size(); ++i)
    place(cell_width * static_cast<double>(i % columns),
          panels_top + cell_height * static_cast<double>(i / columns), figure.panels[i]);
  return svg + "</svg>\n";
}

/// The figure as part of a page, whose style must hold figure_style: panels wrap where the page is narrow.
inline std::string figure_html(const Figure& figure) {
  constexpr double of_telephone = 358;
  const auto drawing = [&](const Panel& panel) {
    return svg_begin(panel.width, panel.height, "aria-label=\"" + escaped(figure.title) + "\"") + panel.svg +
           "</svg>\n";
  };
  std::string html = drawing(legend_panel(figure.legend, of_telephone)) + "<div class=\"panels\">\n";
  for (const Panel& panel : figure.panels) html += drawing(panel);
  return html + "</div>\n";
}
}  // namespace tapestry::shell
