#include <tapestry/loss/smoothness.hpp>

#include <cmath>
#include <memory>
#include <vector>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace loss = tapestry::loss;
using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::Tape;
using tapestry::Variable;
using tapestry::test::random_array;

namespace {
loss::SharedMasks<double> two_masks() {
  const auto share = [](Array<double, 2> mask) {
    return std::make_shared<const Array<double, 2>>(std::move(mask));
  };
  return {share(random_array<double>({5, 7}, 1)), share(random_array<double>({4, 3}, 2))};
}
}  // namespace

TEST_CASE("steps of pictures on the tape equal the plain sums, and so do their adjoints",
          "[loss][gradient]") {
  const auto masks = two_masks();
  Tape<double> tape;
  const auto scope = tape.activate();
  const std::vector<ArrayVariable<double, 3>> pictures{tape.input(random_array<double>({5, 7, 3}, 3)),
                                                       tape.input(random_array<double>({4, 3, 3}, 4))};
  const auto smoothness = loss::smoothness(pictures, masks);
  CHECK(smoothness.value() ==
        loss::smoothness(pictures[0].value(), *masks[0]) + loss::smoothness(pictures[1].value(), *masks[1]));
  tape.reverse(Variable<double>(2 * smoothness));
  for (std::size_t n = 0; n < 2; ++n) {
    Array<double, 3> expected = xt::zeros_like(pictures[n].value());
    loss::smoothness_adjoint(pictures[n].value(), *masks[n], 2.0, expected);
    CHECK((pictures[n].adjoint() == expected));
  }
}

TEST_CASE("a picture that is there twice receives both adjoints", "[loss][gradient]") {
  const auto mask = two_masks()[0];
  Tape<double> tape;
  const auto scope = tape.activate();
  const auto picture = tape.input(random_array<double>({5, 7, 3}, 3));
  tape.reverse(loss::smoothness(std::vector{picture, picture}, {mask, mask}));
  const auto twice = picture.adjoint();
  tape.reverse(loss::smoothness(picture, *mask));
  CHECK((twice == Array<double, 3>(2.0 * picture.adjoint())));
}

TEST_CASE("steps of an atlas on the tape count used texels only", "[loss][gradient]") {
  auto used = tapestry::zeros<double, 2>({3, 4});
  used(0, 0) = used(0, 1) = used(2, 3) = 1;  // one step, from (0, 0) to (0, 1)
  const auto shared = std::make_shared<const Array<double, 2>>(used);
  Tape<double> tape;
  const auto scope = tape.activate();
  const auto texels = tape.input(random_array<double>({12, 3}, 5));
  const auto sum = loss::atlas_smoothness(texels, shared);
  double expected = 0;
  for (std::size_t c = 0; c < 3; ++c) expected += std::pow(texels.value()(1, c) - texels.value()(0, c), 2);
  CHECK(sum.value() == Approx(expected).epsilon(1e-15));
  tape.reverse(sum);
  for (std::size_t texel = 0; texel < 12; ++texel)
    for (std::size_t c = 0; c < 3; ++c) CHECK((texels.adjoint()(texel, c) != 0) == (texel < 2));
}

TEST_CASE("passive pictures record nothing, and wrong numbers of masks are refused", "[loss][smoothness]") {
  const auto masks = two_masks();
  const std::vector<ArrayVariable<double, 3>> passive{random_array<double>({5, 7, 3}, 3)};
  Tape<double> tape;
  const auto scope = tape.activate();
  CHECK_FALSE(loss::smoothness(passive, {masks[0]}).is_active());
  CHECK(tape.record_count() == 0);
  CHECK_THROWS_WITH(loss::smoothness(passive, masks), "smoothness: masks of 2 pictures, expected 1");
  CHECK_THROWS_WITH(loss::smoothness(passive, {masks[1]}), "smoothness: mask is [4, 3], expected [5, 7]");
}
