#include <random>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/record.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"

using tapestry::AdjointVectors, tapestry::DomainError, tapestry::Tape, tapestry::Variable,
    tapestry::test::ActiveTape;

namespace {
/// A program of linear statements of all frequent kinds, and the same program as a list of its own. Operands
/// are drawn from few, so that they meet in one statement and from one statement to the next.
class LinearProgram {
 public:
  LinearProgram(std::size_t input_count, std::size_t statement_count, std::size_t reach, unsigned seed)
      : reach_(reach), generator_(seed) {
    for (std::size_t i = 0; i < input_count; ++i) add(tape_.input(1.0), {});
    const auto scope = tape_.activate();
    while (variables_.size() < input_count + statement_count) {
      const std::size_t like = draw(9);
      for (std::size_t run = draw(6); run > 0; --run) add_statement(like);
      if (draw(20) == 0) add(tape_.input(1.0), {});
    }
  }

  struct Adjoints {
    std::vector<long double> values;
    std::vector<long double> magnitudes;  ///< the same sums of absolute terms
  };
  [[nodiscard]] Adjoints adjoints(std::size_t root) const {
    Adjoints result{std::vector<long double>(variables_.size()), std::vector<long double>(variables_.size())};
    result.values[root] = result.magnitudes[root] = 1;
    for (std::size_t i = root + 1; i-- > 0;)
      for (const auto& [operand, partial] : operands_[i]) {
        result.values[operand] += static_cast<long double>(partial) * result.values[i];
        result.magnitudes[operand] += std::abs(static_cast<long double>(partial)) * result.magnitudes[i];
      }
    return result;
  }

  [[nodiscard]] Tape<double>& tape() { return tape_; }
  [[nodiscard]] const std::vector<Variable<double>>& variables() const { return variables_; }

 private:
  struct Operand {
    std::size_t index;
    double partial;
  };

  [[nodiscard]] std::size_t draw(std::size_t count) {
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(generator_);
  }
  /// Mostly one of the last, or of the first few.
  [[nodiscard]] std::size_t draw_variable() {
    const std::size_t count = variables_.size();
    const std::size_t back = draw(4) == 0 ? draw(reach_) : draw(4);
    return back < count ? count - 1 - back : draw(count < 3 ? count : 3);
  }
  void add(const Variable<double>& variable, std::vector<Operand> operands) {
    variables_.push_back(variable);
    operands_.push_back(std::move(operands));
  }

  void add_statement(std::size_t like) {
    const std::size_t i = draw_variable(), j = draw(3) == 0 ? i : draw_variable();
    const std::size_t k = draw(2) == 0 ? held_ : (held_ = draw_variable()), l = draw_variable();
    const auto& v = variables_;
    const Variable<double> a = v[i], b = v[j], c = v[k], d = v[l];
    if (like == 0) add(a + b, {{i, 1}, {j, 1}});
    if (like == 1) add(a - c, {{i, 1}, {k, -1}});
    if (like == 2) add(-c, {{k, -1}});
    if (like == 3) add(a + 0.5 * c, {{i, 1}, {k, 0.5}});
    if (like == 4) add(0.75 * c - a, {{k, 0.75}, {i, -1}});
    if (like == 5) add(0.5 * b - 0.25 * c, {{j, 0.5}, {k, -0.25}});
    if (like == 6) add(a + 0.5 * b + 0.25 * c, {{i, 1}, {j, 0.5}, {k, 0.25}});
    if (like == 7) add(a + b - 0.5 * c, {{i, 1}, {j, 1}, {k, -0.5}});
    if (like == 8)
      add(d - 0.5 * a + 0.25 * b - 0.5 * c - 0.25 * d, {{l, 1}, {i, -0.5}, {j, 0.25}, {k, -0.5}, {l, -0.25}});
  }

  std::size_t reach_;
  std::mt19937 generator_;
  Tape<double> tape_;
  std::vector<Variable<double>> variables_;
  std::vector<std::vector<Operand>> operands_;
  std::size_t held_ = 0;
};

/// A sum of n terms of relative error (n + 2) · ε each, over a chain of statements.
constexpr double tolerance = 1e-12;
}  // namespace

