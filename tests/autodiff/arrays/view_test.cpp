#include <tapestry/autodiff/detail/arrays/view.hpp>

#include <tapestry/autodiff/detail/arrays/elementwise.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/random_array.hpp"

using tapestry::ArrayVariable, tapestry::test::ActiveTape, tapestry::test::random_array;

TEST_CASE("a matrix put on its side is copied there and back", "[autodiff][view]") {
  ActiveTape<double> tape;
  const auto x = tape.input(random_array<double>({5, 7}, 1));
  const ArrayVariable<double, 2> turned = transpose(x);
  const ArrayVariable<double, 2> part = transpose(slice(x, {{{1, 5, 2}, {3, 7}}}));  // x[1 and 3, 3 to 6]
  const auto seed = random_array<double>({7, 5}, 2), part_seed = random_array<double>({4, 2}, 3);
  REQUIRE(part.shape() == tapestry::Extents<2>{4, 2});
  tape.reverse(turned, seed);
  for (std::size_t i = 0; i < 5; ++i)
    for (std::size_t j = 0; j < 7; ++j) {
      CHECK(turned.value()(j, i) == x.value()(i, j));
      CHECK(x.adjoint()(i, j) == seed(j, i));
    }
  tape.reverse(part, part_seed);
  double total = 0, given = 0;
  for (std::size_t i = 0; i < 2; ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      CHECK(part.value()(j, i) == x.value()(1 + 2 * i, 3 + j));
      CHECK(x.adjoint()(1 + 2 * i, 3 + j) == part_seed(j, i));
      given += part_seed(j, i);
    }
  for (const double entry : x.adjoint().storage()) total += entry;
  CHECK(std::abs(total - given) <= 1e-14);  // and nothing elsewhere
  CHECK(tape.record_count() == 3);
}
