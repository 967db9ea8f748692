#include <tapestry/autodiff/compressed_jacobian.hpp>

#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/array_derivatives.hpp>
#include <tapestry/autodiff/checkpoint.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::DomainError, tapestry::JacobianPattern, tapestry::JacobianPlan, tapestry::Tape,
    tapestry::Variable, tapestry::test::ActiveTape;

namespace {
using Variables = std::vector<Variable<double>>;

[[nodiscard]] Variables inputs_of(Tape<double>& tape, std::size_t count) {
  Variables x;
  for (std::size_t i = 0; i < count; ++i)
    x.push_back(tape.input(0.3 + 0.1 * std::sin(static_cast<double>(i * i + 1))));
  return x;
}

/// Root i of x[i − 1], x[i] and x[i + 1], through intermediate results that neighbours share.
[[nodiscard]] Variables banded(const Variables& x) {
  Variables squares, roots;
  for (const auto& entry : x) squares.push_back(entry * entry);
  for (std::size_t i = 0; i < x.size(); ++i) {
    Variable<double> root = 3 * exp(x[i]);
    if (i > 0) root += squares[i - 1] * x[i];
    if (i + 1 < x.size()) root -= squares[i + 1];
    roots.push_back(root);
  }
  return roots;
}

/// Residuals of cameras (3 entries each) and points (2 each), every point seen by two cameras.
[[nodiscard]] Variables bundle(const Variables& x, std::size_t cameras, std::size_t points) {
  Variables roots;
  for (std::size_t p = 0; p < points; ++p)
    for (std::size_t view = 0; view < 2; ++view) {
      const std::size_t c = 3 * ((p + view * (1 + p % 3)) % cameras), at = 3 * cameras + 2 * p;
      const Variable<double> depth = 1 + x[c] * x[at] + x[c + 1] * x[at + 1];
      roots.push_back(sin(x[at]) / depth);
      roots.push_back(x[c + 2] * x[at + 1] / depth);
    }
  return roots;
}

/// Pixels as a rasteriser shades them: bilinear samples of a texture [side, side] at fixed places, lit.
[[nodiscard]] Variables shaded(const Variables& texture, std::size_t side, std::size_t pixels) {
  Variables roots;
  for (std::size_t i = 0; i < pixels; ++i) {
    const std::size_t u = i * 7 % (side - 1), v = i * 5 % (side - 1);
    const double a = static_cast<double>(i % 4) / 4 + 0.1, b = static_cast<double>(i % 3) / 3 + 0.1;
    const std::size_t t = v * side + u;
    roots.push_back(tanh((1 - a) * (1 - b) * texture[t] + a * (1 - b) * texture[t + 1] +
                         (1 - a) * b * texture[t + side] + a * b * texture[t + side + 1]));
  }
  return roots;
}

/// The compressed Jacobian, written out in full, beside the one found root by root.
void check_against_dense(Tape<double>& tape, const Variables& roots, const Variables& x,
                         const JacobianPlan& plan) {
  const auto& pattern = plan.pattern();
  std::vector<double> values(pattern.entry_count(), -7), full(roots.size() * x.size());
  tapestry::compressed_jacobian(tape, roots, x, plan, values);
  pattern.visit([&](std::size_t row, std::size_t column, std::size_t entry) {
    full[row * x.size() + column] = values[entry];
  });
  double worst = 0;
  for (std::size_t row = 0; row < roots.size(); ++row) {
    tape.reverse(roots[row]);
    for (std::size_t j = 0; j < x.size(); ++j)
      worst = std::max(worst, std::abs(full[row * x.size() + j] - tape.adjoint(x[j])));
  }
  CHECK(worst <= 1e-14);
}

/// No two columns of one colour meet in a row.
[[nodiscard]] bool is_valid(const JacobianPattern& pattern, const tapestry::ColumnColouring& colouring) {
  for (std::size_t row = 0; row < pattern.row_count(); ++row) {
    std::vector<std::uint32_t> seen;
    for (const auto column : pattern.row(row)) seen.push_back(colouring.colour_of[column]);
    std::sort(seen.begin(), seen.end());
    if (std::adjacent_find(seen.begin(), seen.end()) != seen.end()) return false;
  }
  return true;
}
}  // namespace

TEST_CASE("the pattern of a banded function is its band, and three directions suffice",
          "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const Variables x = inputs_of(tape, 40);
  const Variables roots = banded(x);
  const auto pattern = tapestry::sparsity_pattern<double>(tape, roots, x);
  CHECK(pattern.entry_count() == 3 * 40 - 2);
  for (std::size_t row = 0; row < 40; ++row)
    for (const auto column : pattern.row(row))
      CHECK(std::max<std::size_t>(row, column) - std::min<std::size_t>(row, column) <= 1);
  const JacobianPlan plan(pattern);
  CHECK(plan.direction_count() == 3);
  CHECK(!plan.goes_forward());  // a tie
  check_against_dense(tape, roots, x, plan);
}

