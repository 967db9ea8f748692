#include <numeric>
#include <tapestry/autodiff.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"

using tapestry::DomainError, tapestry::Variable, tapestry::test::ActiveTape;

TEST_CASE("an operand of partial derivative 1 or -1 costs 4 bytes, any other 12, a statement 1",
          "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0), y = tape.input(3.0);
  const auto bytes_of = [&](const auto& formula) {
    const auto before = tape.statement_bytes();
    static_cast<void>(Variable<double>(formula));
    return tape.statement_bytes() - before;
  };
  CHECK(bytes_of(x - y) == 1 + 2 * 4);
  CHECK(bytes_of(x * y) == 1 + 2 * 12);
  CHECK(bytes_of(x + exp(y)) == 1 + 4 + 12);
  CHECK(bytes_of(-(x - -y)) == 1 + 2 * 4);
  CHECK(bytes_of(3 - x) == 1 + 4);
  CHECK(bytes_of(2 * x) == 1 + 12);
}

TEST_CASE("sums and differences of any number of terms have adjoints of 1 and -1",
          "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  std::vector<Variable<double>> x(12);
  tape.input(std::vector<double>(12, 0.5), x);
  const Variable<double> y =
      x[0] + x[1] + x[2] + x[3] + x[4] + x[5] - x[6] - x[7] - x[8] - x[9] - x[10] - x[11];
  tape.reverse(y, 3.0);
  for (std::size_t i = 0; i < 12; ++i) CHECK(x[i].adjoint() == (i < 6 ? 3 : -3));
}

TEST_CASE("every mixture of active, passive and older operands has the derivatives worked out by hand",
          "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const std::array<double, 4> values = {2, 3, 5, 7};
  const std::array<double, 4> slopes = {1 + 5, -1, 2 - 7, -5};  // of a − b + a·c − c·d
  for (unsigned mixture = 0; mixture < 81;
       ++mixture) {  // each operand passive, or recorded before or after a rewind
    tape.clear();
    std::array<Variable<double>, 4> x;
    const auto kind = [&](std::size_t i) { return mixture / std::array{1U, 3U, 9U, 27U}[i] % 3; };
    for (std::size_t i = 0; i < 4; ++i)
      x[i] = kind(i) == 1 ? tape.input(values[i]) : Variable<double>(values[i]);
    tape.rewind(tape.mark());
    for (std::size_t i = 0; i < 4; ++i)
      if (kind(i) == 2) x[i] = tape.input(values[i]);
    const Variable<double> y = x[0] - x[1] + x[0] * x[2] - x[2] * x[3];
    CHECK(y.value() == 2 - 3 + 10 - 35);
    CHECK(y.is_active() == (mixture != 0));
    tape.reverse(y);
    for (std::size_t i = 0; i < 4; ++i) CHECK(x[i].adjoint() == (kind(i) == 0 ? 0 : slopes[i]));
  }
}

TEST_CASE("recordings that fill many pieces of memory rewind to any place", "[autodiff][tape_memory]") {
  ActiveTape<float> tape;
  const Variable<float> x = tape.input(1.0F);
  const auto chain = [](const Variable<float>& start, int count) {
    Variable<float> y = start;
    for (int i = 0; i < count; ++i) y = y + start;
    return y;
  };
  Variable<float> y = x;
  for (const int count : {1000, 3, 20000, 1, 70000}) {
    const auto position = tape.mark();
    const auto statements = tape.statement_count();
    for (int again = 0; again < 2; ++again) {
      tape.rewind(position);
      const Variable<float> sum = chain(y, count);
      tape.reverse(sum);
      CHECK(tape.statement_count() == statements + static_cast<std::size_t>(count));
      CHECK(y.adjoint() == static_cast<float>(count + 1));
      CHECK(x.adjoint() == y.adjoint());  // y is x, or y = x · 1
    }
    tape.rewind(position);
    y = 1 * x;
  }
}

TEST_CASE("one statement may have more operands than a piece of memory", "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  constexpr std::size_t count = 300'000;
  std::vector<double> values(count);
  std::iota(values.begin(), values.end(), 0.0);
  std::vector<Variable<double>> x(count);
  tape.input(values, x);
  const auto y = tapestry::record_partials<double>(0, x, values);
  const Variable<double> z = y + x[7];
  tape.reverse(z);
  CHECK(tape.operand_count() == count + 2);
  std::vector<double> adjoints(count);
  tape.adjoints(x, adjoints);
  values[7] += 1;
  CHECK(adjoints == values);
}

