#include <sstream>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/autodiff/tape_statistics.hpp>

#include "../../support/catch.hpp"

using tapestry::DomainError, tapestry::Error, tapestry::Tape, tapestry::Variable;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
}

TEST_CASE("the first partial derivative that is not finite is found, with the labels around it",
          "[autodiff][tape]") {
  Tape<double> tape;
  const auto active = tape.activate();
  const auto x = tape.input(0.0), y = tape.input(2.0);  // statements 1 and 2
  CHECK_FALSE(tape.first_non_finite());
  const Variable<double> before = x * y;  // 3
  Variable<double> root;
  {
    const auto loss = tape.label("loss");
    const Variable<double> inside = before + y;  // 4
    {
      const auto box = tape.label("box");
      root = sqrt(x) + inside;  // 5: half of 1 / 0
    }
    static_cast<void>(Variable<double>(log(x) * root));  // 6
  }
  const auto found = tape.first_non_finite();
  REQUIRE(found);
  CHECK(found->statement == 5);
  CHECK_FALSE(found->is_value);
  CHECK(found->number == infinity);
  CHECK(found->label == "loss/box");
  CHECK(found->description() == "a partial derivative of statement 5, loss/box, is inf");
}

TEST_CASE("a value that is not finite, and whose partial derivatives are, is found if values are watched",
          "[autodiff][tape]") {
  Tape<double> tape;
  const auto active = tape.activate();
  const auto record = [&] {
    const auto x = tape.input(-1.0);
    const auto scope = tape.label("first");
    const Variable<double> y = x + 1;
    const Variable<double> z = log(x);  // its slope is −1
    return Variable<double>(z + y);
  };
  tape.reverse(record());
  CHECK_FALSE(tape.first_non_finite());
  tape.clear();
  tape.watch_values();
  const auto root = record();
  const auto found = tape.first_non_finite();
  REQUIRE(found);
  CHECK(found->statement == 3);
  CHECK(found->is_value);
  CHECK(std::isnan(found->number));
  CHECK(found->label == "first");
  CHECK(found->description().starts_with("the value of statement 3, first, is"));
  tape.reverse(root);  // watched statements are ordinary ones
  CHECK(tape.first_non_finite()->statement == 3);
  tape.clear();
  CHECK_FALSE(tape.first_non_finite());
  tape.watch_values(false);
  static_cast<void>(record());
  CHECK_FALSE(tape.first_non_finite());
}

TEST_CASE("inputs, partials given by hand and statements of many chunks are watched", "[autodiff][tape]") {
  Tape<double> tape;
  tape.watch_values();  // before there is memory
  const auto active = tape.activate();
  std::vector<Variable<double>> x(3);
  tape.input(std::vector<double>{1, 2, infinity}, x);
  CHECK(tape.first_non_finite()->statement == 3);
  tape.clear();
  static_cast<void>(tape.input(std::nan("")));
  CHECK(tape.first_non_finite()->statement == 1);
  tape.clear();
  const auto one = tape.input(1.0);
  const std::array<Variable<double>, 1> of = {one};
  const std::array<double, 1> slope = {1};
  static_cast<void>(record_partials<double>(infinity, of, slope));
  CHECK(tape.first_non_finite()->statement == 2);
  tape.clear();
  Variable<double> sum = tape.input(1.0);
  for (int i = 0; i < 100000; ++i) sum = sum * 1.0;
  static_cast<void>(Variable<double>(sum - infinity));
  CHECK(tape.first_non_finite()->statement == 100002);
  tape.reverse(sum);
  CHECK(tape.adjoint(sum) == 1);
}

TEST_CASE("a watched recording has the gradient of one that is not", "[autodiff][tape]") {
  const auto gradient = [](bool watches) {
    Tape<double> tape;
    if (watches) tape.watch_values();
    const auto active = tape.activate();
    const auto x = tape.input(0.5), y = tape.input(3.0);
    Variable<double> z = x * y - x / y;
    for (int i = 0; i < 20; ++i) z = sin(z) * x + max(y, z) - (x + y);
    tape.reverse(z);
    return std::pair(x.adjoint(), y.adjoint());
  };
  CHECK(gradient(false) == gradient(true));
}

TEST_CASE("labels and what was found are forgotten with their statements", "[autodiff][tape]") {
  Tape<double> tape;
  tape.watch_values();
  const auto active = tape.activate();
  const auto x = tape.input(1.0);
  const auto whole = tape.label("whole");
  const auto position = tape.mark();
  {
    const auto part = tape.label("part");
    static_cast<void>(Variable<double>(x / 0.0));
    CHECK(tape.first_non_finite()->label == "whole/part");
    tape.rewind(position);
    CHECK_FALSE(tape.first_non_finite());
  }  // ends a label that is gone
  static_cast<void>(Variable<double>(x / 0.0));
  CHECK(tape.first_non_finite()->statement == 2);
  CHECK(tape.first_non_finite()->label == "");  // "whole" began where rewind() went back to
  Tape<double> moved = std::move(tape);
  CHECK(moved.first_non_finite()->statement == 2);
  CHECK_FALSE(tape.first_non_finite());
}

