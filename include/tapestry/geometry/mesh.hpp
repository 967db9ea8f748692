#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/transform.hpp>
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

/// Neighbourhoods in a mesh, by indices into its positions. Positions that coincide count as different.
struct MeshTopology {
  /// Two faces with a common edge (a, b); c and d are their third corners.
  struct Hinge {
    std::size_t a, b, c, d;
  };
  std::size_t vertex_count = 0;
  std::vector<std::array<std::size_t, 2>> edges;  ///< each once, the lower index first, ascending
  std::vector<Hinge> hinges;                      ///< at the edges of exactly two faces, ascending
};

/// \throws Error (mismatch) if a face refers to a missing position
[[nodiscard]] MeshTopology mesh_topology(const Mesh& mesh);

/// 1 for every face whose material is one of `names`, else 0; one entry a face.
///
/// \throws DomainError if names is empty
/// \throws Error (mismatch) if the mesh has no material of that name
[[nodiscard]] std::vector<std::uint8_t> faces_by_material(const Mesh& mesh,
                                                          const std::vector<std::string>& names);

/// 1 for every face of one of the named groups, else 0; errors as faces_by_material().
[[nodiscard]] std::vector<std::uint8_t> faces_by_group(const Mesh& mesh,
                                                       const std::vector<std::string>& names);

/// 1 for every listed face, else 0. Ids count from 1, as in the published face lists; repeats are
/// harmless.
///
/// \throws DomainError if the list is empty
/// \throws Error (mismatch) if an id is not 1 … face count
[[nodiscard]] std::vector<std::uint8_t> faces_by_ids(const Mesh& mesh,
                                                     const std::vector<std::int64_t>& one_based_ids);

/// How a mesh lies in its file: which of its axes, x, y, z, -x, -y or -z, point up and to its front.
struct MeshAxes {
  std::string up = "z";
  std::string forward = "x";
};

/// The unit vector of an axis by its name: x, y, z, -x, -y or -z.
/// \throws DomainError for any other name
[[nodiscard]] Vector3 axis_by_name(const std::string& name);

/// The rotation that takes a mesh with these axes to z up and its front to +x; its rows are forward,
/// up × forward, which is left, and up.
/// \throws DomainError for names of no axis, or unless up and forward are perpendicular
[[nodiscard]] Matrix3 world_from_mesh(const MeshAxes& axes);

/// The mesh turned to z up and its front to +x; the same bits where it lies so already.
/// \throws DomainError as world_from_mesh()
[[nodiscard]] Mesh turned_upright(Mesh mesh, const MeshAxes& axes);

}  // namespace tapestry::geometry
