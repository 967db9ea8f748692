#pragma once
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tapestry/io/atomic_file.hpp>
#include <vector>

namespace tapestry::benchmarks {

struct Point {
  std::string label;
  double error;
  double speed;
  bool is_peer;
};

/// One comparison, drawn as speed (upwards) against error (to the right, logarithmic).
struct Panel {
  std::string title;
  std::string subtitle;
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

[[nodiscard]] inline std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

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

/// Draws one panel into a rectangle with its corner at (left, top).
class PanelDrawing {
 public:
  static constexpr double width = 340;
  static constexpr double height = 262;

  PanelDrawing(const Panel& panel, double left, double top) : panel_(panel), left_(left), top_(top) {
    double least = 1;
    double most = 0;
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
    text(left_ + 14, top_ + 12, "title", panel_.title);
    text(left_ + 14, top_ + 26, "tick", panel_.subtitle);
    draw_axes();
    draw_front();
    draw_points();
    return svg_;
  }

 private:
  static constexpr double plot_left = 44, plot_right = 14, plot_top = 40, plot_bottom = 40;

  [[nodiscard]] double x(double error) const {
    const double part = (std::log10(error) - first_decade_) / (last_decade_ - first_decade_);
    return left_ + plot_left + part * (width - plot_left - plot_right);
  }
  [[nodiscard]] double y(double speed) const {
    const double part = panel_.is_speed_logarithmic
                            ? (std::log10(speed) - bottom_decade_) / (top_decade_ - bottom_decade_)
                            : speed / top_speed_;
    return top_ + height - plot_bottom - part * (height - plot_top - plot_bottom);
  }
  /// Where the axis of errors lies.
  [[nodiscard]] double bottom() const { return top_ + height - plot_bottom; }

  void text(double x, double y, const char* style, const std::string& words) {
    svg_ += "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\" class=\"" + style + "\">" + words +
            "</text>\n";
  }
  void line(double x1, double y1, double x2, double y2, const char* style) {
    svg_ += "<path d=\"M" + number(x1) + " " + number(y1) + "L" + number(x2) + " " + number(y2) +
            "\" class=\"" + style + "\"/>\n";
  }

  void draw_axes() {
    const double right = left_ + width - plot_right;
    if (panel_.is_speed_logarithmic) {
      for (int decade = bottom_decade_; decade <= top_decade_; ++decade)
        draw_speed(std::pow(10, decade), power_of_ten(decade), decade == bottom_decade_);
    } else {
      for (double speed = 0; speed <= top_speed_ * 1.001; speed += step_) {
        char label[32];
        std::snprintf(label, sizeof label, "%g", speed);
        draw_speed(speed, label, speed == 0);
      }
    }
    const int label_step = (last_decade_ - first_decade_ + 5) / 6;  // labels that do not touch
    for (int decade = first_decade_; decade <= last_decade_; ++decade) {
      const double at = x(std::pow(10, decade));
      line(at, top_ + plot_top, at, bottom(), "grid");
      if ((decade - first_decade_) % label_step == 0)
        text(at, bottom() + 15, "tick middle", power_of_ten(decade));
    }
    text((left_ + plot_left + right) / 2, bottom() + 31, "tick middle", "error, relative L2");
  }
  void draw_speed(double speed, const std::string& label, bool is_axis) {
    line(left_ + plot_left, y(speed), left_ + width - plot_right, y(speed), is_axis ? "axis" : "grid");
    text(left_ + plot_left - 5, y(speed) + 4, "tick end", label);
  }

