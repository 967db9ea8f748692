#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <numeric>
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

/// A ratio of two means over the same pairs, and how far it is known.
struct PairedRatio {
  double ratio = 0;
  std::array<double, 2> interval{-std::numeric_limits<double>::infinity(),
                                 std::numeric_limits<double>::infinity()};

  [[nodiscard]] bool operator==(const PairedRatio&) const = default;
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
  if (position == static_cast<double>(below) || sorted[above] == sorted[below])
    return sorted[below];  // also where the next one is infinite
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// What an estimator makes of resamples, ascending: vectors of as many indices, drawn with replacement.
template <class Estimator>
std::vector<double> resampled(std::size_t count, const BootstrapSettings& settings,
                              const Estimator& estimator) {
  Random random(settings.seed);
  std::vector<std::size_t> indices(count);
  std::vector<double> estimates(settings.resamples);
  for (double& estimate : estimates) {
    for (std::size_t& index : indices) index = random.index(count);
    estimate = estimator(indices);
  }
  std::sort(estimates.begin(), estimates.end());
  return estimates;
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

/// The BCa interval of an estimate, see paired_bootstrap().
/// \param resampled  estimates of resamples, ascending
inline std::array<double, 2> bca_interval(const std::vector<double>& resampled, double estimate,
                                          double acceleration, double level) {
  const auto below =
      static_cast<double>(std::lower_bound(resampled.begin(), resampled.end(), estimate) - resampled.begin());
  const auto upto =
      static_cast<double>(std::upper_bound(resampled.begin(), resampled.end(), estimate) - resampled.begin());
  const double bias = normal_quantile((below + upto) / 2 / static_cast<double>(resampled.size()));
  const double z = normal_quantile((1 + level) / 2);
  return {quantile(resampled, corrected_probability(-z, bias, acceleration)),
          quantile(resampled, corrected_probability(z, bias, acceleration))};
}

/// \throws ShapeError, DomainError, NumericError as paired_bootstrap()
inline void require_pairs(const std::string& operation, const std::vector<double>& first,
                          const std::vector<double>& second, const BootstrapSettings& settings) {
  if (first.size() != second.size())
    throw ShapeError(operation + ": second has " + std::to_string(second.size()) + " numbers, expected " +
                     std::to_string(first.size()));
  if (settings.resamples == 0) throw DomainError(operation + ": resamples is 0, expected at least 1");
  if (!(settings.level > 0 && settings.level < 1))
    throw DomainError(operation + ": level is " + std::to_string(settings.level) + ", not in (0, 1)");
  for (std::size_t i = 0; i < first.size(); ++i)
    if (!std::isfinite(first[i]) || !std::isfinite(second[i]) || !std::isfinite(first[i] - second[i]))
      throw NumericError(operation + ": pair " + std::to_string(i) + " has a number that is not finite");
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
  detail::require_pairs("paired_bootstrap", first, second, settings);
  PairedDifference result;
  result.pairs = first.size();
  std::vector<double> differences(first.size());
  double sum = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    differences[i] = first[i] - second[i];
    sum += differences[i];
  }
  if (!differences.empty()) result.mean = sum / static_cast<double>(differences.size());
  if (differences.size() < 2) return result;

  const auto means =
      detail::resampled(differences.size(), settings, [&](const std::vector<std::size_t>& indices) {
        double total = 0;
        for (const std::size_t i : indices) total += differences[i];
        return total / static_cast<double>(indices.size());
      });
  result.interval = detail::bca_interval(means, result.mean, detail::acceleration(differences, result.mean),
                                         settings.level);
  return result;
}

/// Σ first / Σ second over pairs, with a bootstrap interval as of paired_bootstrap(): pairs are drawn with
/// both their numbers, so that what is common to them does not widen it. The skewness is that of the
/// influences first − ratio · second. A resample whose second sum is not above 0 counts as ∞, for its ratio
/// says nothing; so where the second mean is not well above 0, the interval has no upper end.
///
/// \param first, second  one number a pair, in the same order; the sum of the second above 0
/// \returns  with fewer than two pairs an interval from −∞ to ∞
/// \throws as paired_bootstrap(); DomainError unless the sum of the second is above 0
[[nodiscard]] inline PairedRatio paired_ratio(const std::vector<double>& first,
                                              const std::vector<double>& second,
                                              const BootstrapSettings& settings = {}) {
  detail::require_pairs("paired_ratio", first, second, settings);
  std::vector<std::size_t> all(first.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const auto ratio_of = [&](const std::vector<std::size_t>& indices) {
    double above = 0, below = 0;
    for (const std::size_t i : indices) above += first[i], below += second[i];
    return below > 0 ? above / below : std::numeric_limits<double>::infinity();
  };
  if (!(std::accumulate(second.begin(), second.end(), 0.0) > 0))
    throw DomainError("paired_ratio: the second numbers do not have a sum above 0");
  PairedRatio result{ratio_of(all)};
  if (!std::isfinite(result.ratio)) throw NumericError("paired_ratio: the ratio is not finite");
  if (first.size() < 2) return result;
  std::vector<double> influences(first.size());
  for (const std::size_t i : all) influences[i] = first[i] - result.ratio * second[i];
  result.interval = detail::bca_interval(detail::resampled(first.size(), settings, ratio_of), result.ratio,
                                         detail::acceleration(influences, 0), settings.level);
  return result;
}

}  // namespace tapestry::evaluate
