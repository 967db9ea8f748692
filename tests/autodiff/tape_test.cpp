#include <tapestry/autodiff.hpp>

#include <thread>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::DomainError, tapestry::Tape, tapestry::Variable, tapestry::test::ActiveTape;

TEMPLATE_TEST_CASE("a tape differentiates x·x + x", "[autodiff][tape]", float, double) {
  ActiveTape<TestType> tape;
  const Variable<TestType> x = tape.input(2);
  const Variable<TestType> y = x * x + x;
  CHECK(y.value() == 6);
  CHECK(x.adjoint() == 0);  // before the sweep
  tape.reverse(y);
  CHECK(x.adjoint() == 5);
  CHECK(y.adjoint() == 1);
}

TEST_CASE("each statement is one record, passive ones are none", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> frozen = 3.0;
  const Variable<double> passive_result = exp(frozen) * 2 + frozen / 7;
  CHECK_FALSE(passive_result.is_active());
  CHECK(tape.statement_count() == 1);
  const Variable<double> y = sin(x * frozen) + 2 * x - passive_result / x;
  CHECK(y.is_active());
  CHECK(tape.statement_count() == 2);
  CHECK(tape.operand_count() == 3);  // x thrice; frozen and passive_result not at all
}

TEST_CASE("passive arithmetic needs no tape", "[autodiff][tape]") {
  const Variable<double> x = 2.0;
  const Variable<double> y = pow(x, 3) - x;
  CHECK(y.value() == 6);
  CHECK(y.adjoint() == 0);
}

TEST_CASE("assignment may alias its operands", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> start = tape.input(3.0);
  Variable<double> x = start;
  x = x * x + x;
  x += x;
  x *= x;
  x -= 1;
  x /= 2;
  Variable<double>& same = x;
  x = same;
  tape.reverse(x);
  CHECK(x.value() == (24.0 * 24.0 - 1) / 2);
  CHECK(start.adjoint() == 24.0 * 2 * 7);  // d(y²/2) = y·dy, y = 2(x² + x)
}

TEST_CASE("swapped and moved-from variables keep their derivatives", "[autodiff][tape]") {
  ActiveTape<double> tape;
  Variable<double> x = tape.input(2.0), y = tape.input(5.0);
  std::swap(x, y);
  const Variable<double> moved = std::move(x);
  const Variable<double> z = 3 * moved + x * y;  // x still is the second input
  tape.reverse(z);
  CHECK(moved.adjoint() == 3 + 2);
  CHECK(y.adjoint() == 5);
}

TEST_CASE("reverse called twice gives the same gradient, not the sum", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> y = x * x;
  tape.reverse(y);
  tape.reverse(y);
  CHECK(x.adjoint() == 4);
  tape.reverse(y, 0.5);
  CHECK(x.adjoint() == 2);
  const Variable<double> z = y * x;  // recording goes on after a sweep
  CHECK(z.adjoint() == 0);
  tape.reverse(z);
  CHECK(x.adjoint() == 12);
  tape.reverse(y);  // an earlier root ignores what follows it
  CHECK(x.adjoint() == 4);
  CHECK(z.adjoint() == 0);
}

TEST_CASE("a passive root has gradient zero", "[autodiff][tape]") {
  ActiveTape<double> tape;
  tape.reverse(Variable<double>(1.0));  // of an empty tape
  const Variable<double> x = tape.input(2.0);
  const Variable<double> y = x * x;
  tape.reverse(y);
  tape.reverse(Variable<double>(1.0));
  CHECK(x.adjoint() == 0);
  CHECK(y.adjoint() == 0);
}

TEST_CASE("a statement of active variables needs an active tape", "[autodiff][tape]") {
  Tape<double> tape;
  const Variable<double> x = tape.input(2.0);
  CHECK_THROWS_AS(Variable<double>(x * x), DomainError);
  CHECK_THROWS_AS(x.adjoint(), DomainError);
  CHECK(tape.adjoint(x) == 0);
  {
    const auto scope = tape.activate();
    tape.reverse(x);
  }
  CHECK(tape.adjoint(x) == 1);
  CHECK_THROWS_AS(Variable<double>(x * x), DomainError);
  CHECK(tape.statement_count() == 1);
}