TEST_CASE("many inputs at once are those made one by one", "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const std::vector<double> values = {1, 2, 3};
  std::vector<Variable<double>> x(3);
  tape.input(values, x);
  CHECK(tape.statement_count() == 3);
  tape.reverse(Variable<double>(x[0] * x[1] * x[2]));
  CHECK(x[0].adjoint() == 6);
  CHECK(x[2].adjoint() == 2);
  std::vector<Variable<double>> too_few(2);
  CHECK_THROWS_WITH(tape.input(values, too_few), "input: 3 values for 2 variables");
  std::vector<double> adjoints(4);
  CHECK_THROWS_WITH(tape.adjoints(x, adjoints), "adjoints: 4 adjoints for 3 variables");
  tape.clear();
  adjoints.resize(3);
  CHECK_THROWS_AS(tape.adjoints(x, adjoints), DomainError);
}

namespace {
/// An expression with the required members only: 3 · x.
struct Thrice {
  using ExpressionScalar = double;
  static constexpr std::size_t operand_bound = 1;
  Variable<double> x;
  [[nodiscard]] double value() const { return 3 * x.value(); }
  [[nodiscard]] bool is_active() const { return x.is_active(); }
  void push(double factor, auto& sink) const { x.push(3 * factor, sink); }
};
}  // namespace

TEST_CASE("a foreign expression joins formulas", "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> y = x - Thrice{x} * x + tapestry::exp(Thrice{Variable<double>(0.0)});
  CHECK(y.value() == 2 - 12 + 1);
  tape.reverse(y);
  CHECK(x.adjoint() == 1 - 12);
  CHECK(Variable<double>(Thrice{x}).adjoint() == 0);
}

TEST_CASE("an earlier root ignores statements and operations behind it", "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> root = x * x;
  Variable<double> later = root;
  for (int i = 0; i < 10000; ++i) later = later * 0.5 + root;
  tape.reverse(later);
  tape.reverse(root);
  CHECK(x.adjoint() == 4);
  CHECK(later.adjoint() == 0);
}

TEST_CASE("max and abs at their kinks leave formulas active", "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> zero = tape.input(0.0);
  const Variable<double> y = abs(zero);
  CHECK(y.is_active());
  const Variable<double> z = max(y, Variable<double>(1.0));
  tape.reverse(Variable<double>(z + y));
  CHECK(zero.adjoint() == 0);
  CHECK(y.adjoint() == 1);
  CHECK_FALSE(Variable<double>(abs(Variable<double>(0.0))).is_active());
}

TEST_CASE("the bytes of statements are those of every piece of memory, and less after rewind",
          "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1.0);
  const auto inputs = tape.statement_bytes();
  Variable<double> y = x;
  const auto record = [&](std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) y = y * x;
  };
  record(100000);  // two operands of 4 + 8 bytes, and one of the statement: 2.5 MB, of pieces from 32 KiB on
  const auto middle = tape.mark();
  record(100000);
  CHECK(tape.statement_bytes() == inputs + 200000 * 25);
  tape.rewind(middle);
  CHECK(tape.statement_bytes() == inputs + 100000 * 25);
  tape.clear();
  CHECK(tape.statement_bytes() == 0);
}

TEST_CASE("a short tape takes pieces of 32 KiB and more, a long one of 2 and of 8 MiB",
          "[autodiff][tape_memory]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1.0);
  Variable<double> y = x;
  const auto bytes_with = [&](std::size_t statements) {  // of six words each; a piece is four fifths words
    while (tape.statement_count() < statements) y = y * x;
    return tape.shared_state()->chunk_bytes();
  };
  constexpr std::size_t kib = 1024;
  CHECK(bytes_with(1000) <= 32 * kib);
  CHECK(bytes_with(7000) <= (32 + 64 + 128) * kib);
  CHECK(bytes_with(70000) <= (32 + 64 + 128 + 2048) * kib);
  CHECK(bytes_with(200000) <= (32 + 64 + 128 + 2048 + 8192) * kib);
}
