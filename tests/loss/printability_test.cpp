#include <tapestry/loss/printability.hpp>

#include "../support/active_tape.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/threads.hpp"

using namespace tapestry;

namespace {
const Array<double, 2> black_and_white = {{0, 0, 0}, {1, 1, 1}};
const Array<double, 2> red = {{0.9, 0.1, 0.2}};

template <class T>
Array<T, 2> all_used(std::size_t height, std::size_t width) {
  return tapestry::filled<T, 2>({height, width}, 1);
}
}  // namespace

TEST_CASE("the non-printability score of one printable colour is the squared distance",
          "[loss][printability]") {
  const Array<double, 2> texels = {{0.9, 0.1, 0.2}, {0, 0, 0}, {1, 1, 1}, {0.5, 0.5, 0.5}};
  const Array<double, 2> used = {{1, 1}, {1, 0}};
  const double black = 0.81 + 0.01 + 0.04, white = 0.01 + 0.81 + 0.64;
  CHECK(loss::non_printability(texels, used, red) == Approx((0 + black + white) / 3).epsilon(1e-14));
  CHECK(loss::non_printability(texels, used, red, 1e-3) ==
        Approx((0 + black + white) / 3).epsilon(1e-14));  // however narrow
}

TEST_CASE("the score lies between the squared distance to the nearest colour and 2σ² ln K more",
          "[loss][printability]") {
  const auto palette = loss::printable_colours();
  const auto texels = test::random_array<double>({1, 3}, 7);
  double nearest = 3;
  for (std::size_t k = 0; k < palette.shape(0); ++k) {
    double distance = 0;
    for (std::size_t c = 0; c < 3; ++c) distance += std::pow(texels(0, c) - palette(k, c), 2);
    nearest = std::min(nearest, distance);
  }
  for (const double spread : {1e-6, 0.01, 0.05, 0.3}) {
    const double score = loss::non_printability(texels, all_used<double>(1, 1), palette, spread);
    CHECK(score >= nearest - 1e-12);
    CHECK(score <= nearest + 2 * spread * spread * std::log(64.0) + 1e-12);
  }
  // A colour named twice is no more printable than once.
  const Array<double, 2> twice = {{0.9, 0.1, 0.2}, {0.9, 0.1, 0.2}};
  CHECK(loss::non_printability(texels, all_used<double>(1, 1), twice) ==
        Approx(loss::non_printability(texels, all_used<double>(1, 1), red)).epsilon(1e-13));
}

TEMPLATE_TEST_CASE("non_printability_adjoint agrees with central differences", "[loss][gradient]", float,
                   double) {
  const auto texels = test::random_array<TestType>({12, 3}, 3);
  const auto used = test::random_array<TestType>({3, 4}, 4);
  const auto direction = test::random_direction<TestType>({12, 3}, 5);
  for (const auto& palette : {loss::printable_colours(), black_and_white, red}) {
    constexpr double spread = 0.3;  // so that several colours share
    const auto value = [&](const auto& colours) {
      return loss::non_printability(colours, used, palette, spread);
    };
    Array<TestType, 2> gradient = xt::zeros_like(texels);
    for (int half = 0; half < 2; ++half)  // two halves make a whole only if the adjoint adds
      loss::non_printability_adjoint(texels, used, palette, spread, TestType(0.5), gradient);
    // Third derivatives of a log-sum of Gaussians: below 2 · |p|³/σ⁴ · 2σ², some hundreds.
    const auto tolerance = 100 * test::central_difference_tolerance(value(texels));
    CHECK(std::abs(test::dot(gradient, direction) - test::central_difference(value, texels, direction)) <=
          tolerance);
  }
}

