#pragma once
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// The .npz files of a folder in order of their names, numbers by value: data2 before data10.
/// \throws FileError: malformed (not a readable folder), mismatch (no .npz file in it)
[[nodiscard]] std::vector<std::string> frame_paths(const std::string& folder);

}  // namespace tapestry::io
