#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// Reads class names, one a line, in the order of the classes; empty lines at the end are skipped.
/// Takes memory of at most 32 times the file and 1 MiB.
///
/// \param class_count  how many the detector has; 0 accepts any number
/// \throws FileError: malformed (an empty line between names, no name), mismatch (another number of names, or
///         a name twice)
[[nodiscard]] std::vector<std::string> read_class_names(const std::string& path, std::size_t class_count = 0);

}  // namespace tapestry::io
