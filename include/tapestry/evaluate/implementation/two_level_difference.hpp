#pragma once
#include <tapestry/evaluate/implementation/paired_bootstrap.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

namespace tapestry::evaluate::detail {

std::vector<double> means_over_draws(const Array<double, 2>& values) {
  std::vector<double> means(values.shape(1));
  for (std::size_t d = 0; d < values.shape(0); ++d)
    for (std::size_t v = 0; v < means.size(); ++v)
      means[v] += values(d, v) / static_cast<double>(values.shape(0));
  return means;
}

/// (first − ratio · second) / mean of second: what the values add to the error of ratio = Σ first / Σ second.
inline Array<double, 2> linear_terms(const Array<double, 2>& first, const Array<double, 2>& second,
                                     double ratio) {
  double sum = 0;
  for (const double value : second) sum += value;
  const double mean = sum / static_cast<double>(second.size());
  Array<double, 2> terms(first.shape());
  for (std::size_t i = 0; i < terms.size(); ++i)
    terms.data()[i] = (first.data()[i] - ratio * second.data()[i]) / mean;
  return terms;
}

/// Estimated parts of the variance of the mean over crossed draws and views, see two_level_difference().
struct TwoLevelVariance {
  double of_view_means = 0;  ///< of the mean of these: views and interaction
  double views = 0;          ///< a
  double draws = 0;          ///< b
  double degrees = 0;        ///< ν
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
  TwoLevelVariance variance{of_views, std::max(0.0, of_views - of_rest) + 0.1 * of_rest, of_draws, views - 1};
  const double sum = variance.views + variance.draws;
  if (sum > 0) variance.degrees = sum / (variance.draws / (draws - 1) + variance.views / (views - 1));
  return variance;
}

/// The interval of the views' means, made one of other draws and views, see two_level_difference().
inline std::array<double, 2> widened(const PairedDifference& of_views, const TwoLevelVariance& variance,
                                     double level) {
  const auto views = static_cast<double>(of_views.pairs);
  const double z = normal_quantile((1 + level) / 2);
  const double factor = z > 0 ? student_quantile((1 + level) / 2, variance.degrees) / z : 1;
  const double scale =
      variance.of_view_means > 0 ? views / (views - 1) * variance.views / variance.of_view_means : 0;
  const auto reach = [&](double distance) {
    const double of_these = std::max(0.0, distance);
    return factor * std::sqrt(scale * of_these * of_these + z * z * variance.draws);
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
  for (std::size_t d = 0; d < draw_count; ++d)
    for (std::size_t v = 0; v < view_count; ++v)
      if (!std::isfinite(differences(d, v)))
        throw NumericError({"two_level_difference: draw ", d, " of view ", v, " is not finite"});
  const auto view_means = detail::means_over_draws(differences);
  if (draw_count == 1 || view_count < 2)
    return within(paired_bootstrap(view_means, std::vector<double>(view_count), settings), most);
  const auto variance = detail::two_level_variance(differences);  // refuses what overflows
  auto result = detail::bca_difference(view_means, std::vector<double>(view_count), settings);
  for (std::size_t end = 0; const double value : detail::widened(result, variance, settings.level))
    result.interval[end++] = std::clamp(value, -most, most);
  return result;
}

namespace detail {
inline bool are_rows_equal(const Array<double, 2>& values) {
  for (std::size_t row = 1; row < values.shape(0); ++row)
    for (std::size_t column = 0; column < values.shape(1); ++column)
      if (values(row, column) != values(0, column)) return false;
  return true;
}
}  // namespace detail

PairedDifference two_level_rate_difference(const Array<double, 2>& differences,
                                           const PairedDifference& of_views) {
  if (differences.shape(1) < 2 || detail::are_rows_equal(differences)) return of_views;
  auto result = two_level_difference(differences, {}, 1);
  if (result.interval[0] == result.interval[1]) result.interval = of_views.interval;
  return result;
}

PairedRatio two_level_ratio(const Array<double, 2>& first, const Array<double, 2>& second) {
  require_shape("two_level_ratio", "second", second, {first.shape(0), first.shape(1)});
  auto result = paired_ratio(detail::means_over_draws(first), detail::means_over_draws(second));
  const auto terms = detail::linear_terms(first, second, result.ratio);
  if (detail::are_rows_equal(terms) || terms.shape(1) < 2) return result;
  const auto reach = two_level_difference(terms);
  for (std::size_t end = 0; end < 2; ++end) result.interval[end] = result.ratio + reach.interval[end];
  return result;
}

namespace detail {

/// Mean found share and the smoothed one.
struct FoundShare {
  double mean = 0, smoothed = 0;

  [[nodiscard]] double slope() const { return 1 / (smoothed * (1 - smoothed)); }  ///< of the log odds
};

inline FoundShare found_share(const Array<double, 2>& found) {
  double sum = 0;
  for (const double share : found) sum += share / static_cast<double>(found.shape(0));
  const auto views = static_cast<double>(found.shape(1));
  return {sum / views, (sum + 0.5) / (views + 1)};
}

/// Half the length of the interval of a log odds ratio by binomial variances.
inline double binomial_reach(const Array<double, 2>& first, const Array<double, 2>& second,
                             const FoundShare& of_first, const FoundShare& of_second) {
  const auto views = static_cast<double>(first.shape(1)), cells = static_cast<double>(first.size());
  double covariance = 0;
  for (std::size_t i = 0; i < first.size(); ++i)
    covariance += (first.data()[i] - of_first.mean) * (second.data()[i] - of_second.mean) / cells;
  const double variance =
      (of_first.slope() + of_second.slope() - 2 * covariance * of_first.slope() * of_second.slope()) / views;
  return student_quantile(0.975, views - 1) * std::sqrt(std::max(0.0, variance));
}

/// Square of what a share adds to the reach of a log odds ratio where its linear terms are 0, since the car
/// is found in all pictures or in none; else 0.
inline double saturated_reach(const FoundShare& share, const Array<double, 2>& found) {
  const bool is_one = std::ranges::all_of(found, [](double one) { return one == 1; });
  const bool is_none = std::ranges::all_of(found, [](double one) { return one == 0; });
  if (!is_one && !is_none) return 0;
  const auto views = static_cast<double>(found.shape(1));
  const double t = student_quantile(0.975, views - 1);
  return t * t * share.slope() / views;
}

}  // namespace detail

PairedRatio odds_ratio(const Array<double, 2>& control, const Array<double, 2>& camouflage) {
  require_shape("odds_ratio", "camouflage", camouflage, {control.shape(0), control.shape(1)});
  if (control.shape(0) == 0) throw ShapeError("odds_ratio: no draws");
  PairedRatio result{1, {0, std::numeric_limits<double>::infinity()}};
  if (control.shape(1) == 0) return result;
  const auto first = detail::found_share(control), second = detail::found_share(camouflage);
  const auto log_odds = [](double p) { return std::log(p / (1 - p)); };
  const double logarithm = log_odds(first.smoothed) - log_odds(second.smoothed);
  result.ratio = std::exp(logarithm);
  if (control.shape(1) < 2) return result;
  std::array<double, 2> reach{};
  if (!detail::are_rows_equal(control) || !detail::are_rows_equal(camouflage)) {
    Array<double, 2> terms(control.shape());
    for (std::size_t i = 0; i < terms.size(); ++i)
      terms.data()[i] = (control.data()[i] - first.mean) * first.slope() -
                        (camouflage.data()[i] - second.mean) * second.slope();
    reach = two_level_difference(terms).interval;
    const double saturated =
        detail::saturated_reach(first, control) + detail::saturated_reach(second, camouflage);
    reach = {-std::sqrt(reach[0] * reach[0] + saturated), std::sqrt(reach[1] * reach[1] + saturated)};
  }
  if (!(reach[1] - reach[0] > 0)) {
    reach[1] = detail::binomial_reach(control, camouflage, first, second);
    reach[0] = -reach[1];
  }
  result.interval = {std::exp(logarithm + reach[0]), std::exp(logarithm + reach[1])};
  return result;
}

}  // namespace tapestry::evaluate
