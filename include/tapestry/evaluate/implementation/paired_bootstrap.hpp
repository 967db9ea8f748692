#pragma once
#include <numeric>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/paired_bootstrap.hpp>

namespace tapestry::evaluate {
namespace detail {
double normal_quantile(double p) {
  double low = -37, high = 37;
  for (int step = 0; step < 64; ++step) {
    const double middle = (low + high) / 2;
    (normal_probability(middle) < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

double quantile(const std::vector<double>& sorted, double p) {
  const double position = std::clamp(p, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  if (position == static_cast<double>(below) || sorted[above] == sorted[below])
    return sorted[below];  // also if the next one is infinite
  return sorted[below] + (position - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

double acceleration(const std::vector<double>& values, double mean) {
  double squares = 0, cubes = 0;
  for (const double value : values) {
    const double d = value - mean;
    squares += d * d;
    cubes += d * d * d;
  }
  return squares > 0 ? cubes / (6 * squares * std::sqrt(squares)) : 0;
}

double corrected_probability(double z, double bias, double acceleration) {
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

/// \throws DomainError for no resamples or a level not in (0, 1)
inline void require_settings(const std::string& operation, const BootstrapSettings& settings) {
  if (settings.resamples == 0) throw DomainError({operation, ": resamples is 0, expected at least 1"});
  if (!(settings.level > 0 && settings.level < 1))
    throw DomainError({operation, ": level is ", settings.level, ", not in (0, 1)"});
}

/// \throws ShapeError, DomainError, NumericError as paired_bootstrap()
inline void require_pairs(const std::string& operation, const std::vector<double>& first,
                          const std::vector<double>& second, const BootstrapSettings& settings) {
  if (first.size() != second.size())
    throw ShapeError({operation, ": second has ", second.size(), " numbers, expected ", first.size()});
  require_settings(operation, settings);
  for (std::size_t i = 0; i < first.size(); ++i)
    if (!std::isfinite(first[i]) || !std::isfinite(second[i]) || !std::isfinite(first[i] - second[i]))
      throw NumericError({operation, ": pair ", i, " has a number that is not finite"});
}

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
  const auto integral = [&](double end) {  // integral of the density from 0, by Simpson's rule
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

/// A bootstrap's interval of few pairs, see paired_bootstrap().
inline std::array<double, 2> widened_for_few(const std::array<double, 2>& interval, double middle,
                                             std::size_t pair_count, double level) {
  const auto pairs = static_cast<double>(pair_count);
  const double p = (1 + level) / 2, z = normal_quantile(p);
  const double factor = std::sqrt(pairs / (pairs - 1)) * (z > 0 ? student_quantile(p, pairs - 1) / z : 1);
  return {middle - factor * std::max(0.0, middle - interval[0]),
          middle + factor * std::max(0.0, interval[1] - middle)};
}

/// The mean difference of pairs with its BCa bootstrap interval, uncorrected.
inline PairedDifference bca_difference(const std::vector<double>& first, const std::vector<double>& second,
                                       const BootstrapSettings& settings) {
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
  const auto means = resampled(differences.size(), settings, [&](const std::vector<std::size_t>& indices) {
    double total = 0;
    for (const std::size_t i : indices) total += differences[i];
    return total / static_cast<double>(indices.size());
  });
  result.interval = bca_interval(means, result.mean, acceleration(differences, result.mean), settings.level);
  return result;
}
}  // namespace detail

PairedDifference paired_bootstrap(const std::vector<double>& first, const std::vector<double>& second,
                                  const BootstrapSettings& settings) {
  detail::require_pairs("paired_bootstrap", first, second, settings);
  PairedDifference result = detail::bca_difference(first, second, settings);
  if (result.pairs > 1)
    result.interval = detail::widened_for_few(result.interval, result.mean, result.pairs, settings.level);
  return result;
}

PairedRatio paired_ratio(const std::vector<double>& first, const std::vector<double>& second,
                         const BootstrapSettings& settings) {
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
  const auto interval =
      detail::bca_interval(detail::resampled(first.size(), settings, ratio_of), result.ratio,
                           detail::acceleration(influences, 0), settings.level);
  result.interval = detail::widened_for_few(interval, result.ratio, first.size(), settings.level);
  return result;
}

PairedDifference rate_difference(const std::vector<bool>& first, const std::vector<bool>& second,
                                 std::size_t pictures_a_view) {
  if (first.size() != second.size())
    throw ShapeError({"rate_difference: second has ", second.size(), " pictures, expected ", first.size()});
  PairedDifference difference;
  if (first.empty()) return difference;
  std::array<std::size_t, 4> counts{};  // both, the first alone, the second alone, none
  for (std::size_t i = 0; i < first.size(); ++i) ++counts[(first[i] ? 0U : 2U) + (second[i] ? 0U : 1U)];
  const double pictures = static_cast<double>(pictures_a_view),
               n = static_cast<double>(first.size()) / pictures;
  const auto views = [&](std::size_t k) { return static_cast<double>(counts[k]) / pictures; };
  const double e = views(0), f = views(1), g = views(2), h = views(3);
  const auto [l1, u1] = wilson_interval(counts[0] + counts[1], first.size(), pictures_a_view);
  const auto [l2, u2] = wilson_interval(counts[0] + counts[2], first.size(), pictures_a_view);
  const double p1 = (e + f) / n, p2 = (e + g) / n;
  const double margins = (e + f) * (g + h) * (e + g) * (f + h), together = e * h - f * g;
  const double phi =
      margins > 0 ? (together > 0 ? std::max(together - n / 2, 0.0) : together) / std::sqrt(margins) : 0;
  const auto reach = [&](double a, double b) { return std::sqrt(a * a - 2 * phi * a * b + b * b); };
  difference.pairs = first.size() / pictures_a_view;
  difference.mean = (f - g) / n;
  difference.interval = {difference.mean - reach(p1 - l1, u2 - p2),
                         difference.mean + reach(u1 - p1, p2 - l2)};
  return difference;
}
}  // namespace tapestry::evaluate
