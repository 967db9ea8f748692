#pragma once
#include <tapestry/evaluate/implementation/paired_bootstrap.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

namespace tapestry::evaluate {
namespace detail {
std::vector<double> means_over_draws(const Array<double, 2>& values) {
  std::vector<double> means(values.shape(1));
  for (std::size_t d = 0; d < values.shape(0); ++d)
    for (std::size_t v = 0; v < means.size(); ++v)
      means[v] += values(d, v) / static_cast<double>(values.shape(0));
  return means;
}

/// (first − ratio · second) / mean of second: the values' part in the error of ratio = Σ first / Σ second.
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
  double of_view_means = 0;  ///< variance of the views' mean, with the interaction
  double views = 0;          ///< a
  double draws = 0;          ///< b
  double degrees = 0;        ///< ν
  double interaction = 0;    ///< a part of b, too

  [[nodiscard]] double sum() const { return views + draws; }
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
  const double all = draws * views, of_equals = draws * view_squares + views * draw_squares + rest_squares;
  TwoLevelVariance variance{
      of_views,
      std::max(std::max(0.0, of_views - of_rest) + 0.1 * of_rest, of_equals / (all * (all - 1)) - of_draws),
      of_draws, views - 1, of_rest};
  if (variance.sum() > 0)
    variance.degrees = variance.sum() / (variance.draws / (draws - 1) + variance.views / (views - 1));
  return variance;
}

/// Extends the interval of the views' means to other draws and views, see two_level_difference().
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

inline bool are_rows_equal(const Array<double, 2>& values) {
  for (std::size_t row = 1; row < values.shape(0); ++row)
    for (std::size_t column = 0; column < values.shape(1); ++column)
      if (values(row, column) != values(0, column)) return false;
  return true;
}

/// \param trials  need not be whole
/// \param z       quantile that the interval reaches to
inline std::array<double, 2> wilson_interval_of(double share, double trials, double z) {
  const double centre = share + z * z / (2 * trials);
  const double reach = z * std::sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials));
  const double scale = 1 / (1 + z * z / trials);
  return {share == 0 ? 0.0 : scale * (centre - reach), share == 1 ? 1.0 : scale * (centre + reach)};
}

/// A share over draws and views, see two_level_rate_difference().
struct TwoLevelShare {
  double draws = 0, views = 0;
  double share = 0;
  TwoLevelVariance variance{};
  double found_views = 0, missed_views = 0;  ///< with a picture of a found car, or of a missed one

  [[nodiscard]] bool is_saturated() const { return found_views == 0 || missed_views == 0; }

  /// Half the length of the interval of the logarithm of odds, see two_level_rate_difference().
  /// \param pq       p·(1 − p)
  /// \param widened  factor of the variance
  [[nodiscard]] double reach(double pq, double widened = 1) const {
    const double t_views = student_quantile(0.975, views - 1),
                 t_draws = draws > 1 ? student_quantile(0.975, draws - 1) : 0;
    const double apart = std::max(0.0, variance.draws - variance.interaction);
    const double of_views = variance.views + (draws == 2 ? variance.interaction / 4 : 0);
    const double together = t_views * t_views * of_views + t_draws * t_draws * (variance.draws - apart);
    return std::hypot(2 * std::asinh(std::sqrt(widened * together) / (2 * pq)),
                      t_draws * std::sqrt(widened * apart) / pq);
  }

  /// Interval of the share, 95 %.
  [[nodiscard]] std::array<double, 2> interval() const {
    if (is_saturated()) return wilson_interval_of(share, views, student_quantile(0.975, views - 1));
    const double odds = share / (1 - share), factor = std::exp(reach(share * (1 - share)));
    return {1 / (1 + factor / odds), 1 / (1 + 1 / (factor * odds))};
  }
};

/// two_level_variance(); with equal draws the variance of one draw; empty for one view.
inline TwoLevelVariance variance_over_levels(const Array<double, 2>& values) {
  const auto views = static_cast<double>(values.shape(1));
  if (views < 2) return {};
  if (!are_rows_equal(values)) return two_level_variance(values);
  double sum = 0, squares = 0;
  for (std::size_t view = 0; view < values.shape(1); ++view) sum += values(0, view);
  for (std::size_t view = 0; view < values.shape(1); ++view)
    squares += (values(0, view) - sum / views) * (values(0, view) - sum / views);
  return {0, squares / (views * (views - 1)), 0, views - 1};
}

