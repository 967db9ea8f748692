#include "../../examples/scenes/vehicle.hpp"

#include "../../examples/scenes/dark_parts.hpp"
#include "../../examples/scenes/photograph.hpp"
#include "../../examples/scenes/picture.hpp"
#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

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
  const auto unpainted = scenes::stand_on_ground(mesh_in_centimetres(), {0, 0}, 4).mesh;
  const auto materials = mesh_in_centimetres().materials;
  CHECK(geometry::material_colour(unpainted, 0) != materials[0].colour);  // the colour of no material file
  CHECK(geometry::material_colour(unpainted, 1) == materials[1].colour);
}

TEST_CASE("parts without paint are dark where no file states their colour", "[scenes][vehicle]") {
  constexpr std::array unstated{0.8F, 0.8F, 0.8F}, red{0.7F, 0.1F, 0.1F};
  geometry::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {4, 1, 0}};
  mesh.faces.assign(8, {0, 1, 2});
  mesh.materials = {{"body", unstated},
                    {"glass", unstated},
                    {"lamp", red},
                    {"plate", unstated, "plate.png"},
                    {"dark", red}};
  mesh.face_materials = {0, 0, 1, 2, 3, 0, -1};  // and none for the last
  const auto dark = scenes::with_dark_parts(mesh, {1, 0, 0, 0, 0, 1, 0, 0});
  const auto is_dark = [&](std::size_t face) {
    const auto colour = geometry::material_colour(dark, face);
    return std::ranges::max(colour) < 0.15F && std::ranges::min(colour) > 0.05F;
  };
  for (const std::size_t face : {1U, 2U, 6U, 7U}) CHECK(is_dark(face));
  for (const std::size_t face : {0U, 3U, 4U, 5U})
    CHECK(geometry::material_colour(dark, face) == geometry::material_colour(mesh, face));
  CHECK(dark.materials[1].name == "glass");
  CHECK(dark.materials[static_cast<std::size_t>(dark.face_materials[1])].name == "dark_");
  CHECK(dark.materials[4].colour == red);
  const auto twice = scenes::with_dark_parts(dark, {1, 0, 0, 0, 0, 1, 0, 0});
  CHECK(twice.face_materials == dark.face_materials);
  CHECK(twice.materials.size() == dark.materials.size());
  CHECK(scenes::with_dark_parts({}, {}).materials.empty());
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
  CHECK_THROWS_WITH(scenes::stand_on_ground(mesh_in_centimetres(), {1, 0}, 0.1, 0.2),
                    contains("0.100000 m long, expected 0.200000 to 20"));
  CHECK(scenes::stand_on_ground(mesh_in_centimetres(), {1, 0}, 0.5, 0.2).mesh.positions[1][0] ==
        Approx(0.25));
}

TEST_CASE("a vehicle's own texture covers its faces, and the others keep their colours",
          "[scenes][vehicle]") {
  auto mesh = mesh_in_centimetres();
  mesh.positions = {{0, 0, 0}, {400, 0, 0}, {400, 0, 150}, {0, 0, 150}};  // a wall, seen from its right side
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}};
  mesh.face_uvs = {{0, 1, 2}, {-1, -1, -1}};
  mesh.face_normals = mesh.face_uvs;
  auto vehicle = scenes::stand_on_ground(mesh, {1, 0}, 4);
  Array<std::uint8_t, 3> red(Extents<3>{2, 2, 3}, std::uint8_t(0));
  for (std::size_t i = 0; i < 4; ++i) red.data()[3 * i] = 255;
  scenes::add_texture(vehicle, red, {1, 0});
  scenes::PhotographOptions options;
  options.yaw_rad = {0, 0};
  Random random(3);
  auto scene = scenes::make_scene_in_photograph(random, Array<float, 3>(Extents<3>{64, 64, 3}, 0.5F), vehicle,
                                                options);
  scene.camera = geometry::orbit_camera(-1.5707963267948966, 0.1, 8, {0, 0, 0.7}, 0.8);
  const auto picture = scenes::draw_scene(scene, 64, 64);
  std::size_t reds = 0, others = 0;
  for (std::size_t y = 0; y < 64; ++y)
    for (std::size_t x = 0; x < 64; ++x) {
      if (picture.car_mask(y, x) < 1) continue;
      const float r = picture.image(y, x, 0), g = picture.image(y, x, 1), b = picture.image(y, x, 2);
      if (g == 0 && b == 0 && r > 0) ++reds;
      if (std::abs(g / r - 0.5F) < 0.2F && b > r) ++others;  // (0.2, 0.1, 0.3) in some light
    }
  CHECK(reds > 100);
  CHECK(others > 100);
}

TEST_CASE("a run draws a car of several textures as the data set does", "[scenes][vehicle]") {
  // Two sides are painted, three have two textures, partly with u beyond 1, and the floor has its colour.
  auto body = test::tiny_car(12, raster::TextureKind::solid);
  body.painted = {1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0};
  auto vehicle = scenes::stand_on_ground(body.mesh, body.painted, 2);  // of 4 units
  auto pictures = std::make_shared<tapestry::raster::MeshPictures>();
  const std::vector<std::uint8_t> faces[]{{0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 0, 0},
                                          {0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0}};
  Random random(3);
  for (const auto& shown : faces) {
    Array<std::uint8_t, 3> texture(Extents<3>{24, 40, 3});
    for (auto& value : texture.storage()) value = static_cast<std::uint8_t>(random.index(256));
    scenes::add_texture(vehicle, texture, shown);
    raster::add_picture(*pictures, body.mesh, texture, shown, raster::TextureFilter::anisotropic, body.space);
  }
  body.pictures = pictures;
  auto scene =
      scenes::make_scene_in_photograph(random, Array<float, 3>(Extents<3>{96, 96, 3}, 0.5F), vehicle, {});
  const auto& colour = scene.face_colours[scene.objects[scene.car_object].face_begin];
  Array<float, 2> paint(Extents<2>{1, 3});
  std::copy(colour.begin(), colour.end(), paint.data());
  for (const double azimuth : {0.6, 2.2, 3.9, 5.4}) {
    scene.camera = geometry::orbit_camera(azimuth, 0.4, 3, {0, 0, 0.35}, 0.9);
    const auto photo = scenes::draw_scene(scene, 96, 96);
    const auto run =
        raster::render(raster::texture_operator<float>(body, scenes::camera_of_mesh(vehicle, scene.camera),
                                                       96, 96, scene.light, 2),
                       paint);
    std::size_t pixels = 0;
    for (std::size_t y = 0; y < 96; ++y)
      for (std::size_t x = 0; x < 96; ++x) {
        if (photo.car_mask(y, x) < 1) continue;
        ++pixels;
        for (std::size_t c = 0; c < 3; ++c)  // within a hundredth of a level: the units differ
          CHECK(std::abs(photo.image(y, x, c) - std::min(run(y, x, c), 1.0F)) < 4e-5F);
      }
    CHECK(pixels > 500);
  }
}
