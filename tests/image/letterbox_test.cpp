#include <tapestry/image/letterbox.hpp>

#include <algorithm>
#include <tapestry/detect/box_overlap.hpp>
#include <vector>

#include "../support/catch.hpp"

namespace image = tapestry::image;
using tapestry::detect::Box;

namespace {
struct Sizes {
  std::size_t picture_height, picture_width, height, width;
};

/// Even and odd sizes, both aspects, and pictures so thin that they are placed one pixel wide.
const std::vector<Sizes> all_sizes{{416, 416, 416, 416}, {800, 600, 416, 416}, {480, 640, 416, 416},
                                   {333, 777, 416, 416}, {777, 333, 415, 417}, {1, 1, 31, 32},
                                   {1, 5000, 416, 416},  {5000, 1, 416, 415},  {3, 65536, 256, 608}};
}  // namespace

TEST_CASE("letterbox places by hand", "[image][letterbox]") {
  const auto wide = image::letterbox(480, 640, 416, 416);
  CHECK((wide.height == 312 && wide.width == 416 && wide.top == 52 && wide.left == 0));
  const auto high = image::letterbox(777, 333, 415, 417);  // 177.9 wide, as odd as the canvas
  CHECK((high.height == 415 && high.width == 177 && high.top == 0 && high.left == 120));
  CHECK_THROWS_AS(image::letterbox(0, 3, 416, 416), tapestry::DomainError);
  CHECK_THROWS_AS(image::picture_from_canvas(3, 3, 0, 416), tapestry::DomainError);
}

TEST_CASE("what is placed on the canvas comes back to the picture", "[image][letterbox]") {
  for (const auto& size : all_sizes) {
    CAPTURE(size.picture_height, size.picture_width, size.height, size.width);
    const auto place = image::letterbox(size.picture_height, size.picture_width, size.height, size.width);
    const auto back =
        image::picture_from_canvas(size.picture_height, size.picture_width, size.height, size.width);
    const auto picture_width = static_cast<double>(size.picture_width);
    const auto picture_height = static_cast<double>(size.picture_height);
    const double x_share = static_cast<double>(place.width) / picture_width;
    const double y_share = static_cast<double>(place.height) / picture_height;
    for (const double x : {0.0, 0.3, 1.0})
      for (const double y : {0.0, 0.7, 1.0}) {
        const Box box{x * picture_width, y * picture_height, 0.5 * picture_width, 0.25 * picture_height};
        const Box placed{static_cast<double>(place.left) + box.cx * x_share,
                         static_cast<double>(place.top) + box.cy * y_share, box.w * x_share, box.h * y_share};
        CHECK(back.x(placed.cx) == Approx(box.cx).margin(1e-9));
        CHECK(back.y(placed.cy) == Approx(box.cy).margin(1e-9));
        CHECK(back.width(placed.w) == Approx(box.w));
        CHECK(back.height(placed.h) == Approx(box.h));
      }
  }
}

TEST_CASE("the corners of the letterboxed picture come back to its corners", "[image][letterbox]") {
  for (const auto& size : all_sizes) {
    CAPTURE(size.picture_height, size.picture_width, size.height, size.width);
    const auto white = tapestry::filled<float, 3>({size.picture_height, size.picture_width, 1}, 1.0F);
    const auto canvas = image::letterboxed(white, size.height, size.width, 0.0F);
    std::size_t left = size.width, top = size.height, right = 0, bottom = 0;
    for (std::size_t y = 0; y < size.height; ++y)
      for (std::size_t x = 0; x < size.width; ++x) {
        if (canvas(y, x, 0) == 0) continue;
        left = std::min(left, x), top = std::min(top, y);
        right = std::max(right, x + 1), bottom = std::max(bottom, y + 1);
      }
    const auto back =
        image::picture_from_canvas(size.picture_height, size.picture_width, size.height, size.width);
    CHECK(back.x(static_cast<double>(left)) == 0);
    CHECK(back.y(static_cast<double>(top)) == 0);
    CHECK(back.x(static_cast<double>(right)) == Approx(static_cast<double>(size.picture_width)));
    CHECK(back.y(static_cast<double>(bottom)) == Approx(static_cast<double>(size.picture_height)));
  }
}
