#pragma once
#include <tapestry/io/atomic_file.hpp>
#include "../../examples/programs/shell/protocol/drawing.hpp"

namespace tapestry::benchmarks {
struct Point {
  std::string label;
  double error, speed;
  bool is_peer;
};

/// One comparison, drawn as speed (upwards) against error (to the right, logarithmic).
struct Panel {
  std::string title, subtitle;
  std::vector<Point> points{};
  bool is_speed_logarithmic = false;
};

/// The points that no other one beats in both respects, from the smallest error on.
[[nodiscard]] inline std::vector<Point> pareto_front(std::vector<Point> points) {
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) {
    return a.error != b.error ? a.error < b.error : a.speed > b.speed;
  });
  std::vector<Point> front;
  for (const Point& point : points)
    if (front.empty() || point.speed > front.back().speed) front.push_back(point);
  return front;
}

namespace detail {
[[nodiscard]] inline std::string power_of_ten(int exponent) {
  static const std::vector<std::string> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = exponent < 0 ? "10⁻" : "10";
  for (const char digit : std::to_string(std::abs(exponent)))
    text += digits[static_cast<std::size_t>(digit - '0')];
  return text;
}

/// 1, 2 or 5 times a power of ten: the smallest that cuts `range` into at most `parts`.
[[nodiscard]] inline double round_step(double range, int parts) {
  const double power = std::pow(10, std::floor(std::log10(range / parts)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (range <= factor * power * parts) return factor * power;
  return 10 * power;
}

[[nodiscard]] inline std::string dot(double x, double y, const std::string& style) {
  return "<circle cx=\"" + shell::fixed(x, 1) + "\" cy=\"" + shell::fixed(y, 1) + "\" r=\"4\" class=\"" +
         style + "\"/>\n";
}

/// Draws one panel.
class PanelDrawing {
 public:
  static constexpr double width = 340, height = 262;

  explicit PanelDrawing(const Panel& panel) : panel_(panel) {
    double least = 1, most = 0;
    for (const Point& point : panel.points) {
      least = std::min(least, point.error);
      most = std::max(most, point.error);
      largest_speed_ = std::max(largest_speed_, point.speed);
    }
    first_decade_ = static_cast<int>(std::floor(std::log10(least / 1.3)));
    last_decade_ = std::max(static_cast<int>(std::ceil(std::log10(most * 1.3))), first_decade_ + 1);
    step_ = round_step(largest_speed_, 4);
    top_speed_ = step_ * std::ceil(largest_speed_ * 1.08 / step_);
    if (!panel.is_speed_logarithmic) return;
    double smallest_speed = largest_speed_;
    for (const Point& point : panel.points) smallest_speed = std::min(smallest_speed, point.speed);
    bottom_decade_ = static_cast<int>(std::floor(std::log10(smallest_speed / 1.3)));
    top_decade_ = std::max(static_cast<int>(std::ceil(std::log10(largest_speed_ * 1.3))), bottom_decade_ + 1);
  }

  [[nodiscard]] std::string svg() {
    text(14, 12, "title", panel_.title);
    text(14, 26, "muted", panel_.subtitle);
    draw_axes();
    draw_front();
    draw_points();
    return svg_;
  }

 private:
  static constexpr double plot_left = 44, plot_right = 14, plot_top = 40;
  static constexpr double bottom = height - 40;  ///< where the axis of errors lies

  [[nodiscard]] double x(double error) const {
    const double part = (std::log10(error) - first_decade_) / (last_decade_ - first_decade_);
    return plot_left + part * (width - plot_left - plot_right);
  }
  [[nodiscard]] double y(double speed) const {
    const double part = panel_.is_speed_logarithmic
                            ? (std::log10(speed) - bottom_decade_) / (top_decade_ - bottom_decade_)
                            : speed / top_speed_;
    return bottom - part * (bottom - plot_top);
  }

  void text(double x, double y, const std::string& style, const std::string& words) {
    svg_ += shell::svg_text(x, y, style, words);
  }
  void line(double x1, double y1, double x2, double y2, const char* style) {
    svg_ += shell::svg_line(x1, y1, x2, y2, style);
  }

  void draw_axes() {
    constexpr double right = width - plot_right;
    if (panel_.is_speed_logarithmic) {
      for (int decade = bottom_decade_; decade <= top_decade_; ++decade)
        draw_speed(std::pow(10, decade), power_of_ten(decade), decade == bottom_decade_);
    } else {
      for (double speed = 0; speed <= top_speed_ * 1.001; speed += step_)
        draw_speed(speed, shell::formatted("%g", speed), speed == 0);
    }
    const int label_step = (last_decade_ - first_decade_ + 5) / 6;  // labels that do not touch
    for (int decade = first_decade_; decade <= last_decade_; ++decade) {
      const double at = x(std::pow(10, decade));
      line(at, plot_top, at, bottom, "grid");
      if ((decade - first_decade_) % label_step == 0)
        text(at, bottom + 15, "muted middle", power_of_ten(decade));
    }
    text((plot_left + right) / 2, bottom + 31, "muted middle", "error, relative L2");
  }
  void draw_speed(double speed, const std::string& label, bool is_axis) {
    line(plot_left, y(speed), width - plot_right, y(speed), is_axis ? "ink" : "grid");
    text(plot_left - 5, y(speed) + 4, "muted end", label);
  }

  /// Stairs: between two points of the front nothing is faster than the one on the left.
  void draw_front() {
    const auto front = pareto_front(panel_.points);
    double before = bottom;
    for (std::size_t i = 0; i < front.size(); ++i) {
      const double at = x(front[i].error), above = y(front[i].speed);
      const double next = i + 1 < front.size() ? x(front[i + 1].error) : width - plot_right;
      line(at, std::exchange(before, above), at, above, "front");
      line(at, above, next, above, "front");
    }
  }

  struct Box {
    double left, right, top, bottom;
    [[nodiscard]] bool overlaps(const Box& other) const {
      return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
    }
  };

  void draw_points() {
    std::vector<Box> taken;
    for (const Point& point : panel_.points)
      taken.push_back({x(point.error) - 5, x(point.error) + 5, y(point.speed) - 5, y(point.speed) + 5});
    const auto front = pareto_front(panel_.points);
    for (const Point& point : panel_.points) {
      const bool is_best = std::any_of(front.begin(), front.end(),
                                       [&](const Point& best) { return best.label == point.label; });
      draw_label(point, is_best ? "label best" : "label", taken);
    }
    for (const Point& point : panel_.points)
      svg_ += dot(x(point.error), y(point.speed), point.is_peer ? "peer" : "own");
  }

  /// Puts a label beside its point, or as near as there is room.
  void draw_label(const Point& point, const std::string& style, std::vector<Box>& taken) {
    const double label_width = 6.6 * static_cast<double>(point.label.size());
    for (const double shift : {0.0, -13.0, 13.0, -26.0, 26.0, -39.0, 39.0, -52.0, 52.0, -65.0, 65.0}) {
      for (const bool is_left : {false, true}) {
        const double begin = x(point.error) + (is_left ? -8 : 8);
        const double middle = y(point.speed) + shift;
        const Box box{is_left ? begin - label_width : begin, is_left ? begin : begin + label_width,
                      middle - 6, middle + 6};
        const bool is_inside =
            box.left > plot_left && box.right < width && box.top > plot_top - 8 && box.bottom < bottom + 1;
        const bool is_free =
            std::none_of(taken.begin(), taken.end(), [&](const Box& other) { return box.overlaps(other); });
        if (!is_inside || !is_free) continue;
        taken.push_back(box);
        if (shift != 0) line(x(point.error), y(point.speed), begin, middle, "leader");
        text(begin, middle + 4, is_left ? style + " end" : style, point.label);
        return;
      }
    }
  }

  const Panel& panel_;
  double largest_speed_ = 0, top_speed_ = 1, step_ = 1;
  int first_decade_ = 0, last_decade_ = 1;  // of errors
  int bottom_decade_ = 0, top_decade_ = 1;  // of speeds, on a logarithmic axis
  std::string svg_;
};
}  // namespace detail

/// Styles of these figures beside figure_style.
inline constexpr const char* points_style = R"(<style>
svg .label { font-size: 11px; paint-order: stroke; stroke: #fff; stroke-width: 3px; stroke-linejoin: round } svg .best { font-weight: bold }
svg .leader { stroke: #8c959f; stroke-width: .7 } svg .front { stroke: #d1730c; stroke-width: 1.5; stroke-dasharray: 5 3 }
svg .own { fill: #0969da; stroke: #fff } svg .peer { fill: #fff; stroke: #57606a; stroke-width: 1.5 }
@media (prefers-color-scheme: dark) { svg .label { stroke: #0d1117 } }
</style>
)";

/// Draws panels row by row, at most three beside each other, for a page of 1280 pixels; replaces the file as
/// a whole.
inline void write_figure(const std::string& path, const std::string& title, const std::vector<Panel>& panels,
                         std::size_t columns) {
  shell::Panel key{460, 30, points_style};
  key.svg += shell::svg_line(16, 12, 40, 12, "front") +
             shell::svg_text(46, 16, "", "Pareto front; up and to the left is better") +
             detail::dot(306, 12, "own") + shell::svg_text(314, 16, "", "ours");
  if (std::ranges::any_of(
          panels, [](const Panel& panel) { return std::ranges::any_of(panel.points, &Point::is_peer); }))
    key.svg += detail::dot(356, 12, "peer") + shell::svg_text(364, 16, "", "other libraries");
  shell::Figure figure{title, {}, {{}, "", key}, std::min<std::size_t>(columns, 3)};
  for (const Panel& panel : panels)
    figure.panels.push_back(
        {detail::PanelDrawing::width, detail::PanelDrawing::height, detail::PanelDrawing(panel).svg()});
  io::write_file_atomically(path, std::string_view(shell::figure_svg(figure)));
}
}  // namespace tapestry::benchmarks
