#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// Faces of a mesh, chosen by number.
struct FaceList {
  std::vector<std::int64_t> ids;      ///< counted from 1, in the order of the file, each once
  std::vector<std::string> warnings;  ///< one line each
};

/// Reads a list of face numbers, one a line, counted from 1; blank lines and lines that start with # are
/// skipped. For a mesh with polygons the numbers count its triangles, see read_obj().
/// Takes memory of at most 12 times the file and 1 MiB.
///
/// \param face_count  faces of the mesh the list is for
/// \throws FileError: malformed (with the line: not a whole number, 0, negative), mismatch (a number beyond
///         the faces, or no number at all)
[[nodiscard]] FaceList read_face_list(const std::string& path, std::size_t face_count);

}  // namespace tapestry::io
