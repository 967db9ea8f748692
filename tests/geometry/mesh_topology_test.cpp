#include <tapestry/geometry/mesh.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using Edges = std::vector<std::array<std::size_t, 2>>;

TEST_CASE("the edges and hinges of a fan are listed once, in order", "[geometry][mesh_topology]") {
  geometry::Mesh mesh;
  mesh.positions.resize(6);  // the last belongs to no face
  mesh.faces = {{0, 1, 2}, {3, 2, 1}, {1, 3, 4}};
  const auto topology = geometry::mesh_topology(mesh);
  CHECK(topology.vertex_count == 6);
  CHECK(topology.edges == Edges{{0, 1}, {0, 2}, {1, 2}, {1, 3}, {1, 4}, {2, 3}, {3, 4}});
  REQUIRE(topology.hinges.size() == 2);
  CHECK((topology.hinges[0].a == 1 && topology.hinges[0].b == 2));
  CHECK((topology.hinges[0].c == 0 && topology.hinges[0].d == 3));
  CHECK((topology.hinges[1].c == 2 && topology.hinges[1].d == 4));
}

TEST_CASE("an edge of three faces is no hinge, and one from a position to itself no edge",
          "[geometry][mesh_topology]") {
  geometry::Mesh mesh;
  mesh.positions.resize(5);
  mesh.faces = {{0, 1, 2}, {0, 1, 3}, {1, 0, 4}, {3, 3, 4}};
  const auto topology = geometry::mesh_topology(mesh);
  CHECK(topology.edges.size() == 8);
  for (const auto& hinge : topology.hinges) CHECK(!(hinge.a == 0 && hinge.b == 1));
  mesh.faces.push_back({0, 1, 5});
  CHECK_THROWS_WITH(geometry::mesh_topology(mesh), "mesh_topology: face 4 refers to position 5 of 5");
  mesh.faces.back() = {0, -1, 2};
  CHECK_THROWS_AS(geometry::mesh_topology(mesh), tapestry::Error);
}
