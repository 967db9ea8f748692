#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <vector>

namespace tapestry::evaluate {

/// How an interval is drawn.
struct BootstrapSettings {
  std::size_t resamples = 2000;
  std::uint64_t seed = 1;
  double level = 0.95;  ///< of the interval, in (0, 1)
};

/// The mean of first − second over pairs, and how far it is known.
struct PairedDifference {
  std::size_t pairs = 0;
  double mean = 0;  ///< 0 without pairs
  std::array<double, 2> interval{-std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::infinity()};
};

namespace detail {

/// Φ, the distribution function of the standard normal distribution.
[[nodiscard]] inline double normal_probability(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// Φ⁻¹ by bisection, to the last digits; p in (0, 1), and beyond ±37 as there.
[[nodiscard]] inline double normal_quantile(double p) {
  double low = -37, high = 37;
  for (int step = 0; step < 64; ++step) {
    const double middle = (low + high) / 2;
    (normal_probability(middle) < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

/// The quantile of sorted values, linear between them: the least at p = 0, the greatest at p = 1.
[[nodiscard]] inline double quantile(const std::vector<double>& sorted, double p) {
  const double position = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// Means of resamples drawn with replacement, ascending.
inline std::vector<double> resampled_means(const std::vector<double>& values,
                                           const BootstrapSettings& settings) {
  Random random(settings.seed);
  std::vector<double> means(settings.resamples);
  for (double& mean : means) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) sum += values[random.index(values.size())];
    mean = sum / static_cast<double>(values.size());
  }
  std::sort(means.begin(), means.end());
  return means;
}

/// a = Σd³ / (6·(Σd²)^(3/2)) of the deviations d from the mean: the skewness of the mean over 6, as the
/// jackknife gives it; 0 where all values are the same.
inline double acceleration(const std::vector<double>& values, double mean) {
  double squares = 0, cubes = 0;
  for (const double value : values) {
    const double d = value - mean;
    squares += d * d;
    cubes += d * d * d;
  }
  return squares > 0 ? cubes / (6 * squares * std::sqrt(squares)) : 0;
}

/// The probability at which the distribution of resampled means is read for an end of the interval that in a
/// normal distribution lies z standard deviations off.
inline double corrected_probability(double z, double bias, double acceleration) {
  const double shifted = bias + z;
  return normal_probability(bias + shifted / (1 - acceleration * shifted));
}

}  // namespace detail

/// The mean difference of pairs, with a bootstrap interval over the pairs: what one treatment of the same
/// views changes against another.
///
/// The interval is BCa, bias-corrected and accelerated: Efron, "Better bootstrap confidence intervals"
/// (Journal of the American Statistical Association 82, 1987). Resampled means that equal the mean count half
/// as below it, since differences of rates are often tied. It tells how far the mean would go with other
/// views of the same kind; with few of them, below about 20, intervals are too narrow. Where all differences
/// are the same, it has no width: then the pairs show no spread to learn from.
///
/// \param first, second  one number a pair, in the same order
/// \returns  with fewer than two pairs an interval from −∞ to ∞
/// \throws ShapeError if there are not as many of both; NumericError for a number that is not finite;
///         DomainError for no resamples or a level not in (0, 1)
[[nodiscard]] inline PairedDifference paired_bootstrap(const std::vector<double>& first,
                                                       const std::vector<double>& second,
                                                       const BootstrapSettings& settings = {}) {
  if (first.size() != second.size())
    throw ShapeError("paired_bootstrap: second has " + std::to_string(second.size()) + " numbers, expected " +
                     std::to_string(first.size()));
  if (settings.resamples == 0) throw DomainError("paired_bootstrap: resamples is 0, expected at least 1");
  if (!(settings.level > 0 && settings.level < 1))
    throw DomainError("paired_bootstrap: level is " + std::to_string(settings.level) + ", not in (0, 1)");
  PairedDifference result;
  result.pairs = first.size();
  std::vector<double> differences(first.size());
  double sum = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    differences[i] = first[i] - second[i];
    if (!std::isfinite(differences[i]))
      throw NumericError("paired_bootstrap: pair " + std::to_string(i) + " has a number that is not finite");
    sum += differences[i];
  }
  if (!differences.empty()) result.mean = sum / static_cast<double>(differences.size());
  if (differences.size() < 2) return result;

  const auto means = detail::resampled_means(differences, settings);
  const auto below =
      static_cast<double>(std::lower_bound(means.begin(), means.end(), result.mean) - means.begin());
  const auto upto =
      static_cast<double>(std::upper_bound(means.begin(), means.end(), result.mean) - means.begin());
  const double bias = detail::normal_quantile((below + upto) / 2 / static_cast<double>(means.size()));
  const double acceleration = detail::acceleration(differences, result.mean);
  const double z = detail::normal_quantile((1 + settings.level) / 2);
  result.interval = {detail::quantile(means, detail::corrected_probability(-z, bias, acceleration)),
                     detail::quantile(means, detail::corrected_probability(z, bias, acceleration))};
  return result;
}

}  // namespace tapestry::evaluate
