#include <tapestry/autodiff/detail/arrays/join.hpp>

#include <tapestry/autodiff/detail/arrays/reduction.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::DomainError, tapestry::Tape, tapestry::Variable,
    tapestry::test::ActiveTape, tapestry::test::random_array;

TEST_CASE("concatenate puts arrays side by side, and its pullback takes them apart", "[autodiff][join]") {
  for (const std::size_t axis : {0U, 1U, 2U}) {
    ActiveTape<double> tape;
    std::size_t lengths[] = {2, 1, 3}, total = 6;
    std::vector<ArrayVariable<double, 3>> parts;
    for (std::size_t p = 0; p < 3; ++p) {
      tapestry::Extents<3> extents{2, 2, 2};
      extents[axis] = lengths[p];
      parts.push_back(tape.input(random_array<double>({extents[0], extents[1], extents[2]}, 10 + p)));
    }
    const ArrayVariable<double, 3> whole = tapestry::concatenate<double, 3>(parts, axis);
    tapestry::Extents<3> expected{2, 2, 2};
    expected[axis] = total;
    REQUIRE(whole.shape() == expected);
    const auto seed = random_array<double>({expected[0], expected[1], expected[2]}, 20);
    tape.reverse(whole, seed);
    std::size_t first = 0;
    for (std::size_t p = 0; p < 3; first += lengths[p++])
      for (std::size_t i = 0; i < parts[p].shape()[0]; ++i)
        for (std::size_t j = 0; j < parts[p].shape()[1]; ++j)
          for (std::size_t k = 0; k < parts[p].shape()[2]; ++k) {
            std::size_t at[] = {i, j, k};
            at[axis] += first;
            CHECK(whole.value()(at[0], at[1], at[2]) == parts[p].value()(i, j, k));
            CHECK(parts[p].adjoint()(i, j, k) == seed(at[0], at[1], at[2]));
          }
  }
}

TEST_CASE("an array part may be passive or stand twice", "[autodiff][join]") {
  ActiveTape<double> tape;
  const ArrayVariable<double, 1> x = tape.input(Array<double, 1>{1, 2});
  const ArrayVariable<double, 1> constant = Array<double, 1>{7};
  const auto joined = tapestry::concatenate<double, 1>(std::vector{x, constant, x}, 0);
  CHECK(joined.value() == Array<double, 1>{1, 2, 7, 1, 2});
  tape.reverse(sum(joined * joined));
  CHECK(x.adjoint() == Array<double, 1>{4, 8});
  const std::size_t records = tape.record_count();
  CHECK_FALSE(tapestry::concatenate<double, 1>(std::vector{constant, constant}, 0).is_active());
  CHECK(tape.record_count() == records);
}

TEST_CASE("scalars become an array and elements become scalars", "[autodiff][join]") {
  ActiveTape<double> tape;
  const Variable<double> a = tape.input(2.0), b = tape.input(3.0);
  const std::vector<Variable<double>> scalars = {a, b, 5.0, a * b};
  const ArrayVariable<double, 2> x = tapestry::array_of<double, 2>(scalars, {2, 2});
  CHECK(x.value() == Array<double, 2>{{2, 3}, {5, 6}});
  tape.reverse(sum(x * x));  // a² + b² + 25 + a²b²
  CHECK(a.adjoint() == 4 + 2 * 2 * 9);
  CHECK(b.adjoint() == 6 + 2 * 4 * 3);
}

TEST_CASE("joins name what does not fit", "[autodiff][join]") {
  Tape<double> tape, other;
  const auto scope = tape.activate();
  const ArrayVariable<double, 2> x = tape.input(random_array<double>({2, 3}, 1));
  const ArrayVariable<double, 2> y = tape.input(random_array<double>({2, 2}, 2));
  const ArrayVariable<double, 2> foreign = other.input(random_array<double>({2, 3}, 3));
  CHECK(tapestry::concatenate<double, 2>(std::vector{x, y}, 1).shape() == tapestry::Extents<2>{2, 5});
  CHECK_THROWS_WITH((tapestry::concatenate<double, 2>(std::vector{x, y}, 0)),
                    "concatenate: part is [2, 2], expected [2, 3]");
  CHECK_THROWS_WITH((tapestry::concatenate<double, 2>(std::vector{x}, 2)),
                    "concatenate: 1 arrays along axis 2 of 2");
  CHECK_THROWS_WITH((tapestry::concatenate<double, 2>({}, 0)), "concatenate: 0 arrays along axis 0 of 2");
  CHECK_THROWS_AS((tapestry::concatenate<double, 2>(std::vector{x, foreign}, 0)), DomainError);
  const std::vector<Variable<double>> scalars(3);
  CHECK_THROWS_WITH((tapestry::array_of<double, 1>(scalars, {4})),
                    "array_of: 3 elements, expected those of [4]");
}
