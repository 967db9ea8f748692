#include <tapestry/image/planes.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace image = tapestry::image;
using tapestry::Array;

TEST_CASE("planes_of separates the channels", "[image][planes]") {
  const Array<float, 3> picture = {{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}};
  const Array<float, 3> planes = {{{1, 4}, {7, 10}}, {{2, 5}, {8, 11}}, {{3, 6}, {9, 12}}};
  CHECK((image::planes_of(picture) == planes));
}

TEMPLATE_TEST_CASE("planes go back to the picture", "[image][planes]", float, double) {
  const auto picture = tapestry::test::random_array<TestType>({3, 5, 2}, 1);
  const auto planes = image::planes_of(picture);
  CHECK((image::picture_of_planes<TestType>(planes.data(), picture.shape()) == picture));
  CHECK(
      (image::picture_of_planes<double>(planes.data(), picture.shape()) == tapestry::cast<double>(picture)));
}
