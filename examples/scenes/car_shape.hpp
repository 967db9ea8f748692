#pragma once
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace tapestry::scenes {
/// A smooth curve through knots that overshoots none of them, constant outside.
/// Source: Fritsch and Carlson, "Monotone piecewise cubic interpolation" (1980), with the harmonic
/// mean of Fritsch and Butland (1984) as slope.
class Curve {
 public:
  /// \param knots  (argument, value), arguments increasing, at least two
  Curve(std::vector<std::pair<double, double>> knots) : knots_(std::move(knots)), slopes_(knots_.size()) {
    for (std::size_t i = 1; i + 1 < knots_.size(); ++i) {
      const double before = secant(i - 1);
      const double after = secant(i);
      if (before * after > 0) slopes_[i] = 2 * before * after / (before + after);
    }
    slopes_.front() = secant(0);
    slopes_.back() = secant(knots_.size() - 2);
  }

  [[nodiscard]] double operator()(double x) const {
    if (x <= knots_.front().first) return knots_.front().second;
    if (x >= knots_.back().first) return knots_.back().second;
    std::size_t i = 0;
    while (x > knots_[i + 1].first) ++i;
    const double h = knots_[i + 1].first - knots_[i].first;
    const double t = (x - knots_[i].first) / h;
    const double s = 1 - t;
    return s * s * (1 + 2 * t) * knots_[i].second + t * t * (1 + 2 * s) * knots_[i + 1].second +
           s * s * t * h * slopes_[i] - t * t * s * h * slopes_[i + 1];
  }

 private:
  [[nodiscard]] double secant(std::size_t i) const {
    return (knots_[i + 1].second - knots_[i].second) / (knots_[i + 1].first - knots_[i].first);
  }

  std::vector<std::pair<double, double>> knots_;
  std::vector<double> slopes_;
};

enum class BodyStyle { sedan, hatchback, suv, van };

/// Positions of a body style.
struct CarPositions {
  double rear, front;  ///< x of the end sections
  double underside;    ///< z
  double wheel_radius, rear_axle, front_axle;
  double front_rake, rear_rake;                       ///< how far the end leans back from bumper to top
  std::pair<double, double> windscreen, rear_window;  ///< x ranges of the glass, rear end first
  std::pair<double, double> tail_lights;              ///< z range
};

/// Shape of one body style: curves along the car and a few positions. Metres; x to the front, y to the left,
/// z up, the origin on the ground under the centre.
struct CarShape : CarPositions {
  Curve top;             ///< z on the centre line: boot, rear window, roof, windscreen, bonnet
  Curve belt;            ///< z at which the side ends and the shoulder or window begins
  Curve half_width;      ///< y at the widest height
  Curve top_half_width;  ///< y where roof or bonnet begin
  std::vector<std::pair<double, double>> side_windows;  ///< x ranges, rear end first
};

/// Through knots that are listed as x, value, x, value, …
[[nodiscard]] inline Curve curve(const std::vector<double>& numbers) {
  std::vector<std::pair<double, double>> knots;
  for (std::size_t i = 0; i < numbers.size(); i += 2) knots.emplace_back(numbers[i], numbers[i + 1]);
  return {std::move(knots)};
}

/// In the order of BodyStyle.
inline const std::array<CarShape, 4> car_shapes{
    {{{-2.22, 2.20, 0.20, 0.33, -1.34, 1.38, 0.20, 0.10, {0.48, 1.10}, {-1.68, -0.96}, {0.66, 0.82}},
      curve({-2.22, 0.93, -2.05, 1.00, -1.72, 1.04, -0.98, 1.37, -0.65, 1.43, -0.10, 1.46,
             0.30,  1.42, 0.50,  1.36, 1.12,  1.00, 1.30,  0.95, 1.80,  0.86, 2.20,  0.73}),
      curve({-2.22, 0.86, -1.70, 0.95, -1.00, 0.95, 0.00, 0.91, 1.00, 0.87, 1.60, 0.80, 2.20, 0.66}),
      curve({-2.22, 0.74, -2.00, 0.83, -1.40, 0.89, 0.00, 0.90, 1.40, 0.89, 1.90, 0.83, 2.20, 0.71}),
      curve({-2.22, 0.62, -1.75, 0.66, -1.00, 0.57, 0.00, 0.60, 0.40, 0.58, 1.12, 0.68, 1.50, 0.70, 2.20,
             0.56}),
      {{-1.38, -0.98}, {-0.93, 0.06}, {0.14, 0.86}}},
     {{-1.92, 1.98, 0.20, 0.32, -1.24, 1.26, 0.18, 0.06, {0.34, 1.04}, {-1.86, -1.52}, {0.72, 0.96}},
      curve({-1.92, 1.02, -1.86, 1.08, -1.52, 1.42, -1.30, 1.47, -0.40, 1.52, 0.10,
             1.50,  0.36, 1.43,  1.06, 1.03,  1.22, 0.97,  1.65, 0.88,  1.98, 0.75}),
      curve({-1.92, 0.96, -1.40, 0.99, -0.60, 0.96, 0.20, 0.92, 1.00, 0.89, 1.50, 0.82, 1.98, 0.68}),
      curve({-1.92, 0.74, -1.70, 0.83, -1.20, 0.88, 0.00, 0.885, 1.20, 0.87, 1.70, 0.81, 1.98, 0.70}),
      curve({-1.92, 0.64, -1.50, 0.57, -0.80, 0.60, 0.20, 0.59, 1.06, 0.68, 1.40, 0.69, 1.98, 0.55}),
      {{-1.36, -0.94}, {-0.86, -0.02}, {0.06, 0.80}}},
     {{-2.18, 2.16, 0.26, 0.37, -1.34, 1.36, 0.12, 0.05, {0.42, 1.00}, {-2.12, -1.88}, {0.80, 1.08}},
      curve({-2.18, 1.18, -2.12, 1.26, -1.88, 1.60, -1.70, 1.66, -0.60, 1.72, 0.15,
             1.69,  0.42, 1.60,  1.02, 1.20,  1.18, 1.14,  1.75, 1.06,  2.16, 0.96}),
      curve({-2.18, 1.10, -1.60, 1.12, -0.60, 1.10, 0.20, 1.07, 1.00, 1.05, 1.60, 1.00, 2.16, 0.88}),
      curve({-2.18, 0.79, -1.95, 0.88, -1.40, 0.93, 0.00, 0.93, 1.40, 0.92, 1.90, 0.87, 2.16, 0.77}),
      curve({-2.18, 0.68, -1.85, 0.61, -0.80, 0.64, 0.25, 0.63, 1.02, 0.72, 1.50, 0.74, 2.16, 0.62}),
      {{-1.82, -1.18}, {-1.06, -0.10}, {-0.02, 0.78}}},
     {{-2.62, 2.44, 0.26, 0.36, -1.62, 1.62, 0.14, 0.03, {1.08, 1.68}, {-2.62, -2.62}, {0.80, 1.14}},
      curve({-2.62, 2.10, -2.52, 2.19, -2.30, 2.22, 0.60, 2.22, 0.90, 2.17,
             1.12,  2.04, 1.72,  1.30, 1.86,  1.22, 2.20, 1.13, 2.44, 1.02}),
      curve({-2.62, 1.16, 0.00, 1.16, 1.20, 1.12, 1.80, 1.06, 2.44, 0.90}),
      curve({-2.62, 0.94, -2.50, 0.98, -2.00, 0.99, 1.40, 0.99, 1.95, 0.94, 2.44, 0.80}),
      curve({-2.62, 0.82, -2.40, 0.84, 0.70, 0.84, 1.12, 0.78, 1.72, 0.80, 2.44, 0.64}),
      {{0.34, 1.42}}}}};

[[nodiscard]] inline const CarShape& car_shape(BodyStyle style) {
  return car_shapes[static_cast<std::size_t>(style)];
}
}  // namespace tapestry::scenes
