#include <tapestry/autodiff/sparse_hessian.hpp>

#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

using tapestry::DomainError, tapestry::HessianPlan, tapestry::JacobianPattern, tapestry::sparse_hessian;

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
  const auto found = HessianPlan(tapestry::hessian_pattern(f, x)).pattern();
  CHECK(found == HessianPlan(JacobianPattern(n, n, with_diagonal(edges, n))).pattern());
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

namespace {
/// Rows of a pattern as text, such as "01.1." for two rows.
std::string text_of(const JacobianPattern& pattern) {
  std::string text;
  for (std::size_t i = 0; i < pattern.row_count(); ++i) {
    for (const auto j : pattern.row(i)) text += std::to_string(j);
    text += '.';
  }
  return text;
}
template <class Function>
std::string found_pattern(const Function& f, std::size_t n, double at = 0.7) {
  return text_of(tapestry::hessian_pattern(f, std::vector<double>(n, at)));
}
}  // namespace

TEST_CASE("a pattern tells which variables meet in operations that are not linear", "[autodiff][hessian]") {
  using tapestry::hypot;
  CHECK(found_pattern([](auto x) { return x[0] * x[1] + 2 * x[2]; }, 3) == "1.0..");
  CHECK(found_pattern([](auto x) { return x[0] / x[1]; }, 2) == "1.01.");
  CHECK(found_pattern([](auto x) { return (x[0] - x[1]) / 3; }, 2) == "..");
  CHECK(found_pattern([](auto x) { return max(x[0], abs(x[1])) * x[2]; }, 3) == "2.2.01.");
  CHECK(found_pattern([](auto x) { return fma(x[0], x[1], sin(x[2])); }, 3) == "1.0.2.");
  CHECK(found_pattern([](auto x) { return lerp(x[0], x[1], x[2]); }, 3) == "2.2.01.");
  CHECK(found_pattern([](auto x) { return hypot(x[0], x[1], x[2]); }, 3) == "012.012.012.");
  CHECK(found_pattern([](auto x) { return atan2(x[0], x[1]) + pow(x[2], 3); }, 3) == "01.01.2.");
  CHECK(found_pattern([](auto x) { return exp(2 * (x[0] + x[2])) - x[1]; }, 3) == "02..02.");
  CHECK(found_pattern([](auto x) { return x[0] * 0.0; }, 1) == ".");
  CHECK(found_pattern([](auto) { return 5.0; }, 1) == ".");
  CHECK(found_pattern([](auto x) { return -x[0]; }, 1) == ".");
  const auto updated = []<class S>(std::span<const S> x) {
    S y = x[0];
    y *= x[1];
    y -= 4;
    ++y;
    y /= x[2];
    return y;
  };
  CHECK(found_pattern(updated, 3) == "12.02.012.");
}

TEST_CASE("a pattern holds where second derivatives happen to be zero", "[autodiff][hessian]") {
  CHECK(found_pattern([](auto x) { return sin(x[0]) + x[1] * x[1] * x[2]; }, 3, 0.0) == "0.12.1.");
}

TEST_CASE("a derivative inside of the function counts", "[autodiff][hessian]") {
  const auto f = []<class S>(std::span<const S> x) {
    const auto inner = [](const auto& z) { return tanh(z) * z; };
    return x[0] * tapestry::derivative(inner, x[1]).derivative;
  };
  CHECK(found_pattern(f, 2) == "1.01.");
}

TEST_CASE("steps that each use the last one's results have patterns in the time of the steps",
          "[autodiff][hessian]") {
  const auto f = []<class S>(std::span<const S> x) {
    S state = x[0];
    for (int i = 0; i < 200000; ++i) state = sin(state + x[1]);
    return state;
  };
  CHECK(found_pattern(f, 3) == "01.01..");
}

TEST_CASE("a long banded problem has its band", "[autodiff][hessian][repeated]") {
  const std::size_t n = 100000;
  const OverEdges f{band(n, 2)};
  const auto pattern = tapestry::hessian_pattern(f, some_point(n));
  CHECK(pattern.entry_count() == 5 * n - 6);
  for (std::size_t i = 2; i + 2 < n; i += 997) {
    CHECK(pattern.row(i).front() == i - 2);
    CHECK(pattern.row(i).back() == i + 2);
  }
}