TEST_CASE("a bundle adjustment's Jacobian goes forwards, in as many directions as a residual has inputs",
          "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const std::size_t cameras = 6, points = 30;
  const Variables x = inputs_of(tape, 3 * cameras + 2 * points);
  const Variables roots = bundle(x, cameras, points);
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, x));
  CHECK(plan.pattern().entry_count() == 2 * points * (4 + 5));  // sin(x)/depth needs no third camera entry
  CHECK(plan.goes_forward());
  CHECK(plan.direction_count() == 5);
  CHECK(is_valid(plan.pattern(), plan.colouring()));
  check_against_dense(tape, roots, x, plan);
}

TEST_CASE("a rasteriser's Jacobian has four texels a pixel", "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const std::size_t side = 9, pixels = 70;
  const Variables texture = inputs_of(tape, side * side);
  const Variables roots = shaded(texture, side, pixels);
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, texture));
  CHECK(plan.pattern().entry_count() == 4 * pixels);
  CHECK(plan.direction_count() < 12);
  CHECK(is_valid(plan.pattern().transposed(), plan.row_colouring()));
  check_against_dense(tape, roots, texture, plan);
}

TEST_CASE("patterns of passive, repeated and trivial roots and variables", "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  Variables x = inputs_of(tape, 3);
  const Variable<double> product = x[0] * x[1];
  x.push_back(product);  // no input
  x.push_back(x[0]);     // for the second time
  x.push_back(2.0);      // passive
  const Variables roots = {product * x[2], x[1], 5.0, product * x[2], 0.0 * x[2] + product, max(x[0], x[2])};
  const auto pattern = tapestry::sparsity_pattern<double>(tape, roots, x);
  const auto row = [&](std::size_t i) {
    return std::vector<std::uint32_t>(pattern.row(i).begin(), pattern.row(i).end());
  };
  CHECK(row(0) == std::vector<std::uint32_t>{0, 1, 2, 3, 4});
  CHECK(row(1) == std::vector<std::uint32_t>{1});
  CHECK(row(2).empty());
  CHECK(row(3) == row(0));
  CHECK(row(4) == std::vector<std::uint32_t>{0, 1, 2, 3, 4});      // a partial derivative of 0 counts
  CHECK(row(5).size() == (x[0].value() >= x[2].value() ? 2 : 1));  // the side taken
  check_against_dense(tape, roots, x, JacobianPlan(pattern));

  const auto none = tapestry::sparsity_pattern<double>(tape, {}, {});
  CHECK(none.entry_count() == 0);
  CHECK(JacobianPlan(none).direction_count() == 0);
}

TEST_CASE("a dense row makes rows of one colour few and columns many", "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const Variables x = inputs_of(tape, 20);
  Variables roots;
  Variable<double> total = 0.0;
  for (const auto& entry : x) {
    roots.push_back(log(entry));
    total += entry * entry;
  }
  roots.push_back(total);
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, x));
  CHECK(!plan.goes_forward());
  CHECK(plan.direction_count() == 2);  // forwards it would be 20
  check_against_dense(tape, roots, x, plan);
}

TEST_CASE("a pattern made by hand is sorted, and one entry too many does no harm", "[autodiff][sparsity]") {
  const JacobianPattern pattern(3, 4, {{2, 1}, {0, 3}, {2, 0}, {0, 3}, {1, 2}});
  CHECK(pattern.entry_count() == 4);
  CHECK(pattern.row(2)[0] == 0);
  CHECK(pattern.transposed().transposed() == pattern);
  CHECK(pattern.transposed() == JacobianPattern(4, 3, {{0, 2}, {1, 2}, {2, 1}, {3, 0}}));
  ActiveTape<double> tape;
  const Variables x = inputs_of(tape, 4);
  const Variables roots = {x[3] * x[3], 2 * x[2], x[1]};  // all of the pattern but (2, 0)
  std::vector<double> values(4);
  tapestry::compressed_jacobian(tape, roots, x, JacobianPlan(pattern), values);
  CHECK(values == std::vector<double>{2 * x[3].value(), 2, 0, 1});
}

TEST_CASE("tapes longer than one piece of memory are swept forwards, too", "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const Variables x = inputs_of(tape, 2);
  Variables roots = {x[0], x[1]};
  for (int i = 0; i < 300000; ++i) roots[0] = 0.5 * roots[0] + 0.5 * x[0];
  for (std::size_t k = 0; k < 20; ++k) roots.push_back(roots[0] * x[0]);  // columns are cheaper
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, x));
  CHECK(plan.goes_forward());
  check_against_dense(tape, roots, x, plan);
}

