#pragma once
#include <cstdio>
#include <map>
#include <numeric>
#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry {
/// Settings of a gradient check.
struct GradientCheckOptions {
  double tolerance = 1e-6;  ///< largest relative error that passes
  double step = 0;          ///< step at |x| ≤ 1, times |x| above; 0: ε^(1/3), with Richardson ε^(1/5)
  bool richardson = false;  ///< extrapolate from h and h/2: error O(h⁴) instead of O(h²)
  std::size_t subset = 0;   ///< how many entries to check, drawn without repetition; 0: all
  std::uint64_t seed = 1;   ///< of the draw
  double rounding = 4;      ///< error of a value of the function, in ε|f|; more for long sums
};

/// One entry of a gradient beside the difference quotient.
struct GradientCheckEntry {
  std::size_t index = 0;  ///< row-major
  double argument = 0;
  double step = 0;
  double analytic = 0;
  double numeric = 0;
  double relative_error = 0;  ///< |analytic − numeric| / max(|analytic|, |numeric|, floor)
  bool kink = false;          ///< the function seems not to be smooth within the step
};

/// Result of a gradient check.
struct GradientReport {
  double tolerance = 0;
  std::size_t checked = 0;
  GradientCheckEntry worst;                  ///< largest relative error among entries without a kink
  std::vector<GradientCheckEntry> failures;  ///< above the tolerance, without a kink
  std::vector<GradientCheckEntry> kinks;     ///< above the tolerance, but with a kink within the step

  /// True also if nothing was checked.
  [[nodiscard]] bool passed() const { return failures.empty(); }

  void add(const GradientCheckEntry& entry) {
    ++checked;
    if (entry.kink) return kinks.push_back(entry);
    if (checked == kinks.size() + 1 || entry.relative_error > worst.relative_error) worst = entry;
    if (entry.relative_error > tolerance) failures.push_back(entry);
  }

  /// One line, and one for each failure and kink.
  [[nodiscard]] std::string to_text() const {
    std::string text = std::to_string(checked) + " entries checked, " + std::to_string(failures.size()) +
                       " above tolerance, " + std::to_string(kinks.size()) + " at kinks";
    if (checked > kinks.size()) text += "; worst: " + line(worst);
    for (const GradientCheckEntry& entry : failures) text += "\n  failed " + line(entry);
    for (const GradientCheckEntry& entry : kinks) text += "\n  kink   " + line(entry);
    return text;
  }

 private:
  static std::string line(const GradientCheckEntry& entry);
};

namespace detail {
[[nodiscard]] inline std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// Evaluates f along one entry of its argument.
template <class Function, std::size_t Rank>
class EntryDifference {
 public:
  EntryDifference(const Function& f, const Array<double, Rank>& x) : f_(f), x_(x), centre_(f(x_)) {}

  [[nodiscard]] double centre() const { return centre_; }
  [[nodiscard]] double at(std::size_t index, double offset) {
    const double saved = x_.data()[index];
    x_.data()[index] = saved + offset;
    const double value = f_(std::as_const(x_));
    x_.data()[index] = saved;
    return value;
  }
  [[nodiscard]] double central(std::size_t index, double h) {
    return (at(index, h) - at(index, -h)) / (2 * h);
  }

  /// Forward minus backward difference. Proportional to h for a smooth function, but not for a kink or a jump
  /// within h.
  [[nodiscard]] double bend(std::size_t index, double h) {
    return ((at(index, h) - centre_) - (centre_ - at(index, -h))) / h;
  }

 private:
  const Function& f_;
  Array<double, Rank> x_;
  double centre_;
};

/// Evaluates the gradient of f, on a tape of numbers, along one entry of its argument.
template <class Function>
class GradientDifference {
 public:
  GradientDifference(const Function& f, std::span<const double> x, std::size_t along)
      : f_(f), x_(x.begin(), x.end()), along_(along) {}

