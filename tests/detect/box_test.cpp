#include <tapestry/detect/box_decode.hpp>

#include "../support/catch.hpp"

using namespace tapestry::detect;
using tapestry::Array;

namespace {
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

Head small_head() { return {2, 2, 3, {{{10.0, 20.0}}}, 1.2}; }

/// Logits [1, 7, 2, 3] of no object anywhere.
Array<double, 4> empty_logits() { return tapestry::filled<double, 4>({1, 7, 2, 3}, -20.0); }
}  // namespace

TEST_CASE("iou equals the overlap worked out by hand", "[detect][box_overlap]") {
  CHECK(iou({1, 1, 2, 2}, {2, 2, 2, 2}) == Approx(1.0 / 7));
  CHECK(iou({1, 1, 2, 2}, {1, 1, 2, 2}) == 1);
  CHECK(iou({1, 1, 2, 2}, {3, 1, 2, 2}) == 0);  // touching
  CHECK(clipped({0, 0, 4, 4}, box_from_corners(0, 0, 10, 10)).area() == 4);
  CHECK(clipped({-9, 0, 4, 4}, box_from_corners(0, 0, 10, 10)).area() == 0);
}

TEST_CASE("T09: boxes without area or with NaN overlap nothing", "[detect][box_overlap]") {
  CHECK(iou({1, 1, 0, 2}, {1, 1, 0, 2}) == 0);
  CHECK(iou({1, 1, -2, -2}, {1, 1, 2, 2}) == 0);
  CHECK(iou({not_a_number, 1, 2, 2}, {1, 1, 2, 2}) == 0);
  CHECK(iou({1, 1, 2, 2}, {not_a_number, 1, 2, 2}) == 0);
  CHECK(iou({1, 1, not_a_number, 2}, {1, 1, 2, 2}) == 0);
}

TEST_CASE("decode names what does not fit", "[detect][box_decode]") {
  CHECK_THROWS_AS(decode<double>({small_head()}, {}, 0, 0.25, 64, 96), tapestry::ShapeError);
  CHECK_THROWS_AS(decode<double>({small_head()}, {empty_logits()}, 1, 0.25, 64, 96), tapestry::DomainError);
  CHECK_THROWS_WITH(decode<float>({small_head()}, {tapestry::zeros<float, 4>({1, 7, 2, 2})}, 0, 0.25, 64, 96),
                    "decode: logits is [1, 7, 2, 2], expected [1, 7, 2, 3]");
}