TEST_CASE("reserved memory is used by the recording, and changes nothing of it", "[autodiff][tape]") {
  Tape<double> tape;
  const auto active = tape.activate();
  const auto x = tape.input(2.0);
  tape.reserve(3'000'000, 3'000'000);
  CHECK(tape.statement_count() == 1);
  const std::size_t bytes = tape.shared_state()->chunk_bytes();
  CHECK(bytes >= 3'000'000 * 17);
  Variable<double> y = x;
  for (int i = 0; i < 2'000'000; ++i) y = y * 1.0;
  tape.reverse(y);
  CHECK(x.adjoint() == 1);
  CHECK(tape.shared_state()->chunk_bytes() == bytes);
  tape.reserve(10, 10);  // is there
  CHECK(tape.shared_state()->chunk_bytes() == bytes);
  CHECK(x.adjoint() == 1);
  CHECK_THROWS_AS(tape.reserve(~std::size_t(0) >> (sizeof(std::size_t) == 8 ? 24U : 1U), 0), Error);
  CHECK_THROWS_AS(tape.reserve(0, ~std::size_t(0)), Error);
}

TEST_CASE("statistics count statements by operands, operations by name, and both by label",
          "[autodiff][diagnosis]") {
  Tape<double> tape;
  const auto empty = tapestry::tape_statistics(tape);
  CHECK(empty.all.count == 0);
  CHECK(empty.statements.empty());
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(2.0), y = tape.input(3.0);
  Variable<double> z;
  for (int i = 0; i < 2; ++i) {
    const auto outer = tape.label("outer");
    const auto inner = tape.label("inner");
    z = x * y - 1;
    z = exp(z);
  }
  std::vector<Variable<double>> many(9, z);
  z = tapestry::sum(many);
  static_cast<void>(tapestry::record_scalar(
      1.0, [](double, double*, double*) {}, x, z));
  const auto array = tape.input(tapestry::Array<double, 1>{1.0});
  const auto found = tapestry::tape_statistics(tape);
  CHECK(found.all.count == tape.statement_count());
  CHECK(found.all.bytes == tape.statement_bytes());
  const auto rows = [](const auto& all) {
    std::string text;
    for (const auto& row : all)
      text += row.name + " " + std::to_string(row.count) + " " + std::to_string(row.operands) + ", ";
    return text;
  };
  CHECK(rows(found.statements) == "inputs 2 0, 1 operand 2 2, 2 operands 2 4, 8 operands or more 1 9, ");
  CHECK(rows(found.labels) == "outer 4 6, outer/inner 4 6, ");
  REQUIRE(found.operations.size() == 2);
  CHECK(found.operations[0].name == "InputRecord");
  CHECK(found.operations[1].operands == 2);
  CHECK(found.labels[0].bytes == 4 * 1 + 6 * 12);
  std::ostringstream text;
  text << found;
  CHECK(found.lines().size() == 2 + 5 + 3 + 3);
  CHECK(text.str().find("\n  8 operands or more" + std::string(25, ' ') + "1" + std::string(13, ' ') + "9") !=
        std::string::npos);
}

TEST_CASE("an operation has the name of the function that its pullback stands in", "[autodiff][diagnosis]") {
  using tapestry::detail::operation_name;
  CHECK(operation_name("N8tapestry6detail11InputRecordIdLm1EEE") == "InputRecord");
  CHECK(operation_name("Z4mainEUldPdE_") == "main");
  CHECK(operation_name("ZN8tapestry6detail12evaluate_sumINS_9ArrayViewIdEEEET_RKS3_EUldE_") ==
        "evaluate_sum");
  CHECK(operation_name("N8tapestry6detail14MatrixPullbackIdZNS_6matrix5solveIdEEvT_EUlS4_E_EE") ==
        "matrix::solve");
  CHECK(operation_name("N12_GLOBAL__N_17CounterE") == "Counter");
  CHECK(operation_name("i") == "unnamed");
  CHECK(operation_name("") == "unnamed");
}

TEST_CASE("a zero that hides an infinite slope is counted, with the labels around it",
          "[autodiff][diagnosis]") {
  Tape<double> tape;
  const auto active = tape.activate();
  const auto x = tape.input(0.0);
  const auto scope = tape.label("root");
  const Variable<double> root = sqrt(x);
  CHECK(tape.zero_products().count == 0);
  const Variable<double> product = root * root;
  const Variable<double> behind = log(product);
  tape.reverse(product);  // 0 · ∞ instead of 1
  CHECK(x.adjoint() == 0);
  const auto found = tape.zero_products();
  CHECK(found.count == 1);
  CHECK(found.statement == 2);
  CHECK(found.description() == "1 times 0 met a number that is not finite, first in statement 2, root");
  tape.reverse(Variable<double>(2 * x));
  CHECK(tape.zero_products().count == 2);  // the unused ones: logarithm and root
  tape.reverse(root);
  CHECK(x.adjoint() == infinity);
  CHECK(tape.zero_products().count == 0);
  CHECK(tape.zero_products().description() == "0 times 0 met a number that is not finite");
  static_cast<void>(behind);
}

TEST_CASE("an infinite adjoint that meets a zero slope is counted, for duals too", "[autodiff][diagnosis]") {
  using D = tapestry::Dual<double>;
  Tape<D> tape;
  const auto active = tape.activate();
  const Variable<D> x = tape.input(D::input(0.0));
  const Variable<D> squared = x * x;
  tape.reverse(Variable<D>(sqrt(squared)));
  CHECK(x.adjoint().value() == 0);
  CHECK(tape.zero_products().count == 3);  // twice x; and the root, the tangent of whose adjoint is 0
}
