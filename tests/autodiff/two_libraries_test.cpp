#include <tapestry/autodiff.hpp>
#include <thread>

#include "../libraries/libraries.hpp"
#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Tape, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
void nothing() {}
void record_cubic() { cubic_record(2, nothing); }
Tape<double>* own_tape = nullptr;
const Variable<double>* own_input = nullptr;
/// A statement on this program's tape.
void record_here() {
  const auto scope = own_tape->activate();
  static_cast<void>(Variable<double>(*own_input * 2.0));
}
/// The same without a scope: the library's tape is the active one, even where it hides its symbols.
void record_there() { CHECK_THROWS_AS(Variable<double>(*own_input * 2.0), tapestry::DomainError); }
}  // namespace

TEST_CASE("two libraries and the program record on their own tapes in turn", "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(5.0);
  const Variable<double> square = x * x;
  quadratic_record(3, nothing);
  cubic_record(2, nothing);
  const Variable<double> root = square * x;
  CHECK(quadratic_slope() == 6);
  CHECK(cubic_slope() == 12);
  tape.reverse(root);
  CHECK(x.adjoint() == 75);
  CHECK(tape.statement_count() == 3);
  CHECK(quadratic_statements() == 2);
  CHECK(cubic_statements() == 2);
}

TEST_CASE("what the program and another library record in the middle of a library's recording stays theirs",
          "[autodiff][tape]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(5.0);
  own_tape = &tape;
  own_input = &x;
  quadratic_record(7, record_there);
  cubic_record(7, record_there);
  quadratic_record(7, record_here);
  CHECK(tape.statement_count() == 2);
  CHECK(quadratic_statements() == 2);
  quadratic_record(7, record_cubic);
  const Variable<double> root = x * x;  // on this tape again
  CHECK(quadratic_slope() == 14);
  CHECK(cubic_slope() == 12);
  tape.reverse(root);
  CHECK(x.adjoint() == 10);
  CHECK(quadratic_statements() == 2);
  CHECK(cubic_statements() == 2);
  CHECK(tape.statement_count() == 3);
}

TEST_CASE("libraries on several threads stay apart", "[autodiff][tape]") {
  std::vector<double> slopes(8);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < 4; ++i)
    threads.emplace_back([i, &slopes] {
      for (int again = 0; again < 50; ++again) {
        quadratic_record(static_cast<double>(i), record_cubic);
        slopes[2 * i] = quadratic_slope();
        slopes[2 * i + 1] = cubic_slope();
      }
    });
  for (std::thread& thread : threads) thread.join();
  CHECK(slopes == std::vector<double>{0, 12, 2, 12, 4, 12, 6, 12});
}
