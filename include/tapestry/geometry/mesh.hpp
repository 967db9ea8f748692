#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tapestry::geometry {

/// A named surface: its colour, or the picture that its faces' uvs point into.
struct Material {
  std::string name;
  std::array<float, 3> colour{0.8F, 0.8F, 0.8F};  ///< diffuse reflectance, RGB in [0, 1]
  std::string texture{};                          ///< file with a picture of it; empty for none
};

/// One triangle: three indices into a mesh's attribute lists, counter-clockwise seen from outside.
using Corners = std::array<std::int32_t, 3>;

/// An indexed triangle mesh. Face order is kept from the file, since face lists refer to it.
struct Mesh {
  std::vector<std::array<double, 3>> positions;  ///< metres (or file units), right-handed, z up
  std::vector<std::array<double, 2>> uvs;        ///< u to the right, v up
  std::vector<std::array<double, 3>> normals;    ///< unit length
  std::vector<Corners> faces;                    ///< indices into positions
  std::vector<Corners> face_uvs;      ///< indices into uvs, −1 where a corner has none; one entry a face
  std::vector<Corners> face_normals;  ///< indices into normals, −1 where none; one entry a face
  std::vector<std::int32_t> face_materials;  ///< index into materials, −1 for none; one entry a face
  std::vector<Material> materials;
  std::vector<std::int32_t> face_groups;  ///< index into groups, −1 for none; one entry a face
  std::vector<std::string> groups;
  std::vector<std::array<float, 3>> vertex_colours;  ///< RGB in [0, 1], one a position, or none at all
};

/// Colour of a face's material, RGB in [0, 1]; light grey where it has none.
[[nodiscard]] inline std::array<float, 3> material_colour(const Mesh& mesh, std::size_t face) {
  const std::int32_t material = face < mesh.face_materials.size() ? mesh.face_materials[face] : -1;
  const bool known = material >= 0 && static_cast<std::size_t>(material) < mesh.materials.size();
  return known ? mesh.materials[static_cast<std::size_t>(material)].colour : Material{}.colour;
}

}  // namespace tapestry::geometry
