#include <tapestry/geometry/pose.hpp>

#include <tapestry/geometry/shapes.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"

namespace geometry = tapestry::geometry;
using geometry::Pose, geometry::Vector3;

TEST_CASE("a mesh placed at no pose keeps its bits", "[geometry][placed]") {
  const auto mesh = geometry::icosphere(1);
  CHECK(geometry::placed(mesh, {}).positions == mesh.positions);
}

TEST_CASE("a placed mesh is turned first, then moved, and so are its normals", "[geometry][placed]") {
  geometry::Mesh mesh;
  mesh.positions = {{1, 0, 0}};
  mesh.normals = {{0, 1, 0}};
  const double quarter = std::acos(0.0);  // about z: x goes to y, y to −x
  const auto placed = geometry::placed(mesh, {{0, 0, quarter}, {5, 6, 7}});
  CHECK(geometry::length(geometry::subtract(placed.positions[0], {5, 7, 7})) <= 1e-15);
  CHECK(geometry::length(geometry::subtract(placed.normals[0], {-1, 0, 0})) <= 1e-15);
}

TEST_CASE("placed_adjoint agrees with central differences", "[geometry][placed][gradient]") {
  const auto mesh = geometry::icosphere(1, 0.7);
  const Pose pose{{0.3, -0.8, 1.1}, {2, -1, 0.5}};
  const auto loss = [&](const Pose& at) {  // Σ i·x² + y·z
    double sum = 0, weight = 0;
    for (const auto& [x, y, z] : geometry::placed(mesh, at).positions) sum += ++weight * x * x + y * z;
    return sum;
  };
  std::vector<Vector3> adjoint;
  double weight = 0;
  for (const auto& [x, y, z] : geometry::placed(mesh, pose).positions)
    adjoint.push_back({2 * ++weight * x, z, y});
  Pose gradient;
  for (int half = 0; half < 2; ++half) {  // adds
    auto part = adjoint;
    for (auto& entry : part) entry = geometry::scale(entry, 0.5);
    geometry::placed_adjoint(pose, mesh.positions, part, gradient);
  }
  const double step = tapestry::test::central_difference_step<double>();
  Pose at = pose;
  for (std::size_t k = 0; k < 6; ++k) {
    const double expected = tapestry::test::slope_by(k < 3 ? at.rotation[k] : at.translation[k - 3], step,
                                                     [&] { return loss(at); });
    const double found = k < 3 ? gradient.rotation[k] : gradient.translation[k - 3];
    CHECK(std::abs(found - expected) <= 1e-7 * (1 + std::abs(expected)));
  }
}

TEST_CASE("an appended mesh keeps its attributes, and what one of the two lacks is filled",
          "[geometry][placed]") {
  geometry::Mesh bare;
  bare.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  bare.faces = {{0, 1, 2}};
  geometry::Mesh full = bare;
  full.uvs = {{0.5, 0.25}};
  full.normals = {{0, 0, 1}};
  full.face_uvs = {{0, -1, 0}};
  full.face_normals = {{0, 0, -1}};
  full.materials = {{"red", {1, 0, 0}}};
  full.face_materials = {0};
  full.groups = {"hood"};
  full.face_groups = {0};
  full.vertex_colours = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const geometry::Corners none{-1, -1, -1};

  auto mesh = bare;
  geometry::append(mesh, full);
  geometry::append(mesh, full);
  geometry::append(mesh, bare);
  CHECK(mesh.faces == std::vector<geometry::Corners>{{0, 1, 2}, {3, 4, 5}, {6, 7, 8}, {9, 10, 11}});
  CHECK(mesh.face_uvs == std::vector<geometry::Corners>{none, {0, -1, 0}, {1, -1, 1}, none});
  CHECK(mesh.face_normals[2] == geometry::Corners{1, 1, -1});
  CHECK(geometry::material_colour(mesh, 0) == geometry::Material{}.colour);
  CHECK(geometry::material_colour(mesh, 2) == std::array<float, 3>{1, 0, 0});
  CHECK(geometry::material_colour(mesh, 3) == geometry::Material{}.colour);
  CHECK(geometry::material_colour(mesh, 4) == geometry::Material{}.colour);
  CHECK(mesh.face_groups == std::vector<std::int32_t>{-1, 0, 1, -1});
  CHECK(mesh.face_normals.size() == 4);
  REQUIRE(mesh.vertex_colours.size() == 12);
  CHECK(mesh.vertex_colours[3] == std::array<float, 3>{1, 0, 0});
  CHECK(mesh.vertex_colours[11] == geometry::Material{}.colour);
}
