#include <tapestry/io/mesh_writers.hpp>

#include <nlohmann/json.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/raster/used_texels.hpp>

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
  mesh.uvs = {{0, 0}, {2, 1}, {0.5, 0.75}};
  mesh.normals = {{0, 0, 2}};
  mesh.faces = {{0, 1, 2}, {1, 2, 3}, {2, 3, 0}, {3, 1, 0}};
  mesh.face_uvs = {{0, 1, 2}, {-1, -1, -1}, {2, 1, 0}, {-1, -1, -1}};
  mesh.face_normals = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {-1, -1, -1}};
  mesh.materials = {{"body \"lacquer\"", {0.1F, 0.25F, 1}}, {"paint", {0, 0, 0}}};
  mesh.face_materials = {0, 0, 0, -1};
  return mesh;
}

std::uint32_t word(const std::string& bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, 4);
  return value;
}

/// A .glb taken apart, its structure checked against the specification (glTF 2.0, chapters 3 and 4).
struct Glb {
  nlohmann::json json;
  std::string buffer;

  explicit Glb(const std::string& file) {
    REQUIRE(file.size() >= 28);
    REQUIRE(file.substr(0, 4) == "glTF");
    REQUIRE(word(file, 4) == 2);
    REQUIRE(word(file, 8) == file.size());
    const std::size_t json_size = word(file, 12);
    REQUIRE(json_size % 4 == 0);
    REQUIRE(file.substr(16, 4) == "JSON");
    json = nlohmann::json::parse(std::string_view(file).substr(20, json_size));
    REQUIRE(word(file, 20 + json_size) == file.size() - 28 - json_size);
    REQUIRE(file.substr(24 + json_size, 4) == std::string("BIN\0", 4));
    buffer = file.substr(28 + json_size);
    REQUIRE(buffer.size() % 4 == 0);
    CHECK(json["asset"]["version"] == "2.0");
    CHECK(json["buffers"][0]["byteLength"] == buffer.size());
    for (const auto& view : json["bufferViews"]) {
      CHECK(view["byteOffset"].get<std::size_t>() % 4 == 0);
      CHECK(view["byteOffset"].get<std::size_t>() + view["byteLength"].get<std::size_t>() <= buffer.size());
    }
    for (const auto& accessor : json["accessors"]) {
      const std::size_t width = accessor["type"] == "SCALAR" ? 1 : accessor["type"] == "VEC2" ? 2 : 3;
      CHECK(4 * width * accessor["count"].get<std::size_t>() ==
            json["bufferViews"][accessor["bufferView"].get<std::size_t>()]["byteLength"].get<std::size_t>());
    }
  }

  template <class T>
  [[nodiscard]] std::vector<T> values(std::size_t accessor) const {
    const auto& view = json["bufferViews"][json["accessors"][accessor]["bufferView"].get<std::size_t>()];
    std::vector<T> result(view["byteLength"].get<std::size_t>() / sizeof(T));
    std::memcpy(result.data(), buffer.data() + view["byteOffset"].get<std::size_t>(),
                view["byteLength"].get<std::size_t>());
    return result;
  }

  /// Every corner of a primitive, in order: values of an attribute.
  [[nodiscard]] std::vector<std::vector<float>> corners(std::size_t primitive,
                                                        const std::string& attribute) const {
    const auto& part = json["meshes"][0]["primitives"][primitive];
    const std::size_t accessor = part["attributes"][attribute].get<std::size_t>();
    const auto all = values<float>(accessor);
    const std::size_t count = json["accessors"][accessor]["count"].get<std::size_t>(),
                      width = all.size() / count;
    std::vector<std::vector<float>> result;
    for (const std::uint32_t index : values<std::uint32_t>(part["indices"].get<std::size_t>())) {
      REQUIRE(index < count);
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(index * width);
      result.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(width));
    }
    return result;
  }
};
}  // namespace