TEST_CASE("the gradient in double agrees with central differences to 1e-6 at saturated colours too",
          "[loss][gradient]") {
  Array<double, 2> texels = {{0, 0, 0}, {1, 1, 1}, {1, 0, 1}, {0.05, 0.35, 0.95}, {0.2, 0.2, 0.2}};
  const auto used = all_used<double>(1, 5);
  const auto palette = loss::printable_colours();
  auto gradient = tapestry::zeros<double, 2>({5, 3});
  loss::non_printability_adjoint(texels, used, palette, loss::printable_spread, 1.0, gradient);
  const auto value = [&] { return loss::non_printability(texels, used, palette); };
  for (std::size_t i = 0; i < texels.size(); ++i)
    CHECK(std::abs(gradient.data()[i] - test::slope_by(texels.data()[i], 1e-5, value)) <= 1e-6);
}

TEST_CASE("midway between two printable colours nothing pulls along their line", "[loss][printability]") {
  const Array<double, 2> grey = {{0.5, 0.5, 0.5}};
  for (const double spread : {0.05, 1e-8}) {
    auto gradient = tapestry::zeros<double, 2>({1, 3});
    loss::non_printability_adjoint(grey, all_used<double>(1, 1), black_and_white, spread, 1.0, gradient);
    for (const double slope : gradient.storage()) CHECK(slope == 0);
  }
}

TEST_CASE("texels that no face refers to neither count nor move", "[loss][printability]") {
  auto texels = test::random_array<double>({4, 3}, 8);
  const Array<double, 2> used = {{1, 0}, {0, 1}};
  const double before = loss::non_printability(texels, used, red);
  texels(1, 2) = texels(2, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(loss::non_printability(texels, used, red) == before);
  auto gradient = tapestry::zeros<double, 2>({4, 3});
  loss::non_printability_adjoint(texels, used, red, 0.05, 1.0, gradient);
  for (std::size_t c = 0; c < 3; ++c) CHECK((gradient(1, c) == 0 && gradient(2, c) == 0));
  CHECK(loss::non_printability(texels, tapestry::zeros<double, 2>({2, 2}), red) == 0);
  texels(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(loss::non_printability(texels, used, red)));  // other texels do not hide it
}

TEST_CASE("on the tape the score has its value and its gradient, for any number of threads",
          "[loss][printability]") {
  const auto texels = test::random_array<float>({2048, 3}, 9);
  const auto used = std::make_shared<const Array<float, 2>>(all_used<float>(32, 64));
  const auto palette = std::make_shared<const Array<double, 2>>(loss::printable_colours());
  Array<float, 2> expected = xt::zeros_like(texels);
  loss::non_printability_adjoint(texels, *used, *palette, 0.05, 3.0F, expected);
  const float value = test::same_by_threads({1, 2}, [&] {
    test::ActiveTape<float> tape;
    const ArrayVariable<float, 2> input = tape.input(texels);
    const auto score = loss::non_printability(input, used, palette);
    tape.reverse(3.0F * score);
    CHECK((input.adjoint() == expected));
    return score.value();
  });
  CHECK(value == loss::non_printability(texels, *used, *palette));
}

TEST_CASE("texels, palettes and spreads that are none are refused", "[loss][printability]") {
  const auto texels = test::random_array<double>({4, 3}, 6);
  const auto used = all_used<double>(2, 2);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(loss::non_printability(texels, all_used<double>(2, 3), red),
                    "non_printability: texels is [4, 3], expected [6, 3]");
  CHECK_THROWS_AS(loss::non_printability(texels, used, tapestry::zeros<double, 2>({0, 3})), ShapeError);
  CHECK_THROWS_AS(loss::non_printability(texels, used, tapestry::zeros<double, 2>({2, 4})), ShapeError);
  for (const double channel : {nan, -0.1, 1.1})
    CHECK_THROWS_WITH(loss::non_printability(texels, used, Array<double, 2>{{0.5, channel, 0.5}}),
                      contains("expected channels from 0 to 1"));
  for (const double spread : {0.0, -1.0, 1e-170, 1e200, nan, std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(loss::non_printability(texels, used, red, spread), DomainError);
  auto adjoint = tapestry::zeros<double, 2>({3, 3});
  CHECK_THROWS_AS(loss::non_printability_adjoint(texels, used, red, 0.05, 1.0, adjoint), ShapeError);
}
