#include <tapestry/geometry/shapes.hpp>

#include <numbers>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Vector3;

TEST_CASE("an icosphere is closed, lies on its sphere and is seen from outside", "[geometry][icosphere]") {
  for (std::size_t n = 0; n <= 3; ++n) {
    const auto mesh = geometry::icosphere(n, 2.5);
    const std::size_t parts = std::size_t{1} << (2 * n);
    CHECK(mesh.faces.size() == 20 * parts);
    CHECK(mesh.positions.size() == 10 * parts + 2);
    for (const Vector3& position : mesh.positions)
      CHECK(geometry::length(position) == Approx(2.5).epsilon(1e-14));
    double volume = 0;  // of the pyramids from the origin, which is positive where a face looks outwards
    for (const auto& face : mesh.faces) {
      const auto corner = [&](std::size_t k) { return mesh.positions[static_cast<std::size_t>(face[k])]; };
      const double part = geometry::dot(geometry::cross(corner(0), corner(1)), corner(2)) / 6;
      CHECK(part > 0);
      volume += part;
    }
    const double ball = 4.0 / 3 * std::numbers::pi * 2.5 * 2.5 * 2.5;
    CHECK(volume < ball);
    CHECK(volume > ball * (1 - 0.56 / static_cast<double>(parts)));  // what is missing falls as the faces do
    const auto topology = geometry::mesh_topology(mesh);
    CHECK(topology.edges.size() == 30 * parts);
    CHECK(topology.hinges.size() == topology.edges.size());
  }
}

TEST_CASE("an icosphere stands around its centre", "[geometry][icosphere]") {
  const Vector3 centre{1, -2, 3};
  for (const Vector3& position : geometry::icosphere(1, 0.5, centre).positions)
    CHECK(geometry::length(geometry::subtract(position, centre)) == Approx(0.5).epsilon(1e-14));
}

TEST_CASE("icosphere refuses what it cannot make", "[geometry][icosphere][bad_input]") {
  CHECK_THROWS_AS(geometry::icosphere(9), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::icosphere(1, 0), tapestry::DomainError);
}
