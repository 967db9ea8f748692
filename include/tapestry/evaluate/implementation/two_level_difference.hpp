#pragma once
#include <tapestry/evaluate/implementation/paired_bootstrap.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

namespace tapestry::evaluate::detail {

/// With t² = ν·(exp(s²/ν) − 1), the density of t becomes one of s that is bell shaped for every ν ≥ 1:
///
///     dP(T ≤ t) ∝ exp(−s²·(ν − 1) / (2ν)) · √(q / (exp(q) − 1)) ds,   q = s²/ν,
///
/// and above s = 9 less than 10⁻¹⁶ remains.
double student_quantile(double p, double degrees) {
  const auto density = [&](double s) {
    const double q = s * s / degrees;
    return q > 0 ? std::exp(-q * (degrees - 1) / 2) * std::sqrt(q / std::expm1(q)) : 1.0;
  };
  const auto integral = [&](double end) {  // of the density from 0, by Simpson's rule
    const int steps = 200;
    double sum = density(0) + density(end);
    for (int i = 1; i < steps; ++i) sum += (i % 2 == 0 ? 2 : 4) * density(end * i / steps);
    return sum * end / (3 * steps);
  };
  const double wanted = (2 * p - 1) * integral(9);
  double s = 0;  // Newton's method comes from the left, since the integral is concave
  for (int step = 0; step < 100; ++step) {
    const double further = (wanted - integral(s)) / density(s);
    s = std::min(s + further, 9.0);
    if (std::abs(further) < 1e-13) break;
  }
  return std::sqrt(degrees * std::expm1(s * s / degrees));
}

/// Estimated parts of the variance of the mean over crossed draws and views, see two_level_difference().
struct TwoLevelVariance {
  double views = 0;  ///< a, with the interaction
  double draws = 0;  ///< b
  double share = 0;  ///< w
};

/// \param differences  [draw, view], two or more of both
/// \throws NumericError if a square is not finite
inline TwoLevelVariance two_level_variance(const Array<double, 2>& differences) {
  const std::size_t draw_count = differences.shape(0), view_count = differences.shape(1);
  const auto draws = static_cast<double>(draw_count), views = static_cast<double>(view_count);
  const double origin = differences(0, 0);  // equal numbers have variances of 0, without rounding
  std::vector<double> draw_mean(draw_count), view_mean(view_count);
  double mean = 0;
  for (std::size_t d = 0; d < draw_count; ++d)
    for (std::size_t v = 0; v < view_count; ++v) {
      const double value = differences(d, v) - origin;
      draw_mean[d] += value / views;
      view_mean[v] += value / draws;
      mean += value / (draws * views);
    }
  double draw_squares = 0, view_squares = 0, rest_squares = 0;
  for (const double value : draw_mean) draw_squares += (value - mean) * (value - mean);
  for (const double value : view_mean) view_squares += (value - mean) * (value - mean);
  for (std::size_t d = 0; d < draw_count; ++d)
    for (std::size_t v = 0; v < view_count; ++v) {
      const double rest = differences(d, v) - origin - draw_mean[d] - view_mean[v] + mean;
      rest_squares += rest * rest;
    }
  const double of_rest = rest_squares / ((draws - 1) * (views - 1)) / (draws * views);
  const double of_views = view_squares / (views - 1) / views, of_draws = draw_squares / (draws - 1) / draws;
  if (!std::isfinite(of_views + of_draws + of_rest))
    throw NumericError("two_level_difference: the variance is not finite");
  TwoLevelVariance variance{of_views, std::max(0.0, of_draws - of_rest), 0};
  const double sum = variance.views + variance.draws;
  if (sum > 0) variance.share = std::min(1.0, of_draws / sum);
  return variance;
}

/// The views' interval, widened for few views and for other draws, see two_level_difference().
inline std::array<double, 2> widened(const PairedDifference& of_views, const TwoLevelVariance& variance,
                                     std::size_t draw_count, double level) {
  const auto draws = static_cast<double>(draw_count), views = static_cast<double>(of_views.pairs);
  const double degrees = 1 / (variance.share / (draws - 1) + (1 - variance.share) / (views - 1));
  const double z = normal_quantile((1 + level) / 2);
  const double factor = z > 0 ? student_quantile((1 + level) / 2, degrees) / z : 1;
  const auto reach = [&](double distance) {
    const double of_these = std::max(0.0, distance);
    return factor * std::sqrt(views / (views - 1) * of_these * of_these + z * z * variance.draws);
  };
  return {of_views.mean - reach(of_views.mean - of_views.interval[0]),
          of_views.mean + reach(of_views.interval[1] - of_views.mean)};
}

}  // namespace tapestry::evaluate::detail

namespace tapestry::evaluate {

PairedDifference two_level_difference(const Array<double, 2>& differences, const BootstrapSettings& settings,
                                      double most) {
  const std::size_t draw_count = differences.shape(0), view_count = differences.shape(1);
  if (draw_count == 0)
    throw ShapeError(
        {"two_level_difference: differences is [0, ", view_count, "], expected one draw or more"});
  detail::require_settings("two_level_difference", settings);
  std::vector<double> view_means(view_count);
  for (std::size_t d = 0; d < draw_count; ++d)
    for (std::size_t v = 0; v < view_count; ++v) {
      if (!std::isfinite(differences(d, v)))
        throw NumericError({"two_level_difference: draw ", d, " of view ", v, " is not finite"});
      view_means[v] += differences(d, v) / static_cast<double>(draw_count);
    }
  if (draw_count == 1 || view_count < 2)
    return paired_bootstrap(view_means, std::vector<double>(view_count), settings);
  const auto variance = detail::two_level_variance(differences);  // refuses what overflows
  PairedDifference result = paired_bootstrap(view_means, std::vector<double>(view_count), settings);
  for (std::size_t end = 0;
       const double value : detail::widened(result, variance, draw_count, settings.level))
    result.interval[end++] = std::clamp(value, -most, most);
  return result;
}

}  // namespace tapestry::evaluate
