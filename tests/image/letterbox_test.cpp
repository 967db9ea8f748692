#include <tapestry/image/letterbox.hpp>

#include <tapestry/detect/box_overlap.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace image = tapestry::image;
using image::FitKind, tapestry::detect::Box;

namespace {
struct Sizes {
  std::size_t picture_height, picture_width, height, width;
};

/// Even and odd sizes, both aspects, and pictures so thin that they are placed one pixel wide.
const std::vector<Sizes> all_sizes{{416, 416, 416, 416}, {800, 600, 416, 416}, {480, 640, 416, 416},
                                   {333, 777, 416, 416}, {777, 333, 415, 417}, {1, 1, 31, 32},
                                   {1, 5000, 416, 416},  {5000, 1, 416, 415},  {3, 65536, 256, 608}};
}  // namespace

TEST_CASE("fits place by hand", "[image][letterbox]") {
  const auto is = [](const image::Placement& place, std::size_t height, std::size_t width, std::size_t top,
                     std::size_t left) {
    return place.height == height && place.width == width && place.top == top && place.left == left;
  };
  CHECK(is(image::placement(480, 640, 416, 416), 312, 416, 52, 0));
  CHECK(is(image::placement(777, 333, 415, 417), 415, 177, 0, 120));  // 177.9 wide, as odd as the canvas
  CHECK(is(image::placement(480, 640, 416, 416, FitKind::letterbox_top_left), 312, 416, 0, 0));
  CHECK(is(image::placement(777, 333, 415, 418, FitKind::letterbox_top_left), 415, 177, 0, 0));
  CHECK(is(image::placement(480, 640, 416, 320, FitKind::stretch), 416, 320, 0, 0));
  for (const auto kind : image::fit_kinds) {
    CHECK_THROWS_AS(image::placement(0, 3, 416, 416, kind), tapestry::DomainError);
    CHECK_THROWS_AS(image::picture_from_canvas(3, 3, 0, 416, kind), tapestry::DomainError);
    CHECK(is(image::placement(7, 7, 21, 21, kind), 21, 21, 0, 0));  // with equal shapes all kinds agree
  }
}

TEST_CASE("fits have names", "[image][letterbox]") {
  for (const auto kind : image::fit_kinds) CHECK(image::fit_by_name(image::name_of(kind)).kind == kind);
  CHECK(image::fit_by_name("letterbox") == image::Fit{});
  CHECK(image::fit_by_name("letterbox_top_left").fill == 114.0 / 255);
  CHECK_THROWS_WITH(image::fit_by_name("crop"),
                    "no fit is called 'crop'; expected letterbox, letterbox_top_left or stretch");
}

TEST_CASE("what is placed on the canvas comes back to the picture", "[image][letterbox]") {
  const auto kind = GENERATE(FitKind::letterbox, FitKind::letterbox_top_left, FitKind::stretch);
  for (const auto& size : all_sizes) {
    CAPTURE(image::name_of(kind), size.picture_height, size.picture_width, size.height, size.width);
    const auto place =
        image::placement(size.picture_height, size.picture_width, size.height, size.width, kind);
    const auto back =
        image::picture_from_canvas(size.picture_height, size.picture_width, size.height, size.width, kind);
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

TEST_CASE("the corners of the fitted picture come back to its corners", "[image][letterbox]") {
  const auto kind = GENERATE(FitKind::letterbox, FitKind::letterbox_top_left, FitKind::stretch);
  for (const auto& size : all_sizes) {
    CAPTURE(image::name_of(kind), size.picture_height, size.picture_width, size.height, size.width);
    const auto white = tapestry::filled<float, 3>({size.picture_height, size.picture_width, 1}, 1.0F);
    const auto canvas = image::fitted(white, size.height, size.width, {kind, 0});
    std::size_t left = size.width, top = size.height, right = 0, bottom = 0;
    for (std::size_t y = 0; y < size.height; ++y)
      for (std::size_t x = 0; x < size.width; ++x) {
        if (canvas(y, x, 0) == 0) continue;
        left = std::min(left, x), top = std::min(top, y);
        right = std::max(right, x + 1), bottom = std::max(bottom, y + 1);
      }
    const auto back =
        image::picture_from_canvas(size.picture_height, size.picture_width, size.height, size.width, kind);
    CHECK(back.x(static_cast<double>(left)) == 0);
    CHECK(back.y(static_cast<double>(top)) == 0);
    CHECK(back.x(static_cast<double>(right)) == Approx(static_cast<double>(size.picture_width)));
    CHECK(back.y(static_cast<double>(bottom)) == Approx(static_cast<double>(size.picture_height)));
  }
}

TEST_CASE("a stretched picture is the resized one, and a letterbox has its fill around it",
          "[image][letterbox]") {
  const auto picture = tapestry::test::random_array<double>({5, 4, 3}, 1, 0.1, 1);
  CHECK((image::fitted(picture, 9, 12, {FitKind::stretch, 0}) == image::resize_bilinear(picture, 9, 12)));
  const auto corner = image::fitted(picture, 9, 12, {FitKind::letterbox_top_left, 0.25});
  CHECK((image::crop(corner, {0, 0, 9, 7}) == image::resize_bilinear(picture, 9, 7)));
  for (std::size_t y = 0; y < 9; ++y)
    for (std::size_t x = 7; x < 12; ++x) CHECK(corner(y, x, 1) == 0.25);
  CHECK((image::fitted(picture, 9, 12, {}) == image::letterboxed(picture, 9, 12, 0.5)));
}

TEST_CASE("the adjoint of a fit is its transpose, alone and on the tape", "[image][letterbox][gradient]") {
  const auto kind = GENERATE(FitKind::letterbox, FitKind::letterbox_top_left, FitKind::stretch);
  const auto x0 = tapestry::test::random_array<double>({5, 4, 3}, 1, -1, 1);
  const auto g = tapestry::test::random_array<double>({9, 12, 3}, 2, -1, 1);
  const auto y0 = image::fitted(x0, 9, 12, {kind, 0});
  auto adjoint = tapestry::zeros<double, 3>(x0.shape());
  for (int twice = 0; twice < 2; ++twice) image::fitted_adjoint(g, kind, adjoint);  // it adds
  const double product = tapestry::test::dot(g, y0);
  CHECK(std::abs(tapestry::test::dot(adjoint, x0) - 2 * product) <= 1e-13);
  tapestry::test::ActiveTape<double> tape;
  const auto x = tape.input(x0);
  const auto y = image::fitted(x, 9, 12, {kind, 0});
  CHECK((y.value() == y0));
  tape.reverse(y, g);
  CHECK(std::abs(tapestry::test::dot(x.adjoint(), x0) - product) <= 1e-13);
  auto other = tapestry::zeros<double, 3>({5, 4, 2});
  CHECK_THROWS_AS(image::fitted_adjoint(g, kind, other), tapestry::ShapeError);
}
