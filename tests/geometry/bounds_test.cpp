#include <tapestry/geometry/transform.hpp>

#include <limits>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;

TEST_CASE("bounds hold all points that are finite", "[geometry][bounds]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto bounds = geometry::bounds_of({{3, -1, 5}, {-infinity, 9, 0}, {-1, 2, 6}, {0, 0, infinity}});
  CHECK(bounds.low == geometry::Vector3{-1, -1, 5});
  CHECK(bounds.high == geometry::Vector3{3, 2, 6});
  CHECK(bounds.middle() == geometry::Vector3{1, 0.5, 5.5});
  CHECK(bounds.half_length() == 2);
}

TEST_CASE("bounds of one point, or of none, have no length", "[geometry][bounds][hard_case]") {
  CHECK(geometry::bounds_of({{4, 5, 6}}).middle() == geometry::Vector3{4, 5, 6});
  CHECK(geometry::bounds_of({{4, 5, 6}}).half_length() == 0);
  CHECK(geometry::bounds_of({}).half_length() == 0);
  CHECK(geometry::bounds_of({{std::numeric_limits<double>::quiet_NaN(), 0, 0}}).middle() ==
        geometry::Vector3{0, 0, 0});
}
