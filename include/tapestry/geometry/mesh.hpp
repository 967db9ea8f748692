#pragma once
#include <optional>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/transform.hpp>

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
  std::vector<Hinge> hinges;                      ///< hinges at edges with exactly two faces, ascending
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

/// 1 for every listed face, else 0. Ids count from 1, as in the published face lists; repeats are harmless.
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

/// Appends the faces of another mesh, with its attributes, materials and groups, which keep their names.
/// Lists that only one of the two has are filled for the other: with −1, or light grey vertex colours.
/// \pre `other` is not `mesh`
void append(Mesh& mesh, const Mesh& other);

/// Share of a mesh's surface near one side of its box that lies at all four corners of that side, where a car
/// has its wheels:
///
///   4 · min over corners of area(corner) / area(slab)
///
/// The slab is the 6 % of the box next to the side; a corner begins .15 of the long edge `along` and .2 of
/// the other edge off the middle. About .9 under a car, .42 for a flat face, near 0 for roof and doors. 0
/// without surface in the slab. The areas are estimated by 20,000 points, spread evenly over the surface.
///
/// \param down   towards the side: an axis of the mesh
/// \param along  index of the axis of the side's long edge, not the axis of `down`
/// \throws DomainError for a name of no axis
[[nodiscard]] double wheel_share(const Mesh& mesh, const std::string& down, std::size_t along);

/// Axes that put the front of a car's mesh along its length and its wheels below; none if `axes` do so.
///
/// The wheels are at the side with the largest wheel_share() among sides as long as the car, if that is at
/// least .6 and twice that of the side now below. Without such a side, only the extents are judged. Front and
/// tail are not distinguished: a front that is found has the positive sign. A flat mesh is no car.
///
/// \param mesh  as in its file, where `axes` point up and to its front
/// \throws DomainError as world_from_mesh()
[[nodiscard]] std::optional<MeshAxes> better_car_axes(const Mesh& mesh, const MeshAxes& axes);
}  // namespace tapestry::geometry
