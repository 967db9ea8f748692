#pragma once
#include <algorithm>
#include <bit>
#include <cstdint>
#include <exception>
#include <span>
#include <string>
#include <tapestry/autodiff/detail/tape/dual_number.hpp>
#include <vector>

namespace tapestry {
/// Second derivatives of a function. An unknown one is NaN: the function has a kink there, or
/// an infinite slope hides it.
template <class T>
struct SecondDerivatives : std::vector<T> {
  using std::vector<T>::vector;

  /// How many are not known. Also counts unknown ones on the diagonal that a sparsity pattern leaves out.
  std::size_t unknown = 0;

  /// The sentence for a message.
  [[nodiscard]] std::string description() const {
    if (unknown == 0) return "all second derivatives are known";
    return std::to_string(unknown) + " second derivatives are not known, of " + std::to_string(this->size()) +
           ": the function has a kink or an infinite slope there";
  }
};

namespace detail {
/// A function at one point, with the second derivatives that a caller asks for.
template <class T>
struct Curvature {
  T value;
  std::vector<T> gradient;
  SecondDerivatives<T> second;
};

/// Smallest and largest of the numbers at one distance.
template <class T>
struct Spread {
  T low = std::numeric_limits<T>::infinity(), high = -low, sum = 0;
  void add(T x) {
    low = x < low || std::isnan(x) ? x : low;
    high = x > high || std::isnan(x) ? x : high;
    sum += x;
  }
  [[nodiscard]] T width() const { return high - low; }
  [[nodiscard]] T size() const { return std::max(std::abs(low), std::abs(high)); }
};

/// Second derivatives at a point where the rules for kinks and for zeros would decide: the limit of second
/// derivatives around it. The function is taken as smooth there if its gradient and its second derivatives
/// are the same on all sides, at two distances, the far one 256 times the near one, which is some roundings
/// of x. Any two variables move together and against each other, and all move by different amounts. Points
/// where the function is not finite, or throws, are outside its domain and are left out.
template <class T>
class Surroundings {
 public:
  Surroundings(std::span<const T> x, const Curvature<T>& here)
      : x_(x), here_(here), gradient_{Spreads(x.size()), Spreads(x.size())} {
    for (Spreads& all : second_) all.resize(here.second.size());
    for (const T entry : x) largest_x_ = std::max(largest_x_, std::abs(entry));
    for (Spreads& all : gradient_)
      for (std::size_t i = 0; i < x.size(); ++i) all[i].add(here.gradient[i]);
  }

  template <class Evaluate>
  void visit(Evaluate evaluate) {
    const std::size_t patterns = 5 + static_cast<std::size_t>(std::bit_width(x_.size()));
    for (std::size_t pattern = 0; pattern < patterns; ++pattern)
      for (const T distance : {near_step, -near_step, far_step, -far_step}) {
        const std::size_t before = kinks().varying;
        try {
          add(evaluate(moved(pattern, distance)), std::abs(distance) == far_step);
        } catch (const std::exception&) {  // outside the domain
        }
        is_at_kink_ = is_at_kink_ || (std::abs(distance) == near_step && kinks().varying != before);
      }
  }

  template <class PlaceOf>
  [[nodiscard]] SecondDerivatives<T> limits(PlaceOf place_of) const {
    SecondDerivatives<T> result = here_.second;
    std::vector<bool> jumps(x_.size()), has_diagonal(x_.size());
    for (std::size_t i = 0; i < x_.size(); ++i)
      jumps[i] = !is_smooth(gradient_[0][i], gradient_[1][i], 64 * epsilon * gradient_[0][i].size());
    T largest = 0;
    for (const auto& all : second_[0]) largest = std::max(largest, count_ == 0 ? T(0) : all.size());
    for (std::size_t e = 0; e < result.size(); ++e) {
      const auto [row, column] = place_of(e);
      if (row == column) has_diagonal[row] = true;
      result[e] = limit(e, jumps[row] && jumps[column], largest);
    }
    for (std::size_t i = 0; i < x_.size(); ++i) result.unknown += jumps[i] && !has_diagonal[i] ? 1U : 0U;
    return result;
  }

