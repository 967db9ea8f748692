#include "../../examples/scenes/vehicle.hpp"

#include <cmath>
#include <tapestry/geometry/camera.hpp>

#include "../support/catch.hpp"

namespace scenes = tapestry::scenes;
namespace geometry = tapestry::geometry;

namespace {
/// Triangles in a box of 400 × 160 × 150 units somewhere in space.
geometry::Mesh mesh_in_centimetres() {
  geometry::Mesh mesh;
  mesh.positions = {{30, -7, 40}, {430, -7, 40}, {430, 153, 190}, {30, 153, 40}, {5000, 5000, 5000}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}};
  mesh.materials = {{"glass", {0.8F, 0.8F, 0.8F}}, {"tyre", {0.2F, 0.1F, 0.3F}}};
  mesh.face_materials = {0, 1};
  return mesh;
}
}  // namespace

TEST_CASE("a vehicle stands on the ground in metres, whatever its units were", "[scenes][vehicle]") {
  const auto vehicle = scenes::stand_on_ground(mesh_in_centimetres(), {1, 0}, 4);
  CHECK(vehicle.metres_per_unit == Approx(0.01));
  const auto& positions = vehicle.mesh.positions;
  CHECK(positions[0][0] == Approx(-2));
  CHECK(positions[1][0] == Approx(2));
  CHECK(positions[0][1] == Approx(-0.8));
  CHECK(std::abs(positions[0][2]) <= 1e-12);
  CHECK(positions[2][2] == Approx(1.5));
  CHECK(vehicle.colours[0] != mesh_in_centimetres().materials[0].colour);  // the colour of no material file
  CHECK(vehicle.colours[1] == mesh_in_centimetres().materials[1].colour);
}

TEST_CASE("a vehicle's camera sees the mesh as the scene's camera sees the vehicle", "[scenes][vehicle]") {
  const auto mesh = mesh_in_centimetres();
  const auto vehicle = scenes::stand_on_ground(mesh, {1, 0}, 4);
  const auto scene = geometry::orbit_camera(0.7, 0.3, 9, {0.2, -0.1, 0.7}, 1);
  const auto own = scenes::camera_of_mesh(vehicle, scene);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto expected = geometry::picture_from_view(
        scene, geometry::view_from_world(scene, vehicle.mesh.positions[i]), 100, 100);
    const auto found =
        geometry::picture_from_view(own, geometry::view_from_world(own, mesh.positions[i]), 100, 100);
    CHECK(found[0] == Approx(expected[0]).epsilon(1e-12));
    CHECK(found[1] == Approx(expected[1]).epsilon(1e-12));
  }
  CHECK(own.near == Approx(100 * scene.near));
}

TEST_CASE("vehicles of no vehicle's length are refused", "[scenes][vehicle]") {
  CHECK_THROWS_WITH(scenes::stand_on_ground(mesh_in_centimetres(), {1, 0}, 0),
                    contains("400.000000 m long, expected 1 to 20; --length"));
  CHECK_THROWS_WITH(scenes::stand_on_ground(mesh_in_centimetres(), {1, 0}, 0.5), contains("0.5"));
  CHECK_THROWS_WITH(scenes::stand_on_ground({}, {}, 4), contains("m long, expected 1 to 20"));
}