TEST_CASE("a tape is active on one thread at a time, any number of times", "[autodiff][tape]") {
  Tape<double> tape;
  std::string message;
  const auto activate_elsewhere = [&] {
    message.clear();
    std::thread([&] {
      try {
        const auto scope = tape.activate();
      } catch (const DomainError& error) {
        message = error.what();
      }
    }).join();
  };
  {
    const auto scope = tape.activate();
    const Variable<double> x = tape.input(2.0);
    {
      const auto again = tape.activate();
      CHECK(Variable<double>(x * x).is_active());
    }
    activate_elsewhere();
    CHECK(message == "activate: the tape is active on another thread; each thread needs a tape of its own");
    CHECK(Variable<double>(x * x).is_active());
  }
  activate_elsewhere();
  CHECK(message.empty());
}

TEST_CASE("scopes nest, and a variable of another tape is refused", "[autodiff][tape]") {  // T19
  Tape<double> outer, inner;
  const auto outer_scope = outer.activate();
  const Variable<double> x = outer.input(2.0);
  double slope = 0;
  {
    const auto inner_scope = inner.activate();
    const Variable<double> y = inner.input(x.value());
    const Variable<double> z = y * y * y;
    inner.reverse(z);
    slope = y.adjoint();
    CHECK_THROWS_AS(Variable<double>(x * y), DomainError);
    CHECK_THROWS_AS(Variable<double>(y * x), DomainError);
    CHECK_THROWS_AS(x.adjoint(), DomainError);
    CHECK_THROWS_AS(inner.reverse(x), DomainError);
    CHECK(inner.statement_count() == 2);
  }
  const Variable<double> result = slope * x;
  outer.reverse(result);
  CHECK(x.adjoint() == 12);
}

TEST_CASE("a scope can be returned, and put into an optional", "[autodiff][tape]") {
  Tape<double> tape;
  const auto begun = [&tape] {
    auto scope = tape.activate();
    return scope;
  };
  std::optional<tapestry::ActiveScope<double>> scope;
  for (int i = 0; i < 2; ++i) {
    scope.emplace(i == 0 ? begun() : tape.activate());
    const Variable<double> x = tape.input(3.0), y = x * x;
    tape.reverse(y);
    CHECK(x.adjoint() == 6);
    scope.reset();
    CHECK_THROWS_AS(Variable<double>(x * x), DomainError);
  }
  auto outer = tape.activate();
  const auto moved = std::move(outer);
  CHECK(Variable<double>(tape.input(3.0) * 2).is_active());
  STATIC_REQUIRE_FALSE(std::is_move_assignable_v<tapestry::ActiveScope<double>>);
}

TEST_CASE("scopes ended out of order are an error until all have ended", "[autodiff][tape]") {
  Tape<double> first, second;
  const Variable<double> x = first.input(3.0), y = second.input(5.0);
  const auto names_order = contains("scopes of Tape::activate() have ended out of order");
  {
    std::optional<tapestry::ActiveScope<double>> outer, inner;
    outer.emplace(first.activate());
    inner.emplace(second.activate());
    outer.reset();
    CHECK_THROWS_WITH(Variable<double>(x * x), names_order);
    CHECK_THROWS_WITH(Variable<double>(y * y), names_order);
    CHECK_THROWS_WITH(y.adjoint(), names_order);
    CHECK_THROWS_WITH(second.activate(), names_order);
    inner.reset();
  }
  CHECK(first.statement_count() == 1);
  CHECK_THROWS_WITH(Variable<double>(x * x), contains("an operation on an active variable needs an active"));
  const auto scope = first.activate();
  CHECK(Variable<double>(x * x).is_active());
}

TEST_CASE("the same tape's scopes ended out of order are an error, too", "[autodiff][tape]") {
  Tape<double> tape;
  const Variable<double> x = tape.input(3.0);
  std::optional<tapestry::ActiveScope<double>> outer(tape.activate()), inner(tape.activate());
  outer.reset();
  CHECK_THROWS_AS(Variable<double>(x * x), DomainError);
  inner.reset();
  outer.emplace(tape.activate());
  CHECK(Variable<double>(x * x).is_active());
}

