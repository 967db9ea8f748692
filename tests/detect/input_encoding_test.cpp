#include <tapestry/detect/detector_description.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace detect = tapestry::detect;
using detect::ColourOrder, detect::InputEncoding, tapestry::test::random_array;

TEST_CASE("encoded pictures equal those worked out by hand", "[detect][input_encoding]") {
  const tapestry::Array<double, 4> picture{{{{0.2, 0.4, 0.6}}}};
  const auto bytes = detect::encoded(picture, {ColourOrder::bgr, 1});
  CHECK(bytes(0, 0, 0, 0) == Approx(153).epsilon(1e-15));
  CHECK(bytes(0, 0, 0, 1) == Approx(102).epsilon(1e-15));
  CHECK(bytes(0, 0, 0, 2) == Approx(51).epsilon(1e-15));
  const InputEncoding nanodet{ColourOrder::bgr, 1, {103.53, 116.28, 123.675}, {57.375, 57.12, 58.395}};
  const auto normal = detect::encoded(picture, nanodet);
  CHECK(normal(0, 0, 0, 0) == Approx((153 - 103.53) / 57.375).epsilon(1e-14));
  CHECK(normal(0, 0, 0, 1) == Approx((102 - 116.28) / 57.12).epsilon(1e-14));
  CHECK(normal(0, 0, 0, 2) == Approx((51 - 123.675) / 58.395).epsilon(1e-14));
  const auto rgb = detect::encoded(picture, {ColourOrder::rgb, 0.01, {1, 2, 3}, {2, 4, 8}});
  CHECK(rgb(0, 0, 0, 2) == Approx((1.53 - 3) / 8).epsilon(1e-14));
}

TEMPLATE_TEST_CASE("the default encoding is the picture, bit for bit", "[detect][input_encoding]", float,
                   double) {
  const auto pictures = random_array<TestType>({2, 3, 4, 3}, 1);
  CHECK((detect::encoded(pictures, {}) == pictures));
}

TEMPLATE_TEST_CASE("the adjoint of an encoding is the transpose of what it does to steps",
                   "[detect][input_encoding][gradient]", float, double) {
  const InputEncoding encoding{ColourOrder::bgr, 1, {103.53, 116.28, 123.675}, {57.375, 57.12, 58.395}};
  const auto x0 = random_array<TestType>({2, 3, 4, 3}, 1);
  const auto step = random_array<TestType>({2, 3, 4, 3}, 2, -1, 1);
  const auto g = random_array<TestType>({2, 3, 4, 3}, 3, -1, 1);
  InputEncoding linear = encoding;  // A of the affine A·x + b
  linear.mean = {0, 0, 0};
  const auto product = static_cast<double>(tapestry::test::dot(g, detect::encoded(step, linear)));
  tapestry::test::ActiveTape<TestType> tape;
  const auto x = tape.input(x0);
  const auto y = detect::encoded(x, encoding);
  CHECK((y.value() == detect::encoded(x0, encoding)));
  tape.reverse(y, g);
  // 72 products below 5, each of a few roundings
  CHECK(std::abs(static_cast<double>(tapestry::test::dot(x.adjoint(), step)) - product) <=
        72 * 5 * 4 * static_cast<double>(std::numeric_limits<TestType>::epsilon()));
}

TEST_CASE("only colour pictures are encoded", "[detect][input_encoding]") {
  CHECK_THROWS_WITH(detect::encoded(random_array<float>({1, 2, 2, 4}, 1), {}),
                    "encoded: pictures is [1, 2, 2, 4], expected [1, 2, 2, 3]");
  auto adjoint = tapestry::zeros<float, 4>({1, 2, 2, 3});
  CHECK_THROWS_AS(detect::encoded_adjoint(random_array<float>({1, 2, 3, 3}, 1), {}, adjoint),
                  tapestry::ShapeError);
}
