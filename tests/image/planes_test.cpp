#include <tapestry/image/batch.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;

TEST_CASE("planes_of separates the channels", "[image][planes]") {
  const Array<float, 4> pictures = {{{{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {10, 11, 12}}}};
  const Array<float, 4> planes = {{{{1, 4}, {7, 10}}, {{2, 5}, {8, 11}}, {{3, 6}, {9, 12}}}};
  CHECK((image::planes_of(pictures) == planes));
}

TEMPLATE_TEST_CASE("planes go back to the pictures", "[image][planes]", float, double) {
  const auto pictures = test::random_array<TestType>({2, 3, 5, 4}, 1);
  CHECK((image::pictures_of_planes(image::planes_of(pictures)) == pictures));
}