TEST_CASE("the compressed Jacobian of arrays, of a pattern made by hand", "[autodiff][sparsity]") {
  const std::size_t n = 30;
  tapestry::Array<double, 1> start(tapestry::Extents<1>{n});
  for (std::size_t i = 0; i < n; ++i) start(i) = 0.1 * static_cast<double>(i);
  ActiveTape<double> tape;
  const auto x = tape.input(start);
  tapestry::Array<double, 1> value(tapestry::Extents<1>{n - 2});
  std::vector<JacobianPattern::Entry> entries;
  for (std::size_t i = 0; i + 2 < n; ++i) {
    value(i) = start(i) * start(i + 2);
    entries.push_back({i, i});
    entries.push_back({i, i + 2});
  }
  int sweeps = 0;
  const auto pullback = [&](const tapestry::Array<double, 1>& g, tapestry::Array<double, 1>* x_adjoint) {
    ++sweeps;
    for (std::size_t i = 0; i + 2 < n; ++i) {
      (*x_adjoint)(i) += g(i) * start(i + 2);
      (*x_adjoint)(i + 2) += g(i) * start(i);
    }
  };
  const tapestry::ArrayVariable<double, 1> root = tapestry::record_array(value, pullback, x);
  const JacobianPlan plan(JacobianPattern(n - 2, n, entries));
  std::vector<double> values(entries.size());
  tapestry::compressed_jacobian(tape, root, x, plan, values);
  CHECK(sweeps == 2);
  for (std::size_t i = 0; i + 2 < n; ++i) {
    CHECK(values[2 * i] == start(i + 2));
    CHECK(values[2 * i + 1] == start(i));
  }
  CHECK_THROWS_WITH(tapestry::compressed_jacobian(tape, x, x, plan, values),
                    "compressed_jacobian: 30 roots and 30 variables, expected 28 and 30");
}

TEST_CASE("results of an operation with a pullback depend on all of its inputs", "[autodiff][sparsity]") {
  ActiveTape<double> tape;
  const Variables x = inputs_of(tape, 12);
  Variables roots;
  const auto pair = [](std::span<const Variable<double>> s) { return Variables{s[0] * s[1], sin(s[1])}; };
  for (std::size_t i = 0; i < 12; i += 2) {
    const Variables results = tapestry::checkpoint<double>(pair, Variables{exp(x[i]), x[i + 1] * x[i + 1]});
    for (int repeat = 0; repeat < 10; ++repeat) roots.push_back(results[0] * results[1]);
    roots.push_back(results[1]);  // not of x[i], but that is hidden from the tape
    roots.push_back(x[i]);
  }
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, x));
  CHECK(plan.pattern().entry_count() == 6 * (11 * 2 + 1));
  CHECK(plan.goes_forward());  // but pullbacks go backwards
  check_against_dense(tape, roots, x, plan);

  const auto array = tape.input(tapestry::Array<double, 1>{1.0, 2.0});
  const auto total = tapestry::record_scalar(
      3.0 + x[0].value(), [](double, tapestry::Array<double, 1>*, double*) {}, array, x[0]);
  CHECK(tapestry::sparsity_pattern<double>(tape, Variables{total, x[1]}, x).row(0).size() == 1);
}

TEST_CASE("compressed Jacobians name what does not fit", "[autodiff][sparsity]") {
  CHECK_THROWS_WITH(JacobianPattern(2, 3, {{1, 3}}),
                    "JacobianPattern: entry (1, 3) of a matrix of 2 rows and 3 columns");
  Tape<double> tape, other;
  const auto scope = tape.activate();
  const Variables x = inputs_of(tape, 4), foreign = inputs_of(other, 4);
  const Variables roots = banded(x);
  const JacobianPlan plan(tapestry::sparsity_pattern<double>(tape, roots, x));
  std::vector<double> values(plan.pattern().entry_count());
  const auto compress = [&](const Variables& r, const Variables& v, std::size_t count) {
    tapestry::compressed_jacobian(tape, r, v, plan, std::span<double>(values).first(count));
  };
  CHECK_THROWS_WITH(compress({x[0]}, x, values.size()),
                    "compressed_jacobian: 1 roots and 4 variables, expected 4 and 4");
  CHECK_THROWS_WITH(compress(roots, x, 3), "compressed_jacobian: room for 3 entries, expected 10");
  CHECK_THROWS_AS(compress(roots, foreign, values.size()), DomainError);
  CHECK_THROWS_AS(compress(foreign, x, values.size()), DomainError);
  CHECK_THROWS_AS(tapestry::sparsity_pattern<double>(tape, roots, foreign), DomainError);
  tape.clear();
  CHECK_THROWS_AS(compress(roots, x, values.size()), DomainError);
}
