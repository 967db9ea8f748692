#include <tapestry/geometry/shapes.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;

TEST_CASE("a plane covers its square once, seen from above, with uv from corner to corner",
          "[geometry][plane]") {
  const auto mesh = geometry::plane(2, 3, 0.5);
  CHECK(mesh.positions.size() == 12);
  CHECK(mesh.faces.size() == 12);
  CHECK(mesh.positions.front() == geometry::Vector3{-0.5, -0.5, 0});
  CHECK(mesh.positions.back() == geometry::Vector3{0.5, 0.5, 0});
  CHECK(mesh.uvs.front() == std::array<double, 2>{0, 0});
  CHECK(mesh.uvs.back() == std::array<double, 2>{1, 1});
  CHECK(mesh.face_uvs == mesh.faces);
  for (const auto& face : mesh.faces) {
    const auto corner = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(face[k])]; };
    const auto normal =
        geometry::cross(geometry::subtract(corner(1), corner(0)), geometry::subtract(corner(2), corner(0)));
    CHECK(normal[2] == Approx(1.0 / 6));  // twice the area of half a cell, upwards
  }
}

TEST_CASE("plane refuses what it cannot make", "[geometry][plane][bad_input]") {
  CHECK_THROWS_AS(geometry::plane(0, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::plane(1, 5000), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::plane(1, 1, -1), tapestry::DomainError);
}
