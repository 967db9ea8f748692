#include <cstddef>
#include <tapestry/autodiff.hpp>
#include <thread>
#include <vector>

#include "../libraries/libraries.hpp"
#include "../support/catch.hpp"

using tapestry::Tape;
using tapestry::Variable;

namespace {
void nothing() {}
void record_cubic() { cubic_record(2, nothing); }
/// A statement on whatever tape this program has active.
void record_here() { static_cast<void>(Variable<double>(Variable<double>(3.0) * 2.0)); }
void record_cubic_around_program() { cubic_record(2, record_here); }
}  // namespace

TEST_CASE("two libraries and the program record on their own tapes in turn", "[autodiff][tape]") {
  Tape<double> tape;
  const auto scope = tape.activate();
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

TEST_CASE("a library that is called in the middle of another's recording leaves it alone",
          "[autodiff][tape]") {
  Tape<double> tape;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(5.0);
  quadratic_record(7, record_cubic_around_program);
  const Variable<double> root = x * x;  // on this tape again
  CHECK(quadratic_slope() == 14);
  CHECK(cubic_slope() == 12);
  tape.reverse(root);
  CHECK(x.adjoint() == 10);
  CHECK(quadratic_statements() == 2);
  CHECK(tape.statement_count() == 2);
}

TEST_CASE("libraries on several threads stay apart", "[autodiff][tape]") {
  std::vector<double> slopes(8);
  {
    std::vector<std::jthread> threads;
    for (std::size_t i = 0; i < 4; ++i)
      threads.emplace_back([i, &slopes] {
        for (int again = 0; again < 50; ++again) {
          quadratic_record(static_cast<double>(i), record_cubic);
          slopes[2 * i] = quadratic_slope();
          slopes[2 * i + 1] = cubic_slope();
        }
      });
  }
  CHECK(slopes == std::vector<double>{0, 12, 2, 12, 4, 12, 6, 12});
}
