#include <tapestry/image/batch.hpp>
#include <tapestry/image/transform/chain.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/finite_difference.hpp"
#include "../../support/random_array.hpp"
#include "../../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
image::Warp turned() {
  image::CameraMotion motion;
  motion.pan_rad = 0.05;
  motion.tilt_rad = -0.04;
  motion.roll_rad = 0.1;
  motion.zoom = 1.2;
  return image::warp_of(motion);
}

image::ColourChange printer() {
  image::ColourChange change;
  change.matrix = {{{0.8, 0.05, 0}, {-0.03, 0.7, 0.06}, {0.02, 0, 0.9}}};
  change.offset = {0.1, 0.2, 0.05};
  return change;
}

struct NamedTransformation {
  std::string name;
  image::Transformation transformation;
};

/// One of each kind, and those that cut values; none meets a kink on a picture in .1 to .6.
std::vector<NamedTransformation> all_kinds() {
  image::LightChange shadow{{0.9, 1.1, 1.3}, 0.6, 0.7, 0.1, 0.2};
  return {{"warp", turned()},
          {"light", shadow},
          {"light that burns out", image::LightChange{{4, 1, 9}}},
          {"colour", printer()},
          {"contrast", image::contrast_and_saturation(1.3, 0.7)},
          {"blur", image::Blur{1.3, 0.6}},
          {"noise", image::SensorNoise{0.02, 0.03, 7}},
          {"JPEG, smooth", image::JpegCompression{60, true, true}},
          {"JPEG, smooth, whole chroma", image::JpegCompression{25, false, true}}};
}
}  // namespace

TEST_CASE("every transformation's adjoint equals central differences", "[image][transform][gradient]") {
  for (const auto& [name, transformation] : all_kinds()) {
    INFO(name);
    const auto [height, width] =
        GENERATE(std::pair<std::size_t, std::size_t>(16, 32), std::pair<std::size_t, std::size_t>(13, 21));
    const auto picture = random_array<double>({height, width, 3}, 1, 0.1, 0.6);
    const auto out_adjoint = random_array<double>({height, width, 3}, 2, -1, 1);
    const auto direction = random_array<double>({height, width, 3}, 3, -1, 1);
    const image::TransformationChain chain{transformation};
    Array<double, 3> adjoint = xt::zeros_like(picture);
    image::transformed_adjoint(image::transformation_stages(picture, chain), chain, out_adjoint, adjoint);
    const double h = 1e-7;  // a rounding of JPEG jumps at halves: a short step seldom meets one
    Array<double, 3> ahead = picture + h * direction, behind = picture - h * direction;
    const double slope = (test::dot(out_adjoint, image::transformed(ahead, chain)) -
                          test::dot(out_adjoint, image::transformed(behind, chain))) /
                         (2 * h);
    CHECK(std::abs(slope) > 0.01);
    CHECK(std::abs(test::dot(adjoint, direction) - slope) <= 1e-6 * std::abs(slope) + 1e-7);
  }
}

TEST_CASE("adjoints of transformations add", "[image][transform][gradient]") {
  for (const auto& [name, transformation] : all_kinds()) {
    INFO(name);
    const auto picture = random_array<float>({9, 8, 3}, 1, 0.1, 0.6);
    const auto out_adjoint = random_array<float>({9, 8, 3}, 2, -1, 1);
    const image::TransformationChain chain{transformation};
    const auto stages = image::transformation_stages(picture, chain);
    Array<float, 3> once = xt::zeros_like(picture), onto = tapestry::filled<float, 3>({9, 8, 3}, 8.0F);
    image::transformed_adjoint(stages, chain, out_adjoint, once);
    image::transformed_adjoint(stages, chain, out_adjoint, onto);
    for (std::size_t i = 0; i < once.size(); ++i) CHECK(onto.data()[i] == 8.0F + once.data()[i]);
  }
}

