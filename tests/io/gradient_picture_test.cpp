#include <tapestry/io/image_file.hpp>

#include "../support/catch.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;

TEMPLATE_TEST_CASE("a gradient is drawn about grey, its largest entry white or black",
                   "[io][gradient_picture]", float, double) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("gradient.png");
  auto gradient = tapestry::zeros<TestType, 4>({1, 1, 2, 3});
  gradient(0, 0, 0, 0) = TestType(-0.008);
  gradient(0, 0, 0, 1) = TestType(0.001);  // ∛(1/8) = 1/2
  gradient(0, 0, 1, 2) = TestType(0.008);
  io::write_gradient(path, gradient);
  const auto picture = io::read_image(path);
  REQUIRE(picture.shape(1) == 2);
  CHECK(picture(0, 0, 0) == 0);
  CHECK(picture(0, 0, 1) == 191);  // 255 · 3/4
  CHECK(picture(0, 0, 2) == 128);
  CHECK(picture(0, 1, 2) == 255);

  gradient.fill(0);
  io::write_gradient(path, gradient);
  CHECK(io::read_image(path)(0, 0, 0) == 128);
}

TEST_CASE("what is no gradient of one picture is not drawn", "[io][gradient_picture][error]") {
  const test::TemporaryFolder folder;
  const std::string path = folder.path("gradient.png");
  CHECK_THROWS_WITH(io::write_gradient(path, tapestry::zeros<float, 4>({2, 4, 5, 3})),
                    "write_gradient: gradient is [2, 4, 5, 3], expected [1, 4, 5, 3]");
  auto gradient = tapestry::zeros<float, 4>({1, 4, 5, 3});
  gradient(0, 1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(io::write_gradient(path, gradient), NumericError);
}
