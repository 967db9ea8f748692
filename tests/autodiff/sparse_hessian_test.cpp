#include <tapestry/autodiff/sparse_hessian.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/core/random.hpp>
#include <utility>
#include <vector>

#include "../support/catch.hpp"

using tapestry::DomainError;
using tapestry::HessianPlan;
using tapestry::JacobianPattern;
using tapestry::sparse_hessian;

namespace {
using Entries = std::vector<JacobianPattern::Entry>;

/// Σ over the edges of x[i]² x[j] + sin(x[i] x[j]), and of every variable alone its exponential.
struct OverEdges {
  Entries edges;
  template <class S>
  S operator()(std::span<const S> x) const {
    S sum = 0;
    for (const auto& [i, j] : edges) sum += x[i] * x[i] * x[j] + sin(x[i] * x[j]);
    for (const S& each : x) sum += exp(each);
    return sum;
  }
};

Entries with_diagonal(Entries edges, std::size_t n) {
  for (std::size_t i = 0; i < n; ++i) edges.push_back({i, i});
  return edges;
}
Entries band(std::size_t n, std::size_t half_width) {
  Entries edges;
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j <= i + half_width && j < n; ++j) edges.push_back({i, j});
  return edges;
}
std::vector<double> some_point(std::size_t n) {
  std::vector<double> x;
  for (std::size_t i = 0; i < n; ++i) x.push_back(std::cos(static_cast<double>(i * i + 1)));
  return x;
}

/// Every entry, and no other, is as in the dense Hessian.
HessianPlan check_against_dense(const Entries& edges, std::size_t n) {
  const OverEdges f{edges};
  const auto x = some_point(n);
  const HessianPlan plan(JacobianPattern(n, n, with_diagonal(edges, n)));
  const auto values = sparse_hessian(f, x, plan);
  auto dense = tapestry::hessian(f, x);
  plan.pattern().visit([&](std::size_t row, std::size_t column, std::size_t number) {
    CHECK(std::abs(values[number] - dense[row * n + column]) <= 1e-13);
    dense[row * n + column] = 0;
  });
  CHECK(std::all_of(dense.begin(), dense.end(), [](double rest) { return rest == 0; }));
  return plan;
}
}  // namespace

TEST_CASE("bands take as many directions as they are wide, whatever their length", "[autodiff][hessian]") {
  CHECK(check_against_dense(band(40, 1), 40).direction_count() == 3);
  CHECK(check_against_dense(band(60, 2), 60).direction_count() <= 6);
  const std::size_t many = check_against_dense(band(90, 6), 90).direction_count();
  CHECK(many > 8);  // more than one sweep
  CHECK(HessianPlan(JacobianPattern(20000, 20000, band(20000, 6))).direction_count() <= many + 2);
}

TEST_CASE("an arrow takes two directions, where columns that share no row would take all",
          "[autodiff][hessian]") {
  Entries first, last;
  for (std::size_t i = 1; i < 30; ++i) first.push_back({0, i});
  for (std::size_t i = 0; i < 29; ++i) last.push_back({29, i});
  CHECK(check_against_dense(first, 30).direction_count() == 2);
  CHECK(check_against_dense(last, 30).direction_count() == 2);
}

TEST_CASE("random patterns have the entries of the dense Hessian", "[autodiff][hessian]") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    tapestry::Random random(seed);
    Entries edges;
    for (std::size_t i = 0; i < 25; ++i)
      for (std::size_t j = 0; j < i; ++j)
        if (random.uniform(0, 1) < 0.02 * static_cast<double>(seed)) edges.push_back({i, j});
    check_against_dense(edges, 25);
  }
}

TEST_CASE("no variables, one, and none that interact are sparse Hessians, too", "[autodiff][hessian]") {
  CHECK(check_against_dense({}, 0).direction_count() == 0);
  CHECK(check_against_dense({}, 1).direction_count() == 1);
  CHECK(check_against_dense({}, 20).direction_count() == 1);
  CHECK(check_against_dense({{1, 0}}, 2).direction_count() == 2);
}

TEST_CASE("a pattern that does not fit is refused", "[autodiff][hessian]") {
  CHECK_THROWS_WITH(HessianPlan(JacobianPattern(2, 3, {})),
                    "HessianPlan: a pattern of 2 rows and 3 columns, expected a square one");
  const HessianPlan plan(JacobianPattern(2, 2, {{0, 1}}));
  CHECK_THROWS_AS(sparse_hessian(OverEdges{}, std::vector<double>{1.0}, plan), DomainError);
}
