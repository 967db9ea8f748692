#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <stdexcept>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/replay.hpp>
#include <vector>

#include "../support/catch.hpp"

using tapestry::DomainError;
using tapestry::Guards;
using tapestry::Replay;
using tapestry::Replayable;
using tapestry::Tape;
using tapestry::Variable;

namespace {
/// Many operations of many types, some of them in long rows, with passive variables among them.
const auto objective = [](const auto* x) {
  using S = std::remove_cvref_t<decltype(*x)>;
  const S frozen = 0.25;
  S sum = 0;
  std::vector<S> y(40);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] = exp(frozen * x[i % 4]) - x[(i + 1) % 4] / 3;
  for (std::size_t round = 0; round < 200; ++round)
    for (std::size_t i = 0; i < y.size(); ++i) {
      y[i] = tanh(y[i]) * 0.75 + 0.5 * y[(i + 1) % y.size()] - frozen;
      sum += y[i] * x[i % 4] - max(y[i], x[0]) + abs(-x[1] + y[i]);
    }
  S product = sum - x[3] + x[0];
  product *= hypot(x[0], x[2]);
  return log(1 + product * product) + sqrt(square(x[2])) * pow(x[0], 2);
};
}  // namespace

TEST_CASE("a replay has the values and gradients of the tape at other inputs", "[autodiff][replay]") {
  Replay<double> replay(objective, std::vector<double>{0.5, -0.25, 1, 2});
  CHECK(replay.statement_count() > 16000);
  CHECK(replay.run_count() < replay.statement_count() / 8);
  for (const auto& values : std::vector<std::vector<double>>{
           {0.5, -0.25, 1, 2}, {1.5, 0.75, -0.5, 1}, {0.125, 2, 3, -1}, {0.5, -0.25, 1, 2}}) {
    Tape<double> tape;
    const auto scope = tape.activate();
    std::vector<Variable<double>> x(4);
    tape.input(values, x);
    const Variable<double> root = objective(x.data());
    tape.reverse(root);
    std::vector<double> gradient(4);
    CHECK(replay.gradient(values, gradient) == root.value());
    for (std::size_t i = 0; i < 4; ++i)  // the same terms, about 10⁴ of them, in another order
      CHECK(std::abs(gradient[i] - x[i].adjoint()) <= 1e-11 * (1 + std::abs(x[i].adjoint())));
    CHECK(replay.value(values) == root.value());
  }
}

TEST_CASE("a copy of a replay has values of its own, also where the recording took several windows",
          "[autodiff][replay]") {
  const std::vector<double> at = {0.5, -0.25, 1, 2}, elsewhere = {1.5, 0.75, -0.5, 1};
  const auto gradient_of = [](Replay<double>& replay, const std::vector<double>& x) {
    std::vector<double> gradient(4);
    gradient.push_back(replay.gradient(x, gradient));
    return gradient;
  };
  std::vector<double> first, second;
  Replay<double> copy([](const auto* x) { return x[0]; }, at);
  {
    Replay<double> original(objective, at);
    first = gradient_of(original, at);
    copy = original;
    second = gradient_of(original, elsewhere);
    CHECK(gradient_of(copy, at) == first);
  }
  CHECK(gradient_of(copy, elsewhere) == second);  // what they share outlives the original
  CHECK(gradient_of(copy, at) == first);
}

TEST_CASE("a replay refuses inputs for which a comparison comes out otherwise", "[autodiff][replay]") {
  const auto branch = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    const S y = x[0] * x[0];
    return y > x[1] + 1 ? S(y * x[1]) : S(x[1] - y);
  };
  Replay<double> guarded(branch, std::vector<double>{2, 1});
  std::vector<double> gradient(2);
  CHECK(guarded.gradient(std::vector<double>{3, 1}, gradient) == 9);
  CHECK(gradient == std::vector<double>{6, 9});
  CHECK_THROWS_WITH(guarded.gradient(std::vector<double>{1, 1}, gradient),
                    "Replay: the comparison of 1 with 2 comes out otherwise than when it was recorded; "
                    "record again for these inputs");
  CHECK_THROWS_AS(guarded.value(std::vector<double>{std::numeric_limits<double>::quiet_NaN(), 1}),
                  DomainError);
  CHECK(guarded.gradient(std::vector<double>{-3, 1}, gradient) == 9);  // stays usable
  Replay<double> ignoring(branch, std::vector<double>{2, 1}, Guards::ignore);
  CHECK(ignoring.gradient(std::vector<double>{1, 1}, gradient) == 1);  // of the branch taken when recorded
  CHECK(ignoring.statement_count() == guarded.statement_count() - 1);
}

