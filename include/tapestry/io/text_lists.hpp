#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::io {
/// Reads class names, one a line, in the order of the classes; empty lines at the end are skipped.
/// Takes memory of at most 32 times the file and 1 MiB.
///
/// \param class_count number of the detector's classes; 0 accepts any number
/// \throws FileError: malformed (an empty line between names, no name), mismatch (another number of names, or
///         a name twice)
[[nodiscard]] std::vector<std::string> read_class_names(const std::string& path, std::size_t class_count = 0);

/// Faces of a mesh, listed by number.
struct FaceList {
  std::vector<std::int64_t> ids;      ///< counted from 1, in the order of the file, each once
  std::vector<std::string> warnings;  ///< one line each
};

/// Reads a list of face numbers, one a line, counted from 1; blank lines and lines that start with # are
/// skipped. For a mesh with polygons the numbers count its triangles, see read_obj().
/// Takes memory of at most 12 times the file and 1 MiB.
///
/// \param face_count number of faces of the mesh
/// \throws FileError: malformed (with the line: not a whole number, 0, negative), mismatch (a number beyond
///         the faces, or no number at all)
[[nodiscard]] FaceList read_face_list(const std::string& path, std::size_t face_count);

/// Reads the colours of a palette, one a line: red, green and blue from 0 to 1, with blanks or commas between
/// them; blank lines and lines that start with # are skipped.
/// Takes memory of at most 3 times the file and 1 MiB.
///
/// \returns  [colour, 3]
/// \throws FileError: malformed (with the line: not three numbers, one outside 0 to 1), mismatch (no colour
///         at all), limit (more than 4096)
[[nodiscard]] Array<double, 2> read_palette(const std::string& path);
}  // namespace tapestry::io
