#pragma once
#include <cmath>
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

}  // namespace tapestry::scenes
