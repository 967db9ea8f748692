#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace tapestry::geometry {

/// A named surface colour.
struct Material {
  std::string name;
  std::array<float, 3> colour{0.8F, 0.8F, 0.8F};  ///< diffuse reflectance, RGB in [0, 1]
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
};

}  // namespace tapestry::geometry
