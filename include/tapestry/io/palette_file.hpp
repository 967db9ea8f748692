#pragma once
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::io {

/// Reads the colours of a palette, one a line: red, green and blue from 0 to 1, with blanks or commas between
/// them; blank lines and lines that start with # are skipped.
/// Takes memory of at most 3 times the file and 1 MiB.
///
/// \returns  [colour, 3]
/// \throws FileError: malformed (with the line: not three numbers, one outside 0 to 1), mismatch (no colour
/// at
///         all), limit (more than 4096)
[[nodiscard]] Array<double, 2> read_palette(const std::string& path);

}  // namespace tapestry::io
