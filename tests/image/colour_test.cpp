#include <tapestry/image/colour_space.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

TEMPLATE_TEST_CASE("bytes survive the way to colours and back", "[image][colour]", float, double) {
  Array<std::uint8_t, 3> bytes(Extents<3>{16, 16, 1});
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes.data()[i] = static_cast<std::uint8_t>(i);
  CHECK((image::to_bytes(image::from_bytes<TestType>(bytes)) == bytes));
}

TEST_CASE("to_bytes rounds to the nearest byte and clamps what is outside", "[image][colour]") {
  const float nan = std::numeric_limits<float>::quiet_NaN(),
              infinity = std::numeric_limits<float>::infinity();
  const Array<float, 3> picture = {{{-1.0F, 0.0F, 0.0019F, 0.002F, 1.0F, 7.0F, nan, infinity, -infinity}}};
  const Array<std::uint8_t, 3> expected = {{{0, 0, 0, 1, 255, 255, 0, 255, 0}}};
  CHECK((image::to_bytes(picture) == expected));
}

TEST_CASE("swap_red_blue exchanges the outer channels and refuses other pictures", "[image][colour]") {
  const Array<std::uint8_t, 3> bgr = {{{1, 2, 3}, {4, 5, 6}}};
  const Array<std::uint8_t, 3> rgb = {{{3, 2, 1}, {6, 5, 4}}};
  CHECK((image::swap_red_blue(bgr) == rgb));
  CHECK_THROWS_AS(image::swap_red_blue(tapestry::zeros<float, 3>({2, 2, 1})), ShapeError);
}
