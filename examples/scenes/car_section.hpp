#pragma once
#include <algorithm>
#include <numbers>
#include "car_shape.hpp"

namespace tapestry::scenes {
/// Rows of a half section, from the bottom edge of the side to the centre line of roof or bonnet.
inline constexpr std::size_t side_rows = 6;
inline constexpr std::array<double, 5> shoulder_fractions{0, 0.10, 0.45, 0.87, 1};  ///< belt to roof edge
inline constexpr std::array<double, 5> roof_fractions{0, 0.13, 0.40, 0.70, 1};      ///< roof edge to centre
inline constexpr std::size_t shoulder_row = side_rows;
inline constexpr std::size_t roof_row = side_rows + shoulder_fractions.size() - 1;
inline constexpr std::size_t section_rows = roof_row + roof_fractions.size() - 1;

/// One half section of the body at one x: section_rows + 1 points, y ≥ 0.
struct CarSection {
  struct Vertex {
    double y, z;
    double height;   ///< chart coordinate of the side: z below the belt, arc length above it; metres
    double lateral;  ///< chart coordinate of the top: arc length from the centre line; metres
  };
  double x;
  std::array<Vertex, section_rows + 1> points;
};

/// z of the side's lower edge: the underside, lifted by the wheel arches.
[[nodiscard]] inline double lower_edge(const CarShape& shape, double x) {
  double z = shape.underside;
  const double radius = 1.16 * shape.wheel_radius;
  for (const double axle : {shape.rear_axle, shape.front_axle})
    if (std::abs(x - axle) < radius)
      z = std::max(z, shape.wheel_radius + std::sqrt(radius * radius - (x - axle) * (x - axle)));
  return z;
}

[[nodiscard]] inline double side_half_width(const CarShape& shape, double x, double z) {
  const double t = 2 * (z - shape.underside) / (shape.belt(x) - shape.underside) - 1;  // −1 … 1
  return shape.half_width(x) * (1 - (t < 0 ? 0.065 : 0.040) * t * t);
}

[[nodiscard]] inline CarSection car_section(const CarShape& shape, double x) {
  CarSection section{x, {}};
  auto& points = section.points;
  const double bottom = lower_edge(shape, x);
  const double belt = shape.belt(x);
  for (std::size_t i = 0; i <= side_rows; ++i) {
    const double z = bottom + (belt - bottom) * static_cast<double>(i) / double(side_rows);
    points[i] = {side_half_width(shape, x, z), z, z, 0};
  }
  const double top = shape.top(x);
  const double edge_z = std::max(belt + 0.02, top - 0.055);
  const double edge_y = shape.top_half_width(x);
  const double belt_y = points[side_rows].y;
  for (std::size_t i = 1; i < shoulder_fractions.size(); ++i) {
    const double f = shoulder_fractions[i];
    const double bulge = 0.03 * std::sin(std::numbers::pi * f);
    points[shoulder_row + i] = {belt_y + (edge_y - belt_y) * f + bulge, belt + (edge_z - belt) * f, 0, 0};
  }
  for (std::size_t i = 1; i < roof_fractions.size(); ++i) {
    const double f = roof_fractions[i];
    points[roof_row + i] = {edge_y * (1 - f), edge_z + (top - edge_z) * f * (2 - f), 0, 0};
  }
  const auto step = [&](std::size_t i) {
    return std::hypot(points[i + 1].y - points[i].y, points[i + 1].z - points[i].z);
  };
  for (std::size_t i = shoulder_row; i < roof_row; ++i) points[i + 1].height = points[i].height + step(i);
  for (std::size_t i = section_rows; i-- > roof_row;) points[i].lateral = points[i + 1].lateral + step(i);
  return section;
}

/// Positions of the sections: every edge of glass, lights and arches, and gaps filled to `spacing`.
[[nodiscard]] inline std::vector<double> section_positions(const CarShape& shape, double spacing) {
  std::vector<double> marks{shape.windscreen.first,   shape.windscreen.second, shape.rear_window.first,
                            shape.rear_window.second, shape.front - 0.24,      shape.rear + 0.20,
                            shape.front - 0.08,       shape.rear + 0.07};
  for (const auto& [begin, end] : shape.side_windows) marks.insert(marks.end(), {begin, end});
  const double radius = 1.16 * shape.wheel_radius;
  const double foot = std::asin((shape.underside - shape.wheel_radius) / radius);
  const int arch_steps = std::max(5, static_cast<int>(1.6 / spacing));
  for (const double axle : {shape.rear_axle, shape.front_axle})
    for (int i = 0; i <= arch_steps; ++i)
      marks.push_back(axle + radius * std::cos(foot + (std::numbers::pi - 2 * foot) * i / arch_steps));
  marks.push_back(shape.front);
  std::sort(marks.begin(), marks.end());
  std::vector<double> positions{shape.rear};
  for (const double mark : marks) {
    const double gap = mark - positions.back();
    if (gap < 0.015 || mark > shape.front) continue;
    const int steps = static_cast<int>(std::ceil(gap / spacing));
    const double begin = positions.back();
    for (int i = 1; i <= steps; ++i) positions.push_back(begin + gap * i / steps);
  }
  positions.back() = shape.front;
  return positions;
}
}  // namespace tapestry::scenes
