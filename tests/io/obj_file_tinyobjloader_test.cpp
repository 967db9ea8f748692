#include <tapestry/io/obj_file.hpp>

#include <tiny_obj_loader.h>

#include <cstddef>
#include <filesystem>
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