TEST_CASE("statements of all kinds, with operands in common, have the adjoints of a plain list",
          "[autodiff][reverse_sweep]") {
  for (unsigned seed = 0; seed < 200; ++seed) {
    LinearProgram program(3, 60, 12, seed);
    const std::size_t root = program.variables().size() - 1;
    program.tape().reverse(program.variables()[root]);
    const auto expected = program.adjoints(root);
    for (std::size_t i = 0; i <= root; ++i) {
      INFO("seed " << seed << ", statement " << i);
      CHECK(std::abs(program.tape().adjoint(program.variables()[i]) -
                     static_cast<double>(expected.values[i])) <=
            tolerance * static_cast<double>(expected.magnitudes[i]));
    }
  }
}

TEMPLATE_TEST_CASE_SIG("adjoints of many roots are kept beyond the window of the sweep",
                       "[autodiff][reverse_sweep]", ((std::size_t Width), Width), 2, 8, 64) {
  for (const bool keeps_all : {true, false}) {
    LinearProgram program(150, 20'000, 6'000, 7);  // the window is of 8,192, 2,048 and 256 statements
    const auto& variables = program.variables();
    std::vector<Variable<double>> roots;
    std::vector<std::size_t> places;
    for (std::size_t k = 0; k < Width; ++k) places.push_back(variables.size() - 1 - k * 5);
    for (const std::size_t place : places) roots.push_back(variables[place]);
    const std::vector<Variable<double>> kept(variables.begin(), variables.begin() + 150);
    AdjointVectors<double, Width> adjoints;
    for (int again = 0; again < 2; ++again) {
      if (keeps_all)
        adjoints.reverse(program.tape(), roots);
      else
        adjoints.reverse(program.tape(), roots, kept);
    }
    for (std::size_t k = 0; k < Width; k += 7) {
      const auto expected = program.adjoints(places[k]);
      std::size_t wrong = 0;
      for (std::size_t i = 0; i < (keeps_all ? variables.size() : kept.size()); ++i)
        wrong += !(std::abs(adjoints.of(variables[i])[k] - static_cast<double>(expected.values[i])) <=
                   tolerance * static_cast<double>(expected.magnitudes[i]));
      CHECK(wrong == 0);
    }
    if (!keeps_all) CHECK_THROWS_AS(adjoints.of(variables[10'000]), DomainError);
  }
}

TEST_CASE("roots that are inputs, and roots before others, have adjoints of many roots",
          "[autodiff][reverse_sweep]") {
  ActiveTape<double> tape;
  std::vector<Variable<double>> x(300);
  tape.input(std::vector<double>(300, 2.0), x);
  const Variable<double> y = x[7] * x[299];
  const Variable<double> later = y * y;
  AdjointVectors<double, 4> adjoints;
  adjoints.reverse(tape, std::vector<Variable<double>>{x[7], x[299]});
  CHECK(adjoints.of(x[7]) == std::array<double, 4>{1, 0, 0, 0});
  CHECK(adjoints.of(x[299]) == std::array<double, 4>{0, 1, 0, 0});
  CHECK(adjoints.of(y) == std::array<double, 4>{});
  adjoints.reverse(tape, std::vector<Variable<double>>{y, x[7], later}, x);
  CHECK(adjoints.of(x[7]) == std::array<double, 4>{2, 1, 16, 0});
  CHECK(adjoints.of(x[299]) == std::array<double, 4>{2, 0, 16, 0});
  CHECK(adjoints.of(x[100]) == std::array<double, 4>{});
}

TEST_CASE("adjoints that cancel far from where they began are zero", "[autodiff][reverse_sweep]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const auto skip = [&](int count) {
    for (int i = 0; i < count; ++i) static_cast<void>(Variable<double>(x * 1.5));
  };
  skip(68);
  const Variable<double> v = 2 * x;
  skip(70);
  const Variable<double> w = -v;
  skip(3000);  // v is then behind the window, w is read in it
  const Variable<double> u = v + x;
  const Variable<double> root = u + w;
  AdjointVectors<double, 8> adjoints;
  adjoints.reverse(tape, std::vector<Variable<double>>{root});
  CHECK(adjoints.of(v)[0] == 0);
  CHECK(adjoints.of(w)[0] == 1);
  CHECK(adjoints.of(x)[0] == 1);
}

TEST_CASE("adjoints of many roots may be moved, and what is left used again", "[autodiff][reverse_sweep]") {
  LinearProgram large(3, 5000, 12, 1), small(3, 10, 5, 2);
  const auto root_of = [](const LinearProgram& program) {
    return std::vector<Variable<double>>{program.variables().back()};
  };
  AdjointVectors<double, 8> a, b;
  a.reverse(large.tape(), root_of(large));
  b.reverse(small.tape(), root_of(small));
  const double expected = a.of(large.variables()[0])[0];
  b = std::move(a);
  CHECK(b.of(large.variables()[0])[0] == expected);
  a.reverse(large.tape(), root_of(large));
  CHECK(a.of(large.variables()[0])[0] == expected);
  AdjointVectors<double, 8> c = std::move(a);
  a.reverse(large.tape(), root_of(large));
  CHECK(a.of(large.variables()[0])[0] == expected);
  CHECK(c.of(large.variables()[0])[0] == expected);
}

TEST_CASE("zeros pass nothing in programs whose adjoints become infinite and NaN",
          "[autodiff][reverse_sweep]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::array<double, 6> slopes = {0, 1, infinity, -2, -1, 0.5};
  std::size_t nans = 0, zeros = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937_64 random(seed);
    ActiveTape<double> tape;
    std::vector<Variable<double>> all = {tape.input(1.0), tape.input(1.0)};
    std::vector<std::vector<std::pair<std::size_t, double>>> operands(2);
    while (all.size() < 24) {
      std::vector<Variable<double>> of;
      std::vector<double> by;
      operands.emplace_back();
      for (std::size_t count = 1 + random() % 3; count > 0; --count) {
        const std::size_t operand = all.size() - 1 - random() % std::min<std::size_t>(all.size(), 5);
        of.push_back(all[operand]);
        by.push_back(slopes[random() % slopes.size()]);
        operands.back().emplace_back(operand, by.back());
      }
      all.push_back(tapestry::record_partials<double>(1.0, of, by));
    }
    std::vector<double> expected(all.size());
    expected.back() = 1;
    for (std::size_t i = all.size(); i-- > 0;)
      for (const auto& [operand, slope] : operands[i])
        if (expected[i] != 0 && slope != 0) expected[operand] += expected[i] * slope;
    tape.reverse(all.back());
    for (std::size_t i = 0; i < all.size(); ++i) {
      INFO("seed " << seed << ", statement " << i);
      CHECK((all[i].adjoint() == expected[i] || (std::isnan(all[i].adjoint()) && std::isnan(expected[i]))));
    }
    nans += static_cast<std::size_t>(std::isnan(expected[0]));
    zeros += static_cast<std::size_t>(!std::isnan(expected[0]));
  }
  CHECK(nans > 20);
  CHECK(zeros > 20);
}

TEST_CASE("a pullback is called again only where its tape's sweep has left NaN",
          "[autodiff][reverse_sweep]") {
  int calls = 0;
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(3.0);
  const Variable<double> y = tapestry::record_scalar(
      2.0,
      [&calls](double adjoint, double* to) {
        ++calls;
        *to += 5 * adjoint;
      },
      x);
  const auto scaled = [&y](double slope) {
    return tapestry::record_partials<double>(0.0, std::array{y}, std::array{slope});
  };
  const auto root_of = [](const Variable<double>& of, double slope) {
    return tapestry::record_partials<double>(slope, std::array{of}, std::array{slope});
  };
  const Variable<double> finite = scaled(2), none = scaled(0);
  const Variable<double> infinite = root_of(none, std::numeric_limits<double>::infinity());
  const Variable<double> nan = root_of(none, std::nan(""));
  std::feclearexcept(FE_ALL_EXCEPT);
  tape.reverse(finite);
  CHECK(calls == 1);
  CHECK(x.adjoint() == 10);
  tape.reverse(nan);
  CHECK(calls == 2);  // once with NaN; with a zero adjoint it is not called
  CHECK(x.adjoint() == 0);
  tape.reverse(infinite);
  CHECK(calls == 3);
  CHECK(x.adjoint() == 0);
  tape.reverse(finite);  // the processor remembers an invalid operation, but no adjoint is NaN
  CHECK(calls == 4);
  CHECK(x.adjoint() == 10);
  tape.reverse(nan);
  CHECK(calls == 5);
  CHECK(x.adjoint() == 0);
}