TEST_CASE("a scope ended on another thread is an error there", "[autodiff][tape]") {
  std::string message;
  bool is_active_still = false;
  const auto end_elsewhere = [&message](std::optional<tapestry::ActiveScope<double>>& scope) {
    scope.reset();
    Tape<double> own;
    try {
      const auto own_scope = own.activate();
    } catch (const DomainError& error) {
      message = error.what();
    }
  };
  std::thread([&] {
    Tape<double> tape;
    std::optional<tapestry::ActiveScope<double>> scope(tape.activate());
    std::thread([&] { end_elsewhere(scope); }).join();
    const Variable<double> x = tape.input(3.0);
    is_active_still = Variable<double>(x * x).is_active();
  }).join();
  CHECK_THAT(message, contains("scopes of Tape::activate() have ended out of order"));
  CHECK(is_active_still);
}

TEST_CASE("rewind forgets what followed the mark and nothing else", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> before = x * x;
  const auto position = tape.mark();
  Variable<double> stale;
  for (int step = 1; step <= 3; ++step) {
    const Variable<double> y = before * step;
    tape.reverse(y);
    CHECK(x.adjoint() == 4 * step);
    stale = y;
    tape.rewind(position);
    CHECK(tape.statement_count() == 2);
  }
  const Variable<double> replacement = x + 1;  // takes the place that stale had
  CHECK(replacement.adjoint() == 0);
  CHECK_THROWS_AS(Variable<double>(stale + 1), DomainError);
  CHECK_THROWS_AS(stale.adjoint(), DomainError);
  CHECK_THROWS_AS(tape.reverse(stale), DomainError);
  tape.reverse(replacement);
  CHECK(x.adjoint() == 1);
}

TEST_CASE("a position that is no longer on the tape is refused", "[autodiff][tape]") {
  Tape<double> tape, other;
  const auto scope = tape.activate();
  const auto start = tape.mark();
  const Variable<double> x = tape.input(2.0);
  CHECK(Variable<double>(x * x).value() == 4);
  const auto late = tape.mark();
  CHECK_THROWS_AS(other.rewind(late), DomainError);
  CHECK_THROWS_AS(other.rewind(start), DomainError);
  tape.rewind(start);
  CHECK_THROWS_AS(tape.rewind(late), DomainError);
  const Variable<double> u = tape.input(2.0);
  CHECK(Variable<double>(u * u).value() == 4);
  CHECK_THROWS_AS(tape.rewind(late), DomainError);  // as long as before, but rewound
  tape.rewind(start);
  tape.clear();
  CHECK_THROWS_AS(tape.rewind(start), DomainError);
  CHECK_THROWS_AS(tape.rewind(tapestry::Position{}), DomainError);
}

TEST_CASE("variables are stale after clear and after the end of their tape", "[autodiff][tape]") {
  Variable<double> x;
  ActiveTape<double> tape;
  x = tape.input(2.0);
  tape.clear();
  CHECK(tape.statement_count() == 0);
  const Variable<double> fresh = tape.input(3.0);  // takes the place that x had
  CHECK_THROWS_AS(Variable<double>(x + fresh), DomainError);
  {
    Tape<double> brief;
    x = brief.input(1.0);
  }
  CHECK_THROWS_AS(Variable<double>(x + fresh), DomainError);
  const Variable<double> y = fresh * fresh;
  tape.reverse(y);
  CHECK(fresh.adjoint() == 6);
}

TEST_CASE("a tape moves while it is active, and leaves an empty tape", "[autodiff][tape]") {
  Tape<double> source;
  const auto scope = source.activate();
  const Variable<double> x = source.input(2.0);
  Tape<double> target = std::move(source);
  const Variable<double> y = x * x;
  target.reverse(y);
  CHECK(x.adjoint() == 4);
  CHECK(target.adjoint(x) == 4);
  CHECK(source.statement_count() == 0);
  const auto inner_scope = source.activate();
  const Variable<double> z = source.input(1.0);
  source.reverse(z);
  CHECK(z.adjoint() == 1);
  CHECK_THROWS_AS(x.adjoint(), DomainError);
}

