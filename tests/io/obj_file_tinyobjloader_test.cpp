#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/tinyobj.hpp>

#include <tiny_obj_loader.h>

#include <cstddef>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "../support/catch.hpp"
#include "../support/paths.hpp"

namespace io = tapestry::io;

TEST_CASE("the real car is read as tinyobjloader reads it", "[io][obj]") {
  const std::string path = tapestry::test::in_shared("data/mesh/audi_et_te.obj");
  if (!std::filesystem::exists(path)) {
    WARN("skipped: " << path << " is absent");
    return;
  }
  const auto mesh = io::read_obj(path).mesh;
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;
  std::string warning, error;
  REQUIRE(tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, path.c_str()));
  REQUIRE(mesh.faces.size() == 23145);
  CHECK(mesh.positions.size() * 3 == attributes.vertices.size());
  CHECK(mesh.uvs.size() * 2 == attributes.texcoords.size());
  CHECK(mesh.materials.size() == 6);
  std::size_t differences = 0;
  std::size_t face = 0;
  for (const auto& shape : shapes) {
    for (std::size_t corner = 0; corner < shape.mesh.indices.size(); ++corner) {
      const auto& index = shape.mesh.indices[corner];
      const std::size_t at = face + corner / 3;
      differences += mesh.faces[at][corner % 3] != index.vertex_index ? 1 : 0;
      differences += mesh.face_uvs[at][corner % 3] != index.texcoord_index ? 1 : 0;
      differences += mesh.face_normals[at][corner % 3] != index.normal_index ? 1 : 0;
    }
    face += shape.mesh.indices.size() / 3;
  }
  for (std::size_t i = 0; i < attributes.vertices.size(); ++i)
    differences += static_cast<float>(mesh.positions[i / 3][i % 3]) != attributes.vertices[i] ? 1 : 0;
  CHECK(face == mesh.faces.size());
  CHECK(differences == 0);
}

namespace {

/// Reads an OBJ with tinyobjloader.
struct TinyObj {
  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> materials;

  explicit TinyObj(const std::string& text, bool triangulate = true) {
    std::istringstream obj(text), mtl("newmtl body\nKd 0.25 0.5 0.75\nmap_Kd paint.png\n");
    tinyobj::MaterialStreamReader reader(mtl);
    std::string warning, error;
    REQUIRE(tinyobj::LoadObj(&attributes, &shapes, &materials, &warning, &error, &obj, &reader, triangulate));
  }
  [[nodiscard]] tapestry::geometry::Mesh mesh() const {
    return io::mesh_of(attributes, shapes, materials, "cars/");
  }
};

const std::string two_shapes =
    "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0.25\nvt 1 1\nvn 0 0 2\n"
    "o hood\nusemtl body\nf 1/1/1 2/2/1 3/3/1\no roof\nf 1/1 3 4\n";

}  // namespace

TEST_CASE("what tinyobjloader has read becomes the mesh that our reader makes", "[io][obj]") {
  const auto mesh = TinyObj(two_shapes).mesh();
  auto ours = io::parse_obj(two_shapes, "a.obj").mesh;
  CHECK(mesh.positions == ours.positions);
  CHECK(mesh.uvs == ours.uvs);
  CHECK(mesh.normals == ours.normals);
  CHECK(mesh.faces == ours.faces);
  CHECK(mesh.face_uvs == ours.face_uvs);
  CHECK(mesh.face_normals == ours.face_normals);
  CHECK(mesh.groups == ours.groups);
  CHECK(mesh.face_groups == ours.face_groups);
  CHECK(mesh.vertex_colours.empty());
  REQUIRE(mesh.materials.size() == 1);
  CHECK(mesh.materials[0].name == "body");
  CHECK(mesh.materials[0].colour == std::array{0.25F, 0.5F, 0.75F});
  CHECK(mesh.materials[0].texture == "cars/paint.png");
  CHECK(mesh.face_materials == std::vector<std::int32_t>{0, 0});
  CHECK(TinyObj("v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 1 1 1\nf 1 2 3\n").mesh().vertex_colours[1] ==
        std::array{0.0F, 1.0F, 0.0F});
}

TEST_CASE("mesh_of refuses polygons, indices outside their lists and no faces", "[io][obj]") {
  const TinyObj square("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\no lid\nf 1 2 3 4\n", false);
  CHECK_THROWS_WITH(square.mesh(), contains("face 0 of shape 'lid' has 4 corners, expected 3"));
  TinyObj broken(two_shapes);
  broken.shapes[1].mesh.indices[2].vertex_index = 4;
  CHECK_THROWS_WITH(broken.mesh(), contains("face 0 of shape 'roof' refers to position 4 of 4"));
  broken.shapes[1].mesh.indices[2].vertex_index = -1;
  CHECK_THROWS_WITH(broken.mesh(), contains("refers to position -1 of 4"));
  broken.shapes[1].mesh.indices[2] = {3, -1, 7};
  CHECK_THROWS_WITH(broken.mesh(), contains("refers to texture coordinate 7 of 3"));
  CHECK_THROWS_WITH(TinyObj("v 0 0 0\n").mesh(), contains("mesh_of: no faces"));
}