TEST_CASE("chains of statements, each of which updates the result before, replay", "[autodiff][replay]") {
  // each fits the chain, but for where it reads the result twice, or an older one, or costs more
  const auto chains = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    S sum = 0, product = 1, twice = x[0], older = x[1], costly = x[2];
    for (std::size_t i = 0; i < 50; ++i) sum += x[i % 3];
    for (std::size_t i = 0; i < 50; ++i) product *= x[i % 3];
    for (std::size_t i = 0; i < 50; ++i) twice = twice + 0.125 * twice * x[i % 3];
    S before = older;
    for (std::size_t i = 0; i < 50; ++i) {
      const S next = older + 0.125 * before;
      before = older;
      older = next;
    }
    const S half = costly;
    for (std::size_t i = 0; i < 50; ++i) costly = costly - exp(-x[i % 3]);
    for (std::size_t i = 0; i < 20; ++i) costly -= costly * 0.5 * half;
    return std::vector<S>{sum, product, twice, older, costly, sum + product * twice - older * costly};
  };
  for (std::size_t root = 0; root < 6; ++root) {
    const auto function = [&](const auto* x) { return chains(x)[root]; };
    Replay<double> replay(function, std::vector<double>{1, 1, 1});
    for (const auto& values : std::vector<std::vector<double>>{{1.125, 0.75, 1.5}, {0, 2, -1}, {1, 0.5, 1}}) {
      Tape<double> tape;
      const auto scope = tape.activate();
      std::vector<Variable<double>> x(3);
      tape.input(values, x);
      const Variable<double> expected = function(x.data());
      tape.reverse(expected);
      std::vector<double> gradient(3);
      for (int again = 0; again < 2; ++again) CHECK(replay.gradient(values, gradient) == expected.value());
      for (std::size_t i = 0; i < 3; ++i)  // sums of 50 terms and fewer
        CHECK(std::abs(gradient[i] - x[i].adjoint()) <= 1e-13 * (1 + std::abs(x[i].adjoint())));
    }
  }
}

TEST_CASE("a comparison with NaN is another one than any between numbers", "[autodiff][replay]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto larger = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    return x[0] > x[1] ? S(x[0]) : S(x[1]);
  };
  for (const auto& recorded : std::vector<std::vector<double>>{{1, 2}, {2, 1}, {1, 1}, {nan, 1}}) {
    Replay<double> replay(larger, recorded);
    for (const auto& values : std::vector<std::vector<double>>{{3, 4}, {4, 3}, {3, 3}, {nan, 3}, {3, nan}}) {
      const auto order = [](const std::vector<double>& v) { return v[0] <=> v[1]; };
      if (order(values) == order(recorded))
        CHECK_NOTHROW(replay.value(values));
      else
        CHECK_THROWS_AS(replay.value(values), DomainError);
    }
  }
}

TEST_CASE("min, max and abs follow their arguments in a replay", "[autodiff][replay]") {
  Replay<double> replay([](const auto* x) { return max(x[0], x[1]) + 3 * abs(x[0]); },
                        std::vector<double>{2, 1});
  std::vector<double> gradient(2);
  CHECK(replay.gradient(std::vector<double>{-2, 5}, gradient) == 11);
  CHECK(gradient == std::vector<double>{-3, 1});
}

TEST_CASE("a zero adjoint passes no infinite partial in a replay", "[autodiff][replay]") {
  Replay<double> replay(
      [](const auto* x) {
        using S = std::remove_cvref_t<decltype(*x)>;
        const S root = sqrt(x[0]);
        return S(0 * root + x[0] + 0 * sqrt(x[0]));
      },
      std::vector<double>{1});
  std::vector<double> gradient(1);
  CHECK(replay.gradient(std::vector<double>{0}, gradient) == 0);
  CHECK(gradient[0] == 1);
}

TEST_CASE("the side that min() does not take passes no infinite partial within a formula in a replay",
          "[autodiff][replay]") {
  Replay<double> replay([](const auto* x) { return 2 * min(x[0], x[1] / x[2]) + x[1]; },
                        std::vector<double>{1, 1, 0.5});
  std::vector<double> gradient(3);
  CHECK(replay.gradient(std::vector<double>{3, 1, 0}, gradient) == 7);
  CHECK(gradient == std::vector<double>{2, 1, 0});
  CHECK(replay.gradient(std::vector<double>{3, 1, 1}, gradient) == 3);
  CHECK(gradient == std::vector<double>{0, 3, -2});
  CHECK(std::isnan(
      replay.gradient(std::vector<double>{3, 1, std::numeric_limits<double>::quiet_NaN()}, gradient)));
  CHECK(std::isnan(gradient[2]));  // a real NaN stays one
}