/// \param found  [draw, view]; draws that are equal count as one
inline TwoLevelShare two_level_share(const Array<double, 2>& found) {
  TwoLevelShare result{are_rows_equal(found) ? 1.0 : static_cast<double>(found.shape(0)),
                       static_cast<double>(found.shape(1)), 0, variance_over_levels(found)};
  for (const double share : found) result.share += share / static_cast<double>(found.size());
  for (std::size_t view = 0; view < found.shape(1); ++view) {
    bool is_found = false, is_missed = false;
    for (std::size_t draw = 0; draw < found.shape(0); ++draw) {
      is_found = is_found || found(draw, view) > 1e-9;
      is_missed = is_missed || found(draw, view) < 1 - 1e-9;  // seven sevenths are a little less than one
    }
    result.found_views += is_found ? 1 : 0;
    result.missed_views += is_missed ? 1 : 0;
  }
  if (result.is_saturated())
    result.share = result.found_views > 0 ? 1 : 0;  // without rounding
  else if (!(result.variance.sum() > 0))            // each view has as many pictures
    result.variance.views = result.share * (1 - result.share) / result.views;
  return result;
}

/// Correlation of the means of two shares; 0 where one of these or their difference does not vary.
/// \param difference  variance of the mean difference
inline double correlation(const TwoLevelShare& first, const TwoLevelShare& second,
                          const TwoLevelVariance& difference) {
  const double one = first.variance.sum(), other = second.variance.sum();
  if (!(one * other * difference.sum() > 0)) return 0;
  return std::clamp((one + other - difference.sum()) / (2 * std::sqrt(one * other)), -1.0, 1.0);
}

inline Array<double, 2> difference_of(const Array<double, 2>& first, const Array<double, 2>& second) {
  Array<double, 2> difference = first;
  for (std::size_t i = 0; i < difference.size(); ++i) difference.data()[i] -= second.data()[i];
  return difference;
}

/// Distance from a difference to an end of its interval, from its terms' distances.
inline double put_together(double first, double second, double correlation) {
  return std::sqrt(std::max(0.0, first * first + second * second - 2 * correlation * first * second));
}

/// A share's logarithm of odds, and half the length of its interval, see odds_ratio().
/// \param pictures  of each entry of the array
inline std::pair<double, double> log_odds(const TwoLevelShare& share, double pictures) {
  const double of_view = share.draws * pictures, all = of_view * share.views;
  const double p = share.is_saturated() ? (share.share * all + 0.5) / (all + 1) : share.share,
               pq = p * (1 - p);
  const double logarithm = std::log(p / (1 - p));
  if (share.views < 2) return {logarithm, 0};
  if (share.is_saturated())
    return {logarithm,
            2 * std::asinh(student_quantile(0.975, share.views - 1) / (2 * std::sqrt(share.views * pq)))};
  const double effect = share.variance.sum() * all / pq;
  const double shown = std::min(share.found_views, share.missed_views);
  return {logarithm, share.reach(pq, std::max(1.0, (shown + 0.3 * of_view / effect) / (shown + 0.3)))};
}
}  // namespace detail

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

PairedDifference two_level_rate_difference(const Array<double, 2>& control,
                                           const Array<double, 2>& camouflage,
                                           const PairedDifference& of_views) {
  require_shape("two_level_rate_difference", "camouflage", camouflage, {control.shape(0), control.shape(1)});
  if (control.shape(1) < 2 || (detail::are_rows_equal(control) && detail::are_rows_equal(camouflage)))
    return of_views;
  const auto first = detail::two_level_share(control), second = detail::two_level_share(camouflage);
  const double together = detail::correlation(
      first, second, detail::variance_over_levels(detail::difference_of(control, camouflage)));
  const auto [low, high] = first.interval();
  const auto [other_low, other_high] = second.interval();
  auto result = of_views;
  result.mean = first.share - second.share;
  result.interval = {
      result.mean - detail::put_together(first.share - low, other_high - second.share, together),
      result.mean + detail::put_together(high - first.share, second.share - other_low, together)};
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

PairedRatio odds_ratio(const Array<double, 2>& control, const Array<double, 2>& camouflage,
                       std::size_t pictures_of_control, std::size_t pictures_of_camouflage) {
  require_shape("odds_ratio", "camouflage", camouflage, {control.shape(0), control.shape(1)});
  if (control.shape(0) == 0) throw ShapeError("odds_ratio: no draws");
  PairedRatio result{1, {0, std::numeric_limits<double>::infinity()}};
  if (control.shape(1) == 0) return result;
  const auto first = detail::two_level_share(control), second = detail::two_level_share(camouflage);
  const auto [log_odds, reach] = detail::log_odds(first, static_cast<double>(pictures_of_control));
  const auto [other_log_odds, other_reach] =
      detail::log_odds(second, static_cast<double>(pictures_of_camouflage));
  const double logarithm = log_odds - other_log_odds;
  result.ratio = std::exp(logarithm);
  const double both = detail::put_together(
      reach, other_reach,
      detail::correlation(first, second,
                          detail::variance_over_levels(detail::difference_of(control, camouflage))));
  if (std::min(first.found_views, second.missed_views) >= 3) result.interval[0] = std::exp(logarithm - both);
  if (std::min(first.missed_views, second.found_views) >= 3) result.interval[1] = std::exp(logarithm + both);
  return result;
}
}  // namespace tapestry::evaluate
