#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/loaded_mesh.hpp>

namespace tapestry::io {

/// How much an OBJ may hold.
struct ObjLimits {
  std::uint64_t file_bytes = std::uint64_t(4) << 30U;
  std::size_t records = std::size_t(1)
                        << 24U;  ///< vertices, and alike triangles, texture coordinates, normals
  std::size_t line_bytes = std::size_t(1) << 20U;
  std::uint64_t material_bytes = std::uint64_t(1) << 24U;      ///< all material files together
  std::uint64_t triangulation_work = std::uint64_t(1) << 30U;  ///< of geometry::PolygonTriangulator
};

/// Reads an OBJ held in memory; `path` names it in messages and says where its material files lie.
[[nodiscard]] LoadedMesh parse_obj(std::string_view text, const std::string& path,
                                   const ObjLimits& limits = {});

/// Reads a Wavefront OBJ and the material files beside it.
///
/// Faces keep the order of the file. A polygon becomes triangles in place, two fewer than its corners; face
/// lists refer to the triangles. Those of a convex polygon are the fan around its first corner, those of a
/// concave one come from geometry::PolygonTriangulator; one that crosses itself becomes a fan with a warning.
/// Groups are the names of `g` and `o` records, whichever came last.
/// Indices may be negative or refer to what comes later. Material files outside the folder of the OBJ are not
/// read.
///
/// The records are parsed here and not by tinyobjloader, because that reads malformed numbers as 0, returns
/// indices beyond the lists with a mere warning, drops short records so that later numbers shift, and gives
/// no lines for them.
/// Takes memory of at most 40 times the file and 1 MiB.
///
/// \throws FileError: malformed (with the line), mismatch (a mesh without extent), limit (also for concave
///         polygons of so many corners that cutting them would take long)
[[nodiscard]] LoadedMesh read_obj(const std::string& path, const ObjLimits& limits = {});

}  // namespace tapestry::io