TEST_CASE("functions without a formula, or of nothing, replay", "[autodiff][replay]") {
  Replay<float> identity([](const auto* x) { return x[1]; }, std::vector<float>{1, 2});
  std::vector<float> gradient(2);
  CHECK(identity.gradient(std::vector<float>{5, 6}, gradient) == 6);
  CHECK(gradient == std::vector<float>{0, 1});
  Replay<float> constant([](const auto*) { return 7; }, std::vector<float>{1, 2});
  CHECK(constant.gradient(std::vector<float>{5, 6}, gradient) == 7);
  CHECK(gradient == std::vector<float>{0, 0});
  CHECK_THROWS_WITH(constant.value(std::vector<float>{1}), "Replay: 1 inputs, recorded with 2 inputs");
}

TEST_CASE("functions of a span replay like those of derivatives.hpp", "[autodiff][replay]") {
  const auto f = []<class S>(std::span<const S> x) { return S(x[0] * x[1] + x[2]); };
  Replay<double> replay(f, std::vector<double>{1, 2, 3});
  std::vector<double> gradient(3);
  CHECK(replay.gradient(std::vector<double>{4, 5, 6}, gradient) == 26);
  CHECK(gradient == tapestry::gradient(f, std::vector<double>{4, 5, 6}).gradient);
}

TEST_CASE("a refused comparison shows all digits", "[autodiff][replay]") {
  Replay<double> replay([](const auto* x) { return x[0] > x[1] ? x[0] : x[1]; }, std::vector<double>{2, 1});
  CHECK_THROWS_WITH(replay.value(std::vector<double>{1, 1 + 1e-15}),
                    contains("of 1 with 1.0000000000000011 comes"));
}

TEST_CASE("variables do not leave their recording, and a throwing function ends it", "[autodiff][replay]") {
  Replayable<double> escaped;
  Replay<double> first([&](const auto* x) { return escaped = x[0] * 2; }, std::vector<double>{3});
  CHECK_THROWS_AS(Replayable<double>(escaped * 2), DomainError);
  const auto uses_stranger = [&](const auto* x) { return Replayable<double>(x[0] * escaped); };
  CHECK_THROWS_AS((Replay<double>(uses_stranger, std::vector<double>{3})), DomainError);
  const auto returns_stranger = [&](const auto*) { return escaped; };
  CHECK_THROWS_AS((Replay<double>(returns_stranger, std::vector<double>{3})), DomainError);
  const auto throws = [](const auto* x) -> Replayable<double> {
    if (x[0] > 0) throw std::runtime_error("user");
    return x[0];
  };
  CHECK_THROWS_AS((Replay<double>(throws, std::vector<double>{3})), std::runtime_error);
  CHECK(first.value(std::vector<double>{5}) == 10);
  CHECK_FALSE(Replayable<double>(Replayable<double>(2.0) * 3).is_active());
}

TEST_CASE("fma and hypot of three replay, with constants among their arguments", "[autodiff][replay]") {
  const auto f = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    const S product = fma(x[0], x[1], x[2]), scaled = fma(2.0, product, x[0]);
    return S(hypot(x[0], scaled * x[1], x[2]) + hypot(x[1], 3.0, product) + fma(x[2], x[2], 1.0));
  };
  Replay<double> replay(f, std::vector<double>{1, 2, 3});
  CHECK(replay.statement_count() == 3);
  std::vector<double> gradient(3);
  for (const std::vector<double>& x : {std::vector<double>{1, 2, 3}, {-0.5, 4, 0.25}, {0, 0, 0}}) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const std::vector<Variable<double>> inputs = {tape.input(x[0]), tape.input(x[1]), tape.input(x[2])};
    const Variable<double> root = f(inputs.data());
    tape.reverse(root);
    CHECK(replay.gradient(x, gradient) == root.value());
    for (std::size_t i = 0; i < 3; ++i) CHECK(gradient[i] == inputs[i].adjoint());
  }
  // Worked out by hand at (0, 4, 0): fma(x, y, z) = 0, and the first hypot is at its origin.
  CHECK(replay.gradient(std::vector<double>{0, 4, 0}, gradient) == 6);
  CHECK(gradient == std::vector<double>{0, 0.8, 0});
}
