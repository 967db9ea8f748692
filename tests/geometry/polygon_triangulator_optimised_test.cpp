#include <tapestry/geometry/polygon_triangulator.hpp>

#include <numbers>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::PolygonShape, geometry::Vector3;

namespace {
constexpr std::size_t count = 100'000;

double area_of(const std::vector<Vector3>& corners, const geometry::PolygonTriangulator& triangulator) {
  double area = 0;
  for (const auto& [a, b, c] : triangulator.triangles())
    area += geometry::cross(geometry::subtract(corners[b], corners[a]),
                            geometry::subtract(corners[c], corners[a]))[2] /
            2;
  return area;
}

Vector3 polar(double radius, double turns) {
  return {radius * std::cos(2 * std::numbers::pi * turns), radius * std::sin(2 * std::numbers::pi * turns),
          0};
}
}  // namespace

TEST_CASE("a star of 100,000 corners is triangulated within the work allowed", "[geometry][triangulate]") {
  std::vector<Vector3> corners;
  for (std::size_t i = 0; i < count; ++i)
    corners.push_back(polar(i % 2 == 0 ? 1 : 0.1, static_cast<double>(i) / count));
  geometry::PolygonTriangulator triangulator;
  REQUIRE(triangulator.triangulate(corners) == PolygonShape::concave);
  CHECK(triangulator.triangles().size() == count - 2);
  CHECK(area_of(corners, triangulator) == Approx(count / 2 * 0.1 * std::sin(2 * std::numbers::pi / count)));
}

TEST_CASE("a spiral of 100,000 corners is triangulated within the work allowed", "[geometry][triangulate]") {
  std::vector<Vector3> corners;
  const auto turns = [](std::size_t i) { return static_cast<double>(i) / 1000; };
  for (std::size_t i = 0; i < count / 2; ++i) corners.push_back(polar(1.4 + turns(i), turns(i)));
  for (std::size_t i = count / 2; i-- > 0;) corners.push_back(polar(1 + turns(i), turns(i)));
  geometry::PolygonTriangulator triangulator;
  REQUIRE(triangulator.triangulate(corners) == PolygonShape::concave);
  double area = 0;  // of its quadrilaterals, each between two rays
  for (std::size_t i = 0; i + 1 < count / 2; ++i)
    area += ((1.4 + turns(i)) * (1.4 + turns(i + 1)) - (1 + turns(i)) * (1 + turns(i + 1))) *
            std::sin(2 * std::numbers::pi / 1000) / 2;
  CHECK(area_of(corners, triangulator) == Approx(area).epsilon(1e-9));
}
