#include <tapestry/loss/smoothness.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// Masks of two pictures, [6, 8, 3]: a corner of one, the whole other.
std::vector<loss::PlacedMask<double>> two_masks() {
  const auto share = [](Array<double, 2> mask) {
    return std::make_shared<const Array<double, 2>>(std::move(mask));
  };
  return {{share(random_array<double>({4, 3}, 1)), 2, 5}, {share(random_array<double>({6, 8}, 2))}};
}
}  // namespace

TEST_CASE("steps of pictures on the tape equal the plain sums of their windows, and so do their adjoints",
          "[loss][gradient]") {
  const auto masks = two_masks();
  ActiveTape<double> tape;
  const ArrayVariable<double, 4> inputs = tape.input(random_array<double>({2, 6, 8, 3}, 3));
  const ArrayVariable<double, 4> pictures = 0.5 * inputs;
  const auto smoothness = loss::smoothness(pictures, masks);
  double sum = 0;
  Array<double, 4> expected = tapestry::zeros<double, 4>({2, 6, 8, 3});
  for (std::size_t n = 0; n < 2; ++n) {
    const auto& mask = masks[n].mask;
    const std::size_t top = masks[n].top, left = masks[n].left;
    Array<double, 3> part({mask->shape(0), mask->shape(1), 3});
    const auto for_each_value = [&](auto visit) {
      for (std::size_t i = 0; i < part.size(); ++i) {
        const std::size_t y = i / 3 / mask->shape(1), x = i / 3 % mask->shape(1);
        visit(i, ((n * 6 + top + y) * 8 + left + x) * 3 + i % 3);
      }
    };
    for_each_value([&](std::size_t i, std::size_t j) { part.data()[i] = pictures.value().data()[j]; });
    sum += loss::smoothness(part, *mask);
    Array<double, 3> of_part = xt::zeros_like(part);
    loss::smoothness_adjoint(part, *mask, 2.0, of_part);
    for_each_value([&](std::size_t i, std::size_t j) { expected.data()[j] = 0.5 * of_part.data()[i]; });
  }
  CHECK(smoothness.value() == sum);
  tape.reverse(Variable<double>(2 * smoothness));
  CHECK((inputs.adjoint() == expected));
}

TEST_CASE("steps of an atlas on the tape count used texels only", "[loss][gradient]") {
  auto used = tapestry::zeros<double, 2>({3, 4});
  used(0, 0) = used(0, 1) = used(2, 3) = 1;  // one step, from (0, 0) to (0, 1)
  const auto shared = std::make_shared<const Array<double, 2>>(used);
  ActiveTape<double> tape;
  const auto texels = tape.input(random_array<double>({12, 3}, 5));
  const auto sum = loss::atlas_smoothness(texels, shared);
  double expected = 0;
  for (std::size_t c = 0; c < 3; ++c) expected += std::pow(texels.value()(1, c) - texels.value()(0, c), 2);
  CHECK(sum.value() == Approx(expected).epsilon(1e-15));
  tape.reverse(sum);
  for (std::size_t texel = 0; texel < 12; ++texel)
    for (std::size_t c = 0; c < 3; ++c) CHECK((texels.adjoint()(texel, c) != 0) == (texel < 2));
}

TEST_CASE("passive pictures record nothing, and masks that do not fit are refused", "[loss][smoothness]") {
  auto masks = two_masks();
  const ArrayVariable<double, 4> passive(random_array<double>({2, 6, 8, 3}, 3));
  ActiveTape<double> tape;
  CHECK_FALSE(loss::smoothness(passive, masks).is_active());
  CHECK(tape.record_count() == 0);
  CHECK_THROWS_WITH(loss::smoothness(passive, {masks[0]}), "smoothness: masks of 1 pictures, expected 2");
  masks[0].top = 3;
  CHECK_THROWS_WITH(loss::smoothness(passive, masks),
                    "smoothness: the window of 4x3 pixels at row 3, column 5 leaves the picture, [6, 8]");
}
