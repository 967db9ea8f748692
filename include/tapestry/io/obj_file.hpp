#pragma once
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
/// A mesh, and the warnings and counts from reading it.
struct LoadedMesh {
  geometry::Mesh mesh;
  std::vector<std::string> warnings;          ///< one line a kind, with file and line
  std::vector<std::string> material_files{};  ///< read beside the mesh, in order
  std::size_t polygon_count = 0;              ///< faces of more than three corners, split into triangles
  std::size_t crossing_count = 0;             ///< polygons that cross themselves; triangles may be wrong
  std::size_t degenerate_count = 0;           ///< triangles without area; kept, since face lists count them
  std::size_t without_uv_count = 0;           ///< triangles with a corner that has no texture coordinates
  std::array<double, 3> lowest{};             ///< bounds of all vertices
  std::array<double, 3> highest{};
};

namespace detail {
/// Whether the corners lie on one line, or in one point.
inline bool is_degenerate(const geometry::Mesh& mesh, const geometry::Corners& face) {
  const auto corner = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(face[i])]; };
  const auto origin = corner(0);
  std::array<double, 3> u = corner(1);
  std::array<double, 3> v = corner(2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    u[axis] -= origin[axis];
    v[axis] -= origin[axis];
  }
  return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/// Computes the bounds and counts of a mesh with at least one vertex; returns its largest extent.
inline double measure_mesh(LoadedMesh& loaded) {
  loaded.lowest = loaded.highest = loaded.mesh.positions.at(0);
  double extent = 0;
  for (const auto& position : loaded.mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      loaded.lowest[axis] = std::min(loaded.lowest[axis], position[axis]);
      loaded.highest[axis] = std::max(loaded.highest[axis], position[axis]);
      extent = std::max(extent, loaded.highest[axis] - loaded.lowest[axis]);
    }
  }
  for (const auto& face : loaded.mesh.faces)
    loaded.degenerate_count += is_degenerate(loaded.mesh, face) ? 1U : 0U;
  for (const auto& uvs : loaded.mesh.face_uvs)
    loaded.without_uv_count += uvs[0] < 0 || uvs[1] < 0 || uvs[2] < 0 ? 1U : 0U;
  return extent;
}
}  // namespace detail

/// Reads the names, diffuse colours (Kd) and names of textures (map_Kd) of a Wavefront material file held in
/// memory; other properties are ignored. Keywords may be of any case. The name may be empty; a material
/// without a colour, or with one that is not red, green and blue, has the default of geometry::Material.
/// One number is a grey. Textures outside the folder of the file are left out with a warning. Whether a
/// texture exists is not checked.
///
/// \param path      names the file in messages
/// \param warnings receives oddities that are no reason to refuse the file, one line a kind
/// \throws FileError: malformed (zero bytes), limit (overlong lines)
[[nodiscard]] std::vector<geometry::Material> parse_mtl(std::string_view text, const std::string& path,
                                                        std::vector<std::string>& warnings);

/// Reads a Wavefront material file of at most 16 MiB; otherwise as parse_mtl().
/// Takes memory of at most 24 times the file and 1 MiB.
/// \throws FileError as parse_mtl() and read_text_file()
[[nodiscard]] std::vector<geometry::Material> read_mtl(const std::string& path,
                                                       std::vector<std::string>& warnings);

/// Limits on the content of an OBJ.
struct ObjLimits {
  std::uint64_t file_bytes = std::uint64_t(4) << 30U;
  std::size_t records = std::size_t(1)
                        << 24U;  ///< vertices, and alike triangles, texture coordinates, normals
  std::size_t line_bytes = std::size_t(1) << 20U;
  std::uint64_t material_bytes = std::uint64_t(1) << 24U;      ///< all material files together
  std::uint64_t triangulation_work = std::uint64_t(1) << 30U;  ///< limit for geometry::PolygonTriangulator
};

/// Reads an OBJ held in memory; `path` names it in messages, and its material files lie in the same folder.
[[nodiscard]] LoadedMesh parse_obj(std::string_view text, const std::string& path,
                                   const ObjLimits& limits = {});

/// Reads a Wavefront OBJ and the material files beside it.
///
/// Faces keep the order of the file. A polygon becomes triangles in its place, two fewer than its corners;
/// face lists refer to the triangles. A convex polygon becomes the fan around its first corner.
/// geometry::PolygonTriangulator cuts a concave one. A polygon that crosses itself becomes a fan, with a
/// warning. The group of a face is the name of the last `g` or `o` record. Indices may be negative or refer
/// to later records. Material files outside the folder of the OBJ are not read. Numbers 4 to 6 of a vertex
/// are its colour, where there are six or more.
///
/// Oddities that change nothing bring one warning a kind, with a count: words after a record's numbers, faces
/// of fewer than three corners, indices of texture coordinates or normals in a file that has none, normals of
/// no direction, materials without a definition. Keywords may be of any case; # begins a comment in a record
/// of numbers.
///
/// The records are parsed here, not by tinyobjloader. It reads malformed numbers as 0, returns indices beyond
/// the lists with only a warning, pads short records with 0, and reports no line numbers; these are refused.
/// Takes memory of at most 40 times the file and 1 MiB.
///
/// \throws FileError: malformed (with the line), mismatch (a mesh without extent), limit (also for concave
///         polygons of so many corners that cutting them would take long)
[[nodiscard]] LoadedMesh read_obj(const std::string& path, const ObjLimits& limits = {});
}  // namespace tapestry::io
