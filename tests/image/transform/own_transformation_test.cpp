#include <tapestry/image/detail/transform/own_transformation.hpp>
#include <tapestry/image/transform/chain.hpp>

#include <tapestry/image/batch.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/finite_difference.hpp"
#include "../../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace photographer {
/// out = value^gamma · brightness, as someone without a look into the library writes it.
struct Development {
  double gamma = 1.5;
  double brightness = 0.8;
};

template <class T>
Array<T, 3> transformed(const Array<T, 3>& picture, const Development& own) {
  Array<T, 3> out(picture.shape());
  for (std::size_t i = 0; i < out.size(); ++i)
    out.data()[i] = static_cast<T>(own.brightness) * std::pow(picture.data()[i], static_cast<T>(own.gamma));
  return out;
}

template <class T>
void transformed_adjoint(const Array<T, 3>& picture, const Development& own, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  for (std::size_t i = 0; i < picture.size(); ++i)
    picture_adjoint.data()[i] += out_adjoint.data()[i] * static_cast<T>(own.brightness * own.gamma) *
                                 std::pow(picture.data()[i], static_cast<T>(own.gamma - 1));
}

/// Cuts a row off, which a chain does not take.
struct Cut {};
template <class T>
Array<T, 3> transformed(const Array<T, 3>& picture, const Cut&) {
  return tapestry::zeros<T, 3>({picture.shape(0) - 1, picture.shape(1), 3});
}
template <class T>
void transformed_adjoint(const Array<T, 3>&, const Cut&, const Array<T, 3>&, Array<T, 3>&) {}

/// Has no adjoint.
struct OneWay {};
template <class T>
Array<T, 3> transformed(const Array<T, 3>& picture, const OneWay&) {
  return picture;
}
}  // namespace photographer

static_assert(std::constructible_from<image::Transformation, photographer::Development>);
static_assert(!std::constructible_from<image::Transformation, photographer::OneWay>);
static_assert(!std::constructible_from<image::Transformation, int>);

TEST_CASE("a user's transformation gives its own picture, and ours keep their kind", "[image][transform]") {
  const auto picture = random_array<float>({5, 6, 3}, 1, 0.1, 0.9);
  const image::TransformationChain chain{photographer::Development{}, image::Blur{1, 1}};
  CHECK(std::holds_alternative<image::OwnTransformation>(chain[0]));
  CHECK(std::holds_alternative<image::Blur>(chain[1]));
  const auto stages = image::transformation_stages(picture, chain);
  CHECK((stages[1] == transformed(picture, photographer::Development{})));
  CHECK((stages[2] == image::transformed(stages[1], image::Blur{1, 1})));
  CHECK(stages[1](0, 0, 0) == Approx(0.8 * std::pow(picture(0, 0, 0), 1.5)));
}

TEMPLATE_TEST_CASE("a chain with a user's transformation between ours agrees with central differences",
                   "[image][transform][gradient]", float, double) {
  using T = TestType;
  const auto picture = random_array<T>({9, 8, 3}, 1, 0.2, 0.7);
  const auto weights = test::random_direction<T>({9, 8, 3}, 2);
  const auto direction = test::random_direction<T>({9, 8, 3}, 3);
  const image::TransformationChain chain{image::Blur{0.8, 1.1}, photographer::Development{1.7, 0.9},
                                         image::contrast_and_saturation(1.2, 0.8)};
  Array<T, 3> adjoint = xt::zeros_like(picture);
  const Array<T, 3> half = weights / T(2);
  for (int i = 0; i < 2; ++i)  // two halves make a whole only if the adjoint adds
    image::transformed_adjoint(image::transformation_stages(picture, chain), chain, half, adjoint);
  const auto value = [&](const Array<T, 3>& x) { return test::dot(weights, image::transformed(x, chain)); };
  CHECK(std::abs(test::dot(adjoint, direction) - test::central_difference(value, picture, direction)) <=
        test::central_difference_tolerance(value(picture)));
}

TEST_CASE("a batch on the tape runs a user's transformation on its pictures alone",
          "[image][transform][gradient]") {
  const auto pictures = random_array<double>({2, 6, 5, 3}, 4, 0.1, 0.6);
  const auto seed = random_array<double>({2, 6, 5, 3}, 5, -1, 1);
  const photographer::Development own;
  ActiveTape<double> tape;
  const auto input = tape.input(pictures);
  const auto out = image::transformed(input, std::vector<image::TransformationChain>{{}, {own}});
  tape.reverse(out, seed);
  const auto adjoint = input.adjoint();
  CHECK((image::picture_of(out.value(), 0) == image::picture_of(pictures, 0)));
  CHECK((image::picture_of(adjoint, 0) == image::picture_of(seed, 0)));
  const auto second = image::picture_of(pictures, 1);
  Array<double, 3> expected = xt::zeros_like(second);
  transformed_adjoint(second, own, image::picture_of(seed, 1), expected);
  CHECK((image::picture_of(out.value(), 1) == transformed(second, own)));
  CHECK((image::picture_of(adjoint, 1) == expected));
}

TEST_CASE("a user's transformation keeps the picture's extents", "[image][transform][bad_input]") {
  const auto picture = random_array<double>({4, 4, 3}, 1);
  CHECK_THROWS_WITH(image::transformed(picture, image::TransformationChain{photographer::Cut{}}),
                    "transformed: the result of an own transformation is [3, 4, 3], expected [4, 4, 3]");
  const image::OwnTransformation own(photographer::Development{});
  Array<double, 3> small = tapestry::zeros<double, 3>({4, 3, 3}), adjoint = xt::zeros_like(picture);
  CHECK_THROWS_AS(image::transformed_adjoint(picture, own, small, adjoint), ShapeError);
  CHECK_THROWS_AS(image::transformed_adjoint(picture, own, picture, small), ShapeError);
}