  /// Size of the numbers that are subtracted.
  [[nodiscard]] double centre() {
    double largest = 0;
    for (const double entry : at(0)) largest = std::max(largest, std::abs(entry));
    return largest;
  }
  [[nodiscard]] double central(std::size_t index, double h) {
    return (at(h)[index] - at(-h)[index]) / (2 * h);
  }
  /// As EntryDifference::bend().
  [[nodiscard]] double bend(std::size_t index, double h) {
    return ((at(h)[index] - at(0)[index]) - (at(0)[index] - at(-h)[index])) / h;
  }

 private:
  const std::vector<double>& at(double offset) {
    const auto [found, is_new] = gradients_.try_emplace(offset);
    if (is_new) {
      std::vector<double> point = x_;
      point[along_] += offset;
      found->second = gradient(f_, std::span<const double>(point)).gradient;
    }
    return found->second;
  }

  const Function& f_;
  std::vector<double> x_;
  std::size_t along_;
  std::map<double, std::vector<double>> gradients_;
};

/// A power of two, so that x ± h are as exact as they can be.
[[nodiscard]] inline double difference_step(const GradientCheckOptions& options, double argument) {
  const double epsilon = std::numeric_limits<double>::epsilon();
  const double base =
      options.step > 0 ? options.step : std::pow(epsilon, options.richardson ? 1.0 / 5 : 1.0 / 3);
  return std::exp2(std::round(std::log2(base * std::max(1.0, std::abs(argument)))));
}

[[nodiscard]] inline std::vector<std::size_t> entries_to_check(std::size_t size,
                                                               const GradientCheckOptions& options) {
  std::vector<std::size_t> entries(size);
  std::iota(entries.begin(), entries.end(), std::size_t(0));
  if (options.subset == 0 || options.subset >= size) return entries;
  Random(options.seed).shuffle(entries);
  entries.resize(options.subset);
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// A smooth bend halves with h; two pairs of steps, since a kink a third of the step away fools one pair.
template <class Difference>
[[nodiscard]] bool has_kink(Difference& difference, std::size_t index, double h, double threshold) {
  const double whole = difference.bend(index, h);
  const double half = difference.bend(index, h / 2);
  const double quarter = difference.bend(index, h / 4);
  return !(std::abs(whole / 2 - half) <= threshold && std::abs(half / 2 - quarter) <= threshold);
}

template <class Difference>
[[nodiscard]] GradientCheckEntry check_entry(Difference& difference, std::size_t index, double argument,
                                             double analytic, const GradientCheckOptions& options) {
  const double h = difference_step(options, argument);
  double numeric = difference.central(index, h);
  if (options.richardson) numeric = (4 * difference.central(index, h / 2) - numeric) / 3;
  const double rounding =
      options.rounding * std::numeric_limits<double>::epsilon() * std::abs(difference.centre()) / h;
  const double scale = std::max({std::isfinite(analytic) ? std::abs(analytic) : 0, std::abs(numeric),
                                 rounding / options.tolerance, std::numeric_limits<double>::min()});
  GradientCheckEntry entry{index, argument, h, analytic, numeric, std::abs(analytic - numeric) / scale,
                           false};
  if (std::isnan(entry.relative_error)) entry.relative_error = std::numeric_limits<double>::infinity();
  if (entry.relative_error > options.tolerance && std::isfinite(analytic))
    entry.kink = has_kink(difference, index, h, std::max(options.tolerance * scale / 2, 4 * rounding));
  return entry;
}
}  // namespace detail

inline std::string GradientReport::line(const GradientCheckEntry& entry) {
  using detail::number_text;
  return "entry " + std::to_string(entry.index) + " at " + number_text(entry.argument) + ": analytic " +
         number_text(entry.analytic) + ", numeric " + number_text(entry.numeric) + ", relative error " +
         number_text(entry.relative_error) + ", step " + number_text(entry.step);
}

/// Compares a gradient with central differences of the function, entry by entry.
///
/// Relative errors are taken against the larger of the two numbers, but at least against the smallest size
/// that differences resolve to the tolerance: the options' rounding, in ε|f|/h, over tolerance. Where the two
/// disagree, one-sided differences at h, h/2 and h/4 distinguish a kink or jump of the function within the
/// step from a wrong gradient. A kink proves nothing about the gradient: such entries are listed apart.
///
/// \param f         from const Array<double, Rank>& to double
/// \param x         the point
/// \param gradient  claimed, of the extents of x
/// \throws ShapeError if gradient is not of the extents of x
template <class Function, std::size_t Rank>
[[nodiscard]] GradientReport check_gradient(const Function& f, const Array<double, Rank>& x,
                                            const Array<double, Rank>& gradient,
                                            const GradientCheckOptions& options = {}) {
  require_shape("check_gradient", "gradient", gradient, x.shape());
  detail::EntryDifference<Function, Rank> difference(f, x);
  GradientReport report;
  report.tolerance = options.tolerance;
  for (const std::size_t index : detail::entries_to_check(x.size(), options)) {
    report.add(detail::check_entry(difference, index, x.data()[index], gradient.data()[index], options));
  }
  return report;
}

/// Compares the Hessian of a function written for any scalar type, from std::span<const S> to S, as
/// hessian_product() computes it on a tape of duals, with central differences of the gradient that a tape of
/// numbers computes. It finds an operation of one's own that loses tangents, see CarriesTangents. Entry
/// i · n + j of the report is ∂²f / ∂xᵢ ∂xⱼ, and its argument xⱼ; the subset is one of columns j.
template <class Function>
[[nodiscard]] GradientReport check_hessian(const Function& f, std::span<const double> x,
                                           const GradientCheckOptions& options = {}) {
  GradientReport report;
  report.tolerance = options.tolerance;
  HessianProducts<Function> products(f);
  std::vector<double> direction(x.size());
  for (const std::size_t column : detail::entries_to_check(x.size(), options)) {
    direction[column] = 1;
    const auto product = products(x, std::span<const double>(direction)).product;
    direction[column] = 0;
    detail::GradientDifference<Function> difference(f, x, column);
    for (std::size_t row = 0; row < x.size(); ++row) {
      auto entry = detail::check_entry(difference, row, x[column], product[row], options);
      entry.index = row * x.size() + column;
      report.add(entry);
    }
  }
  return report;
}

/// The same for a function on the tape, from const ArrayVariable<double, Rank>& to Variable<double>: its
/// gradient is taken by a tape of its own, its differences with a passive argument.
template <class Function, std::size_t Rank>
[[nodiscard]] GradientReport check_tape_gradient(const Function& f, const Array<double, Rank>& x,
                                                 const GradientCheckOptions& options = {}) {
  Tape<double> tape;
  const auto scope = tape.activate();
  const ArrayVariable<double, Rank> input = tape.input(x);
  const Variable<double> root = f(input);
  tape.reverse(root);
  const auto value = [&f](const Array<double, Rank>& at) {
    const Variable<double> result = f(ArrayVariable<double, Rank>(at));
    return result.value();
  };
  return check_gradient(value, x, input.adjoint(), options);
}

/// Compares the tape's gradient of a function written for any scalar type, from std::span<const S> to S, with
/// dual numbers: exact but for rounding, without a step or kinks. It does not check the functions' partial
/// derivatives, which both share; only differences check those.
template <class Function>
[[nodiscard]] GradientReport check_gradient_by_duals(const Function& f, std::span<const double> x,
                                                     const GradientCheckOptions& options = {
                                                         .tolerance = 1e-12}) {
  using D = Dual<double, 1, Function>;
  const auto on_tape = gradient(f, x);
  std::vector<D> inputs(x.begin(), x.end());
  GradientReport report;
  report.tolerance = options.tolerance;
  for (const std::size_t index : detail::entries_to_check(x.size(), options)) {
    inputs[index] = D::input(x[index]);
    const D root = f(std::span<const D>(inputs));
    inputs[index] = D(x[index]);
    const double analytic = on_tape.gradient[index], numeric = root.tangent();
    const double scale =
        std::max({std::abs(analytic), std::abs(numeric), std::numeric_limits<double>::min()});
    GradientCheckEntry entry{index, x[index], 0, analytic, numeric, std::abs(analytic - numeric) / scale,
                             false};
    if (analytic == numeric) entry.relative_error = 0;  // infinite ones, too
    if (std::isnan(entry.relative_error)) entry.relative_error = std::numeric_limits<double>::infinity();
    report.add(entry);
  }
  return report;
}
}  // namespace tapestry
