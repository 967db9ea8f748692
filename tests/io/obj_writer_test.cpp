#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>

#include <tapestry/io/obj_file.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;

namespace {
const raster::TextureLayout two_wide{raster::TextureKind::atlas, 2, 4, 2, 0};
const raster::TextureLayout no_width{raster::TextureKind::atlas, 2, 4, 0, 0};
geometry::Mesh small_mesh() {
  geometry::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1.0 / 3, 0, 1e-7}, {0, 1, 0}, {-2, 1e5, 0.1}};
  mesh.uvs = {{0, 0}, {2, 1}, {0.1, 0.7}};
  mesh.normals = {{0, 0, 1}};
  mesh.faces = {{0, 1, 2}, {1, 2, 3}, {2, 3, 0}};
  mesh.face_uvs = {{0, 1, 2}, {-1, -1, -1}, {2, 1, 0}};
  mesh.face_normals = {{0, 0, 0}, {0, 0, 0}, {-1, -1, -1}};
  mesh.materials = {{"body lacquer", {0.1F, 0.25F, 1}}, {"paint", {0, 0, 0}}};
  mesh.face_materials = {0, 1, -1};
  mesh.groups = {"left", "right"};
  mesh.face_groups = {0, 1, 1};
  return mesh;
}
}  // namespace

TEST_CASE("a mesh comes back to the bit", "[io][obj]") {
  const test::TemporaryFolder folder;
  auto mesh = small_mesh();
  for (std::size_t i = 0; i < mesh.positions.size(); ++i)
    mesh.vertex_colours.push_back({0.1F, 0.125F * static_cast<float>(i), 1});
  io::write_obj(folder.path("the car.obj"), mesh);
  const auto loaded = io::read_obj(folder.path("the car.obj"));
  CHECK(loaded.warnings.empty());
  CHECK(loaded.mesh.positions == mesh.positions);
  CHECK(loaded.mesh.vertex_colours == mesh.vertex_colours);
  CHECK(loaded.mesh.uvs == mesh.uvs);
  CHECK(loaded.mesh.normals == mesh.normals);
  CHECK(loaded.mesh.faces == mesh.faces);
  CHECK(loaded.mesh.face_uvs == mesh.face_uvs);
  CHECK(loaded.mesh.face_normals == mesh.face_normals);
  CHECK(loaded.mesh.groups == mesh.groups);
  CHECK(loaded.mesh.face_groups == mesh.face_groups);
  CHECK(loaded.mesh.face_materials == std::vector<std::int32_t>{0, 1, 2});  // without a material: "none"
  CHECK(loaded.mesh.materials[0].name == "body lacquer");
  CHECK(loaded.mesh.materials[0].colour == mesh.materials[0].colour);
}

TEST_CASE("a painted mesh has its texture beside it", "[io][obj]") {
  const test::TemporaryFolder folder;
  const auto mesh = small_mesh();
  const auto texture = test::random_array<float>({2, 4, 3}, 1);
  io::write_painted_obj(folder.path("car.obj"), {mesh, {1, 0, 1}, two_wide}, texture);
  const auto loaded = io::read_obj(folder.path("car.obj"));
  CHECK(loaded.warnings.empty());
  CHECK(loaded.mesh.faces == mesh.faces);
  CHECK(loaded.mesh.uvs == std::vector<std::array<double, 2>>{{0, 0}, {1, 1}, {0.05, 0.7}});
  const auto name = [&](std::size_t face) {
    return loaded.mesh.materials[static_cast<std::size_t>(loaded.mesh.face_materials[face])].name;
  };
  CHECK(name(0) == "paint_");  // "paint" is taken
  CHECK(name(1) == "paint");
  CHECK(name(2) == "paint_");
  for (const auto& material : loaded.mesh.materials)
    CHECK(material.texture == (material.name == "paint_" ? folder.path("car.png") : ""));
  CHECK_THAT(folder.read("car.mtl"), contains("map_Kd car.png"));
  CHECK((io::read_image(folder.path("car.png")).shape() == Extents<3>{2, 4, 3}));
}

