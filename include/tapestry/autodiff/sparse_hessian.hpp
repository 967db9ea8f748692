#pragma once
#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/detail/jacobian/interactions.hpp>

namespace tapestry {
namespace detail {
/// The pattern with the transpose of each entry. \throws DomainError unless it is square
[[nodiscard]] inline JacobianPattern symmetrised(const JacobianPattern& pattern) {
  if (pattern.row_count() != pattern.column_count())
    throw DomainError({"HessianPlan: a pattern of ", pattern.row_count(), " rows and ",
                       pattern.column_count(), " columns, expected a square one"});
  std::vector<JacobianPattern::Entry> entries;
  entries.reserve(2 * pattern.entry_count());
  pattern.visit([&](std::size_t row, std::size_t column, std::size_t) {
    entries.push_back({row, column});
    entries.push_back({column, row});
  });
  return {pattern.row_count(), pattern.column_count(), std::move(entries)};
}

/// Colours of variables such that neighbours differ, and two neighbours of one variable may be equal only if
/// its colour is lower than theirs: a restricted star colouring, greedily, in the order of the variables.
/// Source: Gebremedhin, Manne and Pothen 2005, "What color is your Jacobian? Graph coloring for computing
/// derivatives", after Powell and Toint 1979. Time: at most the sum over all entries of the pattern of their
/// rows' lengths.
[[nodiscard]] inline std::vector<std::uint32_t> star_colours(const JacobianPattern& pattern) {
  constexpr std::uint32_t none = 0xFFFFFFFFU;
  std::vector<std::uint32_t> colours(pattern.row_count(), none);
  std::vector<std::size_t> forbidden_for;  // for each colour, 1 + the variable that may not take it
  std::vector<std::size_t> order(colours.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return pattern.row(a).size() > pattern.row(b).size();
  });
  for (const std::size_t v : order) {
    const auto forbid = [&](std::uint32_t colour) { forbidden_for[colour] = v + 1; };
    for (const auto w : pattern.row(v)) {
      if (w == v) continue;
      if (colours[w] != none) forbid(colours[w]);
      if (colours[w] == 0) continue;  // no colour is lower, and a hub comes first
      for (const auto x : pattern.row(w))
        if (x != v && colours[x] != none && (colours[w] == none || colours[x] < colours[w]))
          forbid(colours[x]);
    }
    const auto is_free = [v](std::size_t forbidden) { return forbidden != v + 1; };
    const auto found = std::find_if(forbidden_for.begin(), forbidden_for.end(), is_free);
    colours[v] = static_cast<std::uint32_t>(found - forbidden_for.begin());
    if (found == forbidden_for.end()) forbidden_for.push_back(0);
  }
  return colours;
}
}  // namespace detail

/// Pattern of the second derivatives of f that may differ from 0, in both triangles, with nothing left out.
/// It is found by computing f once with numbers that track which inputs they depend on. Operations count by
/// their kind, not by their values at x: x[0] * x[1] makes these two meet, exp(x[0]) makes x[0] meet itself,
/// max(), abs() and their like make none meet. So the pattern serves every point where comparisons in f have
/// the same results. It may hold an entry too many, where terms cancel, as in (x + y)² − (x − y)², or a power
/// is 1. Time and memory grow with f and with the pattern; sums that only enter further sums cost nothing.
///
///   const HessianPlan plan(hessian_pattern(f, x));
///
/// \param f  of many numbers, as in derivatives.hpp; called with duals
/// \param x  [N]
/// \returns  a pattern of N rows
template <std::floating_point T = double, class Function>
[[nodiscard]] JacobianPattern hessian_pattern(const Function& f, Point<std::type_identity_t<T>> x) {
  using D = detail::Interacting<T>;
  detail::Interactions all;
  std::vector<D> inputs;
  inputs.reserve(x.size());
  for (const T value : x) inputs.push_back(D(value, &all, all.variable()));
  static_cast<void>(f(std::span<const D>(inputs)));
  return all.pattern();
}

