#include <tapestry/image/resize.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using tapestry::Tape, tapestry::test::random_array;

TEST_CASE("resize_bilinear on the tape: its pullback is its transpose", "[image][resize]") {
  const auto x0 = random_array<double>({5, 4, 3}, 1, -1, 1);
  tapestry::test::ActiveTape<double> tape;
  const auto x = tape.input(x0);
  const auto y = tapestry::image::resize_bilinear(x, 7, 3);
  const auto g = random_array<double>({7, 3, 3}, 2, -1, 1);
  tape.reverse(y, g);
  CHECK(std::abs(tapestry::test::dot(x.adjoint(), x0) - tapestry::test::dot(g, y.value())) <= 1e-13);
}