 private:
  using Spreads = std::vector<Spread<T>>;
  static constexpr T epsilon = std::numeric_limits<T>::epsilon();
  static constexpr T near_step = 16 * epsilon, far_step = 256 * near_step;

  [[nodiscard]] static bool is_smooth(const Spread<T>& nearby, const Spread<T>& far_off, T rounding) {
    return nearby.width() <= far_off.width() / 4 + rounding;
  }

  [[nodiscard]] std::vector<T> moved(std::size_t pattern, T distance) const {
    std::vector<T> point(x_.begin(), x_.end());
    for (std::size_t i = 0; i < point.size(); ++i) {
      std::uint64_t mixed = (pattern * point.size() + i + 1) * 0x9E3779B97F4A7C15U;
      mixed = (mixed ^ mixed >> 29U) * 0xBF58476D1CE4E5B9U;
      const bool is_code = pattern < 1 + static_cast<std::size_t>(std::bit_width(point.size()));
      const bool is_back = is_code ? pattern > 0 && (i >> (pattern - 1) & 1U) != 0 : mixed >> 63U != 0;
      const T amount = 1 + static_cast<T>(mixed >> 40U & 0xffffU) / 8192;
      const T unit = point[i] != 0 ? std::abs(point[i]) : largest_x_ == 0 ? T(1) : std::min(T(1), largest_x_);
      point[i] += (is_back ? -amount : amount) * distance * unit;
    }
    return point;
  }

  void add(const Curvature<T>& found, bool is_far) {
    if (!std::isfinite(found.value)) return;
    for (std::size_t i = 0; i < x_.size(); ++i) gradient_[is_far][i].add(found.gradient[i]);
    for (std::size_t e = 0; e < found.second.size(); ++e) second_[is_far][e].add(found.second[e]);
    if (!is_far) ++count_;
  }

  [[nodiscard]] T limit(std::size_t e, bool jumps, T largest) const {
    const T here = here_.second[e];
    const Spread<T>&around = second_[0][e], &far_off = second_[1][e];
    if (std::isinf(here) && count_ > 0 && far_off.size() < std::abs(around.low) / 2 &&
        std::signbit(here) == std::signbit(around.low) && std::signbit(here) == std::signbit(around.high))
      return here;
    const T rounding = 64 * epsilon * largest + std::pow(epsilon, T(0.6)) * around.size();
    if (jumps || is_at_kink_ || count_ == 0 || std::isnan(here_.value) ||
        !is_smooth(around, far_off, rounding))
      return std::numeric_limits<T>::quiet_NaN();
    const T mean = around.sum / static_cast<T>(count_), drift = std::abs(far_off.high - around.high) / 16;
    return std::abs(here - mean) <= around.width() + drift + rounding ? here : mean;
  }

  std::span<const T> x_;
  const Curvature<T>& here_;
  Spreads gradient_[2], second_[2];  // near, far
  T largest_x_ = 0;
  std::size_t count_ = 0;    // near points in the domain
  bool is_at_kink_ = false;  // at a near point, too
};

/// Evaluates the function at x by evaluate(point), a Curvature. Where it met a kink, second derivatives are
/// their limits, or NaN without a limit.
template <class T, class Evaluate, class PlaceOf>
[[nodiscard]] Curvature<T> known_curvature(std::span<const T> x, Evaluate evaluate, PlaceOf place_of) {
  const std::size_t before = kinks().met;
  Curvature<T> found = evaluate(std::vector<T>(x.begin(), x.end()));
  if (kinks().met != before) {
    Surroundings<T> around(x, found);
    around.visit(evaluate);
    found.second = around.limits(place_of);
  }
  for (const T entry : found.second) found.second.unknown += std::isnan(entry) ? 1U : 0U;
  return found;
}
}  // namespace detail
}  // namespace tapestry
