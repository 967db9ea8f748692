#include <tapestry/geometry/transform.hpp>

#include <limits>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Vector3;

TEST_CASE("vector and matrix products equal what is worked out by hand", "[geometry][transform]") {
  CHECK(geometry::cross({1, 0, 0}, {0, 1, 0}) == Vector3{0, 0, 1});
  CHECK(geometry::dot({1, 2, 3}, {4, 5, 6}) == 32);
  CHECK(geometry::length({2, 3, 6}) == 7);
  CHECK(geometry::normalised({0, 0, 0}) == Vector3{0, 0, 0});
  const geometry::Matrix3 matrix{{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}}};
  CHECK(geometry::multiply(matrix, {1, 0, 2}) == Vector3{7, 16, 25});
  CHECK(geometry::multiply_transposed(matrix, {1, 0, 2}) == Vector3{15, 18, 21});
}

TEST_CASE("rotations and reflections are orthonormal; scaled, skewed and NaN matrices are not",
          "[geometry][transform]") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(geometry::is_orthonormal({{{0.6, 0.8, 0}, {-0.8, 0.6, 0}, {0, 0, 1}}}));
  CHECK(geometry::is_orthonormal({{{0, 1, 0}, {1, 0, 0}, {0, 0, 1}}}));
  CHECK_FALSE(geometry::is_orthonormal({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1.01}}}));
  CHECK(geometry::is_orthonormal({{{1, 0, 0}, {0, 1, 0}, {0, 0, 1.01}}}, 0.03));
  CHECK_FALSE(geometry::is_orthonormal({{{1, 0, 0}, {0.1, 1, 0}, {0, 0, 1}}}));
  CHECK_FALSE(geometry::is_orthonormal({{{nan, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, 1e300));
  CHECK_FALSE(geometry::is_orthonormal({}));
}
