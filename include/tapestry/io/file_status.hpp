#pragma once
#include <filesystem>
#include <string>
#include <system_error>
#include <tapestry/core/error.hpp>

namespace tapestry::io {

// The only place where a path is looked at without being opened. Nothing is there where the system says
// ENOENT or ENOTDIR; whatever else it says (no permission, a device that fails, links in a ring) is an error,
// never absence.

/// What a path leads to; file_type::not_found where nothing is.
/// \param kind  of the error: malformed for what is read, write for what is written
/// \throws FileError of that kind where nobody can say
[[nodiscard]] inline std::filesystem::file_status status_of(const std::string& path,
                                                            ErrorKind kind = ErrorKind::malformed) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  using std::filesystem::file_type;
  if (status.type() == file_type::none || (failure && status.type() != file_type::not_found))
    throw FileError(kind, {path, "", "cannot inspect: " + failure.message()});
  return status;
}

/// Whether a path leads to anything. Errors as of status_of().
[[nodiscard]] inline bool is_there(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::exists(status_of(path, kind));
}

/// Whether a path leads to a folder. Errors as of status_of().
[[nodiscard]] inline bool is_folder(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::is_directory(status_of(path, kind));
}

/// Whether a path leads to a regular file. Errors as of status_of().
[[nodiscard]] inline bool is_regular_file(const std::string& path, ErrorKind kind = ErrorKind::malformed) {
  return std::filesystem::is_regular_file(status_of(path, kind));
}

}  // namespace tapestry::io