TEST_CASE("a painted mesh as .glb has all that a viewer needs", "[io][glb]") {
  const test::TemporaryFolder folder;
  const auto mesh = small_mesh();
  const auto texture = test::random_array<float>({3, 5, 3}, 1);
  io::write_painted_glb(folder.path("car.glb"), {mesh, {1, 0, 1, 0}, two_wide}, texture);
  const Glb glb(folder.read("car.glb"));
  const auto& primitives = glb.json["meshes"][0]["primitives"];
  REQUIRE(primitives.size() == 3);  // paint, lacquer, none

  const std::vector<std::size_t> painted_faces{0, 2};
  const auto positions = glb.corners(0, "POSITION"), uvs = glb.corners(0, "TEXCOORD_0"),
             normals = glb.corners(0, "NORMAL");
  REQUIRE(positions.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t face = painted_faces[i / 3];
    const auto& position = mesh.positions[static_cast<std::size_t>(mesh.faces[face][i % 3])];
    const auto& uv = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][i % 3])];
    for (std::size_t axis = 0; axis < 3; ++axis)
      CHECK(positions[i][axis] == static_cast<float>(position[axis]));
    CHECK(uvs[i][0] == static_cast<float>(uv[0] / 2));
    CHECK(uvs[i][1] == static_cast<float>(1 - uv[1]));
    CHECK(normals[i] == std::vector<float>{0, 0, 1});
  }
  CHECK(glb.json["accessors"][primitives[0]["attributes"]["POSITION"].get<std::size_t>()]["count"] == 4);
  CHECK_FALSE(primitives[2]["attributes"].contains("NORMAL"));  // a corner has none
  CHECK_FALSE(primitives[1]["attributes"].contains("TEXCOORD_0"));

  const auto material = [&](std::size_t primitive) -> const nlohmann::json& {
    return glb.json["materials"][primitives[primitive]["material"].get<std::size_t>()];
  };
  CHECK(material(0)["name"] == "paint_");
  CHECK(material(0)["pbrMetallicRoughness"].contains("baseColorTexture"));
  CHECK(material(1)["name"] == "body \"lacquer\"");
  const auto& factor = material(1)["pbrMetallicRoughness"]["baseColorFactor"];
  CHECK(factor[0].get<double>() == Approx(0.010023).epsilon(1e-4));  // 0.1 of sRGB
  CHECK(factor[2] == 1);
  CHECK(factor[3] == 1);

  const auto& image = glb.json["images"][0];
  CHECK(image["mimeType"] == "image/png");
  const auto& view = glb.json["bufferViews"][image["bufferView"].get<std::size_t>()];
  const std::string png = folder.write(
      "inside.png",
      glb.buffer.substr(view["byteOffset"].get<std::size_t>(), view["byteLength"].get<std::size_t>()));
  const auto inside = io::read_image(png);
  io::write_image(folder.path("direct.png"), texture);
  const auto direct = io::read_image(folder.path("direct.png"));
  REQUIRE(inside.shape() == direct.shape());
  auto layout = two_wide;
  layout.height = 3;
  layout.width = 5;
  const auto used = raster::used_texels<float>({mesh, {1, 0, 1, 0}, layout});
  std::size_t used_count = 0;  // the others take the colours around them
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 5; ++column) {
      if (used(row, column) == 0) continue;
      ++used_count;
      for (std::size_t c = 0; c < 3; ++c) CHECK(inside(row, column, c) == direct(row, column, c));
    }
  CHECK(used_count > 0);
  CHECK(glb.json["textures"][0]["source"] == 0);
}

TEST_CASE("a .glb has the pictures of its materials, each of them once", "[io][glb]") {
  const test::TemporaryFolder folder;
  io::write_image(folder.path("skin.png"), test::random_array<float>({3, 5, 3}, 2));
  auto mesh = small_mesh();  // the second face has no uv, so that its material's colour shows
  mesh.materials[0].texture = mesh.materials[1].texture = folder.path("skin.png");
  mesh.face_materials = {0, 0, 1, -1};
  mesh.face_uvs[3] = {2, 1, 0};
  const auto surfaces = [&](const Glb& glb) {
    std::vector<int> textures;
    for (const auto& primitive : glb.json["meshes"][0]["primitives"]) {
      const auto& surface =
          glb.json["materials"][primitive["material"].get<std::size_t>()]["pbrMetallicRoughness"];
      const bool has_texture = surface.contains("baseColorTexture");
      CHECK(primitive["attributes"].contains("TEXCOORD_0") == has_texture);
      textures.push_back(has_texture ? surface["baseColorTexture"]["index"].get<int>() : -1);
      if (has_texture) CHECK(surface["baseColorFactor"] == nlohmann::json{1, 1, 1, 1});
    }
    return textures;
  };
  io::write_glb(folder.path("car.glb"), mesh);
  const Glb glb(folder.read("car.glb"));
  CHECK(surfaces(glb) == std::vector<int>{-1, 0, 0, -1});  // body without uv, body, paint, none
  CHECK(glb.json["images"].size() == 1);
  io::write_painted_glb(folder.path("painted.glb"), {mesh, {0, 0, 0, 1}, two_wide},
                        test::random_array<float>({3, 5, 3}, 1));
  const Glb painted(folder.read("painted.glb"));
  CHECK(surfaces(painted) == std::vector<int>{0, -1, 1, 1});
  const auto uvs = painted.corners(2, "TEXCOORD_0");  // not divided by the extent of the paint
  CHECK(uvs[1] == std::vector<float>{2, 0});
}