TEST_CASE("a batch of chains on the tape equals each picture's own", "[image][transform][gradient]") {
  const auto kinds = all_kinds();
  std::vector<image::TransformationChain> chains(3);
  chains[0] = {kinds[0].transformation, kinds[1].transformation, kinds[5].transformation};
  chains[2] = {kinds[3].transformation, kinds[6].transformation, kinds[7].transformation};
  const auto pictures = random_array<double>({3, 12, 10, 3}, 4, 0.1, 0.6);
  const auto out_adjoint = random_array<double>({3, 12, 10, 3}, 5, -1, 1);
  ActiveTape<double> tape;
  const auto input = tape.input(pictures);
  const auto out = image::transformed(input, chains);
  tape.reverse(out, out_adjoint);
  const auto adjoint = input.adjoint();
  for (std::size_t n = 0; n < 3; ++n) {
    const auto stages = image::transformation_stages(image::picture_of(pictures, n), chains[n]);
    CHECK((image::picture_of(out.value(), n) == stages.back()));
    CHECK((image::transformed(image::picture_of(pictures, n), chains[n]) == stages.back()));
    Array<double, 3> own = xt::zeros_like(stages.front());
    image::transformed_adjoint(stages, chains[n], image::picture_of(out_adjoint, n), own);
    CHECK((image::picture_of(adjoint, n) == own));
  }
  CHECK((image::picture_of(adjoint, 1) ==
         image::picture_of(out_adjoint, 1)));  // an empty chain changes nothing
}

TEST_CASE("texels are recoloured on the tape as pictures are", "[image][transform][gradient]") {
  const auto texels = random_array<double>({7, 3}, 6, 0.1, 0.6);
  const auto out_adjoint = random_array<double>({7, 3}, 7, -1, 1);
  ActiveTape<double> tape;
  const auto input = tape.input(texels);
  const auto out = image::transformed(input, printer());
  tape.reverse(out, out_adjoint);
  const auto adjoint = input.adjoint();
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(out.value()(i, 0) == Approx(0.8 * texels(i, 0) + 0.05 * texels(i, 1) + 0.1).epsilon(1e-14));
    CHECK(
        adjoint(i, 0) ==
        Approx(0.8 * out_adjoint(i, 0) - 0.03 * out_adjoint(i, 1) + 0.02 * out_adjoint(i, 2)).epsilon(1e-13));
  }
}

TEST_CASE("transformations give the same bits on one thread and two", "[image][transform][determinism]") {
  const auto picture = random_array<float>({70, 50, 3}, 1, 0, 1);
  const auto out_adjoint = random_array<float>({70, 50, 3}, 2, -1, 1);
  image::TransformationChain chain;
  for (const auto& kind : all_kinds()) chain.push_back(kind.transformation);
  same_by_threads({1, 2}, [&] {
    const auto stages = image::transformation_stages(picture, chain);
    Array<float, 3> adjoint = xt::zeros_like(picture);
    image::transformed_adjoint(stages, chain, out_adjoint, adjoint);
    return std::pair(stages.back(), adjoint);
  });
}

TEST_CASE("chains refuse what does not fit", "[image][transform][bad_input]") {
  const auto picture = random_array<double>({8, 8, 3}, 1);
  Array<double, 3> adjoint = xt::zeros_like(picture), small = tapestry::zeros<double, 3>({8, 7, 3});
  const auto grey = random_array<double>({8, 8, 1}, 2);
  for (const auto& [name, transformation] : all_kinds()) {
    INFO(name);
    const image::TransformationChain chain{transformation};
    const auto stages = image::transformation_stages(picture, chain);
    CHECK_THROWS_AS(image::transformed_adjoint(stages, chain, small, adjoint), ShapeError);
    CHECK_THROWS_AS(image::transformed_adjoint(stages, chain, picture, small), ShapeError);
    CHECK_THROWS_AS(image::transformed_adjoint(stages, {}, picture, adjoint), ShapeError);
  }
  CHECK_THROWS_AS(image::transformed(grey, image::LightChange{}), ShapeError);
  CHECK_THROWS_AS(image::transformed(grey, printer()), ShapeError);
  CHECK_THROWS_AS(image::transformed(grey, image::JpegCompression{}), ShapeError);
  CHECK_THROWS_AS(image::transformed(picture, image::JpegCompression{0}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::JpegCompression{101}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::Blur{-1, 0}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::Blur{0, std::nan("")}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::SensorNoise{0.1, 0}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::LightChange{{1, 1, 1}, 1.5}), DomainError);
  CHECK_THROWS_AS(image::transformed(picture, image::LightChange{{0, 1, 1}}), DomainError);
  CHECK_THROWS_AS(image::warp_of({0, 0, 0, 0, 1}), DomainError);
  ActiveTape<double> tape;
  const auto input = tape.input(random_array<double>({2, 4, 4, 3}, 3));
  CHECK_THROWS_AS(image::transformed(input, std::vector<image::TransformationChain>(1)), ShapeError);
}