  /// Stairs: between two points of the front nothing is faster than the one on the left.
  void draw_front() {
    const auto front = pareto_front(panel_.points);
    if (front.empty()) return;
    std::string path = "M" + number(x(front.front().error)) + " " + number(bottom());
    for (const Point& point : front) path += "V" + number(y(point.speed)) + "H" + next_x(front, point);
    svg_ += "<path d=\"" + path + "\" class=\"front\"/>\n";
  }
  [[nodiscard]] std::string next_x(const std::vector<Point>& front, const Point& point) const {
    for (const Point& other : front)
      if (other.error > point.error) return number(x(other.error));
    return number(left_ + width - plot_right);
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
      svg_ += "<circle cx=\"" + number(x(point.error)) + "\" cy=\"" + number(y(point.speed)) +
              "\" r=\"4\" class=\"" + (point.is_peer ? "peer" : "own") + "\"/>\n";
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
        const bool is_inside = box.left > left_ + plot_left && box.right < left_ + width &&
                               box.top > top_ + plot_top - 8 && box.bottom < bottom() + 1;
        const bool is_free =
            std::none_of(taken.begin(), taken.end(), [&](const Box& other) { return box.overlaps(other); });
        if (!is_inside || !is_free) continue;
        taken.push_back(box);
        if (shift != 0) line(x(point.error), y(point.speed), begin, middle, "leader");
        text(begin, middle + 4, (is_left ? style + " end" : style).c_str(), point.label);
        return;
      }
    }
  }

  const Panel& panel_;
  double left_;
  double top_;
  double largest_speed_ = 0;
  double top_speed_ = 1;
  double step_ = 1;
  int first_decade_ = 0, last_decade_ = 1;  // of errors
  int bottom_decade_ = 0, top_decade_ = 1;  // of speeds, on a logarithmic axis
  std::string svg_;
};
}  // namespace detail

/// Draws panels row by row, at most three beside each other, for a page of 1280 pixels; replaces the file as
/// a whole.
inline void write_figure(const std::string& path, const std::string& title, const std::vector<Panel>& panels,
                         std::size_t columns) {
  using detail::number;
  columns = std::min<std::size_t>(columns, 3);
  constexpr double header = 44;
  const double width = detail::PanelDrawing::width * static_cast<double>(columns);
  const double height =
      header + detail::PanelDrawing::height * static_cast<double>((panels.size() + columns - 1) / columns);
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + number(width) + "\" height=\"" +
                    number(height) + "\" viewBox=\"0 0 " + number(width) + " " + number(height) + R"(">
<style>
text { font: 11px sans-serif; fill: #24292f }
.heading { font-size: 14px; font-weight: bold } .title { font-size: 12px; font-weight: bold }
.label { paint-order: stroke; stroke: #fff; stroke-width: 3px; stroke-linejoin: round } .best { font-weight: bold }
.tick { fill: #57606a } .middle { text-anchor: middle } .end { text-anchor: end }
.grid { stroke: #e5e8eb } .axis { stroke: #57606a } .leader { stroke: #8c959f; stroke-width: .7 }
.front { fill: none; stroke: #d1730c; stroke-width: 1.5; stroke-dasharray: 5 3 }
.own { fill: #0969da; stroke: #fff } .peer { fill: #fff; stroke: #57606a; stroke-width: 1.5 }
</style>
<rect width="100%" height="100%" fill="#fff"/>
)";
  svg += "<text x=\"14\" y=\"18\" class=\"heading\">" + title + "</text>\n";
  svg +=
      R"(<path d="M16 32H40" class="front"/><text x="46" y="36">Pareto front; up and to the left is better</text>
<circle cx="306" cy="32" r="4" class="own"/><text x="314" y="36">ours</text>
)";
  const auto has_peer = [](const Panel& panel) {
    return std::any_of(panel.points.begin(), panel.points.end(), [](const Point& p) { return p.is_peer; });
  };
  if (std::any_of(panels.begin(), panels.end(), has_peer))
    svg += R"(<circle cx="356" cy="32" r="4" class="peer"/><text x="364" y="36">other libraries</text>
)";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    const auto column = static_cast<double>(i % columns);
    const auto row = static_cast<double>(i / columns);
    svg += detail::PanelDrawing(panels[i], detail::PanelDrawing::width * column,
                                header + detail::PanelDrawing::height * row)
               .svg();
  }
  io::write_file_atomically(path, std::string_view(svg + "</svg>\n"));
}

}  // namespace tapestry::benchmarks