TEST_CASE("a tape may end before its scope", "[autodiff][tape]") {
  auto tape = std::make_unique<Tape<double>>();
  const auto scope = tape->activate();
  const Variable<double> x = tape->input(2.0);
  tape.reset();
  const Variable<double> y = x * x;
  CHECK(y.value() == 4);
}

TEST_CASE("an exception amid recording leaves the tape usable", "[autodiff][tape]") {  // T18
  Tape<double> tape, other;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(2.0);
  const Variable<double> stranger = other.input(1.0);
  const auto fails = [&]() -> Variable<double> {
    Variable<double> y = x * x;
    if (y > 3) throw std::runtime_error("user");
    return y;
  };
  CHECK_THROWS_AS(fails(), std::runtime_error);
  const auto operands = tape.operand_count();
  CHECK_THROWS_AS(Variable<double>(x * x * stranger), DomainError);  // after two operands were written
  CHECK(tape.operand_count() == operands);
  CHECK(tape.statement_count() == 2);
  const Variable<double> z = x * x * x;
  tape.reverse(z);
  CHECK(x.adjoint() == 12);
}

TEST_CASE("a graph a million deep needs no stack", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1.0);
  Variable<double> y = x;
  for (int i = 0; i < 1'000'000; ++i) y = y + 1e-6 * x;
  tape.reverse(y);
  CHECK(tape.statement_count() == 1'000'001);
  CHECK(std::abs(x.adjoint() - 2) <= 1e-9);  // 10⁶ roundings of ε/2 each, relative to 2
}

TEST_CASE("every thread has its own active tape", "[autodiff][tape]") {  // T17
  std::vector<double> slopes(4);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < slopes.size(); ++i)
    threads.emplace_back([&slopes, i] {
      ActiveTape<double> tape;
      const Variable<double> x = tape.input(static_cast<double>(i));
      Variable<double> y = 0;
      for (int k = 0; k < 1000; ++k) y += x * x;
      tape.reverse(y);
      slopes[i] = x.adjoint();
    });
  for (auto& thread : threads) thread.join();
  for (std::size_t i = 0; i < slopes.size(); ++i) CHECK(slopes[i] == 2000 * static_cast<double>(i));
}

TEST_CASE("tapes of float and double are active side by side", "[autodiff][tape]") {
  Tape<float> singles;
  Tape<double> doubles;
  const auto single_scope = singles.activate();
  const auto double_scope = doubles.activate();
  const Variable<float> x = singles.input(2.0F);
  const Variable<double> y = doubles.input(3.0);
  singles.reverse(Variable<float>(x * x));
  doubles.reverse(Variable<double>(y * y));
  CHECK(x.adjoint() == 4);
  CHECK(y.adjoint() == 6);
}

TEST_CASE("a zero adjoint passes no infinite partial, a NaN goes on", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(0.0);
  const Variable<double> root = sqrt(x);
  tape.reverse(Variable<double>(0 * root + x));  // in two statements
  CHECK(x.adjoint() == 1);
  tape.reverse(Variable<double>(0 * sqrt(x) + x));  // and in one
  CHECK(x.adjoint() == 1);
  tape.reverse(root, std::numeric_limits<double>::quiet_NaN());
  CHECK(std::isnan(x.adjoint()));
  const Variable<double> nan = tape.input(std::numeric_limits<double>::quiet_NaN());
  tape.reverse(Variable<double>(nan * x));
  CHECK(std::isnan(x.adjoint()));
  CHECK(nan.adjoint() == 0);
}

TEST_CASE("denormal adjoints survive", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1.0);
  const double tiny = std::numeric_limits<double>::denorm_min();
  tape.reverse(Variable<double>(x * 3), tiny);
  CHECK(x.adjoint() == 3 * tiny);
}

TEST_CASE("a vector of numbers is a vector of inputs", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = tape.input(std::vector<double>{2, 3});
  tape.reverse(Variable<double>(x[0] * x[1]));
  CHECK(x[0].adjoint() == 3);
  CHECK(tape.input(std::array<double, 3>{1, 2, 4})[2].value() == 4);
  CHECK(tape.statement_count() == 6);
}