/// Plan for computing a Hessian of a known pattern from few products with directions: the variables of one
/// colour are one direction. A band of half width b takes 2 b + 1 or a few more, whatever its length; an
/// arrow takes 2.
class HessianPlan {
 public:
  HessianPlan() = default;
  /// \param pattern  of either triangle or both. \throws DomainError unless it is square
  explicit HessianPlan(const JacobianPattern& pattern)
      : pattern_(detail::symmetrised(pattern)), colour_of_(detail::star_colours(pattern_)) {
    for (const std::uint32_t colour : colour_of_)
      direction_count_ = std::max<std::size_t>(direction_count_, colour + 1);
  }

  /// The pattern of both triangles.
  [[nodiscard]] const JacobianPattern& pattern() const { return pattern_; }
  /// Directions that the Hessian is multiplied by, eight of them a sweep.
  [[nodiscard]] std::size_t direction_count() const { return direction_count_; }
  /// The direction of each variable.
  [[nodiscard]] const std::vector<std::uint32_t>& colour_of() const { return colour_of_; }

 private:
  JacobianPattern pattern_;
  std::vector<std::uint32_t> colour_of_;
  std::size_t direction_count_ = 0;
};

/// The entries of the Hessian at x in the plan's pattern, in its order, row by row and in both triangles,
/// exact but for rounding, and symmetric. Each is read from the product with the direction of the lower of
/// its two colours, in the other variable's row: no other entry meets it there. Entries that the pattern
/// wrongly leaves out are added to others. Unknown entries are NaN and counted, see hessian(). Kinks on a
/// diagonal outside the pattern, as that of |x|, count, too.
///
///   HessianPlan plan(hessian_pattern(f, x));                 // once
///   const auto values = sparse_hessian(f, x, plan);          // at each x
///   plan.pattern().visit([&](auto row, auto column, auto number) { … values[number] … });
///
/// \param f     of many numbers, as in derivatives.hpp
/// \param x     [N]
/// \param plan  of a pattern of N rows
/// \throws DomainError if x has not as many numbers as the pattern rows
template <std::floating_point T = double, class Function>
[[nodiscard]] SecondDerivatives<T> sparse_hessian(const Function& f, Point<std::type_identity_t<T>> x,
                                                  const HessianPlan& plan) {
  constexpr std::size_t width = 8;
  using D = Dual<T, width, Function>;
  const auto& colours = plan.colour_of();
  detail::require_as_many("sparse_hessian", "x", x.size(), colours.size());
  std::vector<std::pair<std::size_t, std::size_t>> places;
  plan.pattern().visit([&](auto row, auto column, auto) { places.push_back({row, column}); });
  std::vector<std::array<T, width>> products(x.size());
  detail::SpareTape<D> tape;
  const auto evaluate = [&](const std::vector<T>& at) {
    detail::Curvature<T> found{T(0), std::vector<T>(at.size()), SecondDerivatives<T>(places.size())};
    for (std::size_t first = 0; first == 0 || first < plan.direction_count(); first += width) {
      const auto seed = [&](std::size_t i) {
        std::array<T, width> tangents{};
        if (const std::size_t lane = colours[i] - first; lane < width) tangents[lane] = T(1);
        return tangents;
      };
      const auto take = [&](std::size_t i, const D& adjoint) {
        found.gradient[i] = adjoint.value();
        products[i] = adjoint.tangents();
      };
      found.value = detail::sweep_duals<D>(*tape, f, std::span<const T>(at), seed, take).value();
      for (std::size_t number = 0; number < places.size(); ++number) {
        const auto [row, column] = places[number];
        const auto [low, high] =
            colours[row] < colours[column] ? std::pair(row, column) : std::pair(column, row);
        if (const std::size_t lane = colours[low] - first; lane < width)
          found.second[number] = products[high][lane];
      }
    }
    return found;
  };
  return detail::known_curvature<T>(x, evaluate, [&](std::size_t e) { return places[e]; }).second;
}
}  // namespace tapestry