TEST_CASE("accessors of positions state their bounds exactly", "[io][glb]") {
  const test::TemporaryFolder folder;
  io::write_glb(folder.path("car.glb"), small_mesh());
  const Glb glb(folder.read("car.glb"));
  for (const auto& primitive : glb.json["meshes"][0]["primitives"]) {
    const std::size_t index = primitive["attributes"]["POSITION"].get<std::size_t>();
    const auto values = glb.values<float>(index);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
      for (std::size_t i = axis; i < values.size(); i += 3) {
        low = std::min(low, values[i]);
        high = std::max(high, values[i]);
      }
      CHECK(glb.json["accessors"][index]["min"][axis].get<float>() == low);
      CHECK(glb.json["accessors"][index]["max"][axis].get<float>() == high);
    }
  }
  CHECK_FALSE(glb.json.contains("images"));
}

TEST_CASE("a material name that is not UTF-8 leaves the JSON of a .glb valid", "[io][glb]") {
  const test::TemporaryFolder folder;
  auto mesh = small_mesh();
  mesh.materials[0].name = "Terrain\xe6";
  io::write_glb(folder.path("car.glb"), mesh);
  const Glb glb(folder.read("car.glb"));  // parses it
  CHECK(glb.json["materials"][0]["name"] == "Terrain\xef\xbf\xbd");
}

TEST_CASE("the node of a .glb turns the front to z and up to y", "[io][glb]") {
  const test::TemporaryFolder folder;
  io::write_glb(folder.path("car.glb"), small_mesh());
  const Glb glb(folder.read("car.glb"));
  const auto& q = glb.json["nodes"][0]["rotation"];
  const geometry::Vector3 axis{q[0].get<double>(), q[1].get<double>(), q[2].get<double>()};
  const auto turned = [&](const geometry::Vector3& v) {  // v + 2·q × (q × v + w·v)
    const auto inner = geometry::add(geometry::cross(axis, v), geometry::scale(v, q[3].get<double>()));
    return geometry::add(v, geometry::scale(geometry::cross(axis, inner), 2));
  };
  CHECK(turned({1, 0, 0}) == geometry::Vector3{0, 0, 1});
  CHECK(turned({0, 0, 1}) == geometry::Vector3{0, 1, 0});
  CHECK(turned({0, 1, 0}) == geometry::Vector3{1, 0, 0});
}

TEST_CASE("what cannot be written as .glb is refused, and nothing is left", "[io][glb][bad_input]") {
  const test::TemporaryFolder folder;
  const auto texture = test::random_array<float>({2, 2, 3}, 1);
  const std::string path = folder.path("car.glb");
  auto mesh = small_mesh();
  CHECK_THROWS_AS(io::write_painted_glb(path, {mesh, {1}, two_wide}, texture), ShapeError);
  CHECK_THROWS_AS(io::write_painted_glb(path, {mesh, {1, 0, 1, 0}, no_width}, texture), DomainError);
  CHECK_THROWS_AS(
      io::write_painted_glb(path, {mesh, {1, 0, 1, 0}, two_wide}, tapestry::zeros<float, 3>({2, 2, 4})),
      ShapeError);
  CHECK_THROWS_AS(io::write_glb(path, geometry::Mesh{}), DomainError);
  CHECK_THROWS_AS(io::write_glb(folder.path("absent/car.glb"), mesh), FileError);
  mesh.positions[2][1] = std::nan("");
  CHECK_THROWS_AS(io::write_glb(path, mesh), NumericError);
  CHECK(folder.read("car.glb").empty());
}
