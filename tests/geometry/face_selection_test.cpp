#include <tapestry/geometry/mesh.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using Selection = std::vector<std::uint8_t>;

namespace {
geometry::Mesh mesh_of_four() {
  geometry::Mesh mesh;
  mesh.faces.assign(4, {0, 0, 0});
  mesh.materials = {{"Body", {}}, {"Glass", {}}, {"Body", {}}};
  mesh.face_materials = {0, 1, 2, -1};
  mesh.groups = {"door", "roof"};
  mesh.face_groups = {1, 0, 0, -1};
  return mesh;
}
}  // namespace

TEST_CASE("faces are selected by material, group and list", "[geometry][face_selection]") {
  const auto mesh = mesh_of_four();
  CHECK(geometry::faces_by_material(mesh, {"Body"}) == Selection{1, 0, 1, 0});
  CHECK(geometry::faces_by_material(mesh, {"Glass", "Body"}) == Selection{1, 1, 1, 0});
  CHECK(geometry::faces_by_group(mesh, {"door"}) == Selection{0, 1, 1, 0});
  CHECK(geometry::faces_by_ids(mesh, {4, 1, 4}) == Selection{1, 0, 0, 1});
}

TEST_CASE("selections that do not fit the mesh name what is wrong", "[geometry][face_selection]") {
  const auto mesh = mesh_of_four();
  CHECK_THROWS_WITH(geometry::faces_by_material(mesh, {"Bodi"}),
                    "faces_by_material: the mesh has no material 'Bodi'; it has 'Body', 'Glass', 'Body'");
  CHECK_THROWS_AS(geometry::faces_by_material(mesh, {}), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::faces_by_group(mesh, {"Glass"}), tapestry::Error);
  CHECK_THROWS_WITH(geometry::faces_by_ids(mesh, {1, 5}), "faces_by_ids: entry 2 is face 5, expected 1 to 4");
  CHECK_THROWS_AS(geometry::faces_by_ids(mesh, {0}), tapestry::Error);
  CHECK_THROWS_AS(geometry::faces_by_ids(mesh, {-3}), tapestry::Error);
  CHECK_THROWS_AS(geometry::faces_by_ids(mesh, {}), tapestry::DomainError);
}