TEST_CASE("a mesh is written with the pictures of its materials, each of them once", "[io][obj]") {
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.path("own"));
  const std::string skin = folder.path("own/skin.png");
  io::write_image(skin, test::random_array<float>({3, 5, 3}, 2));
  auto mesh = small_mesh();
  mesh.materials = {{"body", {0.5F, 0.25F, 0.5F}, skin},
                    {"hood", {}, skin},
                    {"gone", {0.5F, 0.25F, 0.5F}, folder.path("own/gone.png")}};
  mesh.face_uvs = {{0, 1, 2}, {2, 0, 1}, {2, 1, 0}};
  mesh.face_materials = {0, 1, 2};
  mesh.groups.clear();
  mesh.face_groups.clear();
  io::write_obj(folder.path("car.obj"), mesh);
  const auto textures = [&] {
    const auto loaded = io::read_obj(folder.path("car.obj"));
    CHECK(loaded.warnings.empty());
    std::vector<std::string> names;
    for (std::size_t i = 0; i < 3; ++i) names.push_back(loaded.mesh.materials[i].texture);
    return names;
  };
  CHECK(textures() == std::vector<std::string>{folder.path("car-1.png"), folder.path("car-1.png"), ""});
  CHECK_THAT(folder.read("car.mtl"), contains("newmtl body\nKd 1 1 1\nmap_Kd car-1.png"));  // as in a .glb
  CHECK_THAT(folder.read("car.mtl"), contains("newmtl gone\nKd 0.5 0.25 0.5\n"));
  CHECK((io::read_image(folder.path("car-1.png")) == io::read_image(skin)));
  CHECK_FALSE(std::filesystem::exists(folder.path("car-2.png")));

  // Beside a paint over u from 0 to 2 pictures keep their uvs, and a painted face's picture is left out.
  const auto texture = test::random_array<float>({2, 4, 3}, 1);
  io::write_painted_obj(folder.path("car.obj"), {mesh, {1, 0, 0}, two_wide}, texture);
  CHECK(textures() == std::vector<std::string>{"", folder.path("car-2.png"), ""});
  const auto loaded = io::read_obj(folder.path("car.obj")).mesh;
  const auto corner = [](const geometry::Mesh& of, std::size_t face, std::size_t k) {
    return of.uvs[static_cast<std::size_t>(of.face_uvs[face][k])];
  };
  for (std::size_t k = 0; k < 3; ++k) {
    CHECK(corner(loaded, 0, k)[0] == corner(mesh, 0, k)[0] / 2);
    CHECK(corner(loaded, 1, k) == corner(mesh, 1, k));
  }
}

TEST_CASE("texels that no painted face refers to are written with the colours around them", "[io][obj]") {
  // A chart of 4 x 4 texels, red, in the middle of an atlas of 16 x 16 that is black elsewhere.
  const test::TemporaryFolder folder;
  geometry::Mesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  mesh.uvs = {{6.5 / 16, 6.5 / 16}, {9.5 / 16, 6.5 / 16}, {9.5 / 16, 9.5 / 16}, {6.5 / 16, 9.5 / 16}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {0, 1, 3}};
  mesh.face_uvs = {{0, 1, 2}, {0, 2, 3}, {-1, -1, -1}};
  auto texture = tapestry::zeros<float, 3>({16, 16, 3});
  for (std::size_t row = 6; row < 10; ++row)
    for (std::size_t column = 6; column < 10; ++column) texture(row, column, 0) = 1;
  auto layout = two_wide;
  layout.u_extent = 1;
  const auto is_red = [&] {
    const auto written = io::read_image(folder.path("car.png"));
    for (std::size_t i = 0; i < written.size(); ++i)
      if (written.data()[i] != (i % 3 == 0 ? 255 : 0)) return false;
    return true;
  };
  io::write_painted_obj(folder.path("car.obj"), {mesh, {1, 1, 1}, layout}, texture);
  CHECK(is_red());
  layout.kind = raster::TextureKind::cube;  // written with charts of the faces
  CHECK_THROWS_WITH(io::write_painted_obj(folder.path("car.obj"), {mesh, {1, 1, 1}, layout}, texture),
                    contains("write_painted_obj: texture is [16, 16, 3], expected [32, 32, 3]"));
}

TEST_CASE("a mesh that cannot be written leaves nothing behind", "[io][obj]") {
  const test::TemporaryFolder folder;
  auto mesh = small_mesh();
  const auto texture = test::random_array<float>({2, 4, 3}, 1);
  CHECK_THROWS_AS(io::write_painted_obj(folder.path("car.obj"), {mesh, {1}, two_wide}, texture), ShapeError);
  CHECK_THROWS_AS(io::write_painted_obj(folder.path("car.obj"), {mesh, {1, 0, 1}, no_width}, texture),
                  DomainError);
  mesh.positions[1][1] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(io::write_obj(folder.path("car.obj"), mesh), NumericError);
  for (const std::string name : {"a\nv 9 9 9", "\x1b[31m"}) {  // would be separate records
    CHECK_THROWS_WITH(io::write_obj(folder.path(name + ".obj"), small_mesh()), contains("control character"));
    auto named = small_mesh();
    named.materials[0].name = name;
    CHECK_THROWS_WITH(io::write_obj(folder.path("car.obj"), named), contains("control character"));
    named = small_mesh();
    named.groups[0] = name;
    CHECK_THROWS_WITH(io::write_painted_obj(folder.path("car.obj"), {named, {1, 0, 1}, two_wide}, texture),
                      contains("control character"));
  }
  CHECK(std::filesystem::is_empty(folder.path()));
  CHECK_THROWS_AS(io::write_obj(folder.path("absent/car.obj"), small_mesh()), FileError);
}
