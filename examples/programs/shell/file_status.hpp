#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/error.hpp>
#include <tapestry/io/atomic_file.hpp>

namespace tapestry::shell {

/// What a path leads to; file_type::not_found where nothing is.
/// \throws FileError of the given kind where nobody can say, as in a folder without permission
inline std::filesystem::file_status status_of(const std::string& path, ErrorKind kind) {
  std::error_code failure;
  const auto status = std::filesystem::status(path, failure);
  if (status.type() == std::filesystem::file_type::none)
    throw FileError(kind, {path, "", "cannot inspect: " + failure.message()});
  return status;
}

/// Errors as of status_of().
inline bool is_there(const std::string& path, ErrorKind kind) {
  return std::filesystem::exists(status_of(path, kind));
}

/// Errors as of status_of().
inline bool is_folder(const std::string& path, ErrorKind kind) {
  return std::filesystem::is_directory(status_of(path, kind));
}

/// Makes sure that files can be written into a folder, before hours are spent.
inline void require_writable_folder(const std::string& folder) {
  const std::string probe = folder + "/.tapestry-probe";
  const auto remove_probe = [&] {
    std::error_code ignored;
    std::filesystem::remove(probe, ignored);
  };
  try {
    io::write_file_atomically(probe, std::string_view("tapestry\n"));
  } catch (const FileError&) {
    remove_probe();  // it is there where only its folder could not be flushed
    throw;
  }
  remove_probe();
}

/// Clears the folder of a file to be written of what killed processes left.
inline void remove_parts_beside(const std::string& file) {
  io::remove_abandoned_parts(std::filesystem::path(file).parent_path().string());
}

/// Makes sure that a file can be written, before hours are spent.
inline void require_writable_file(const std::string& path) {
  using std::filesystem::file_type;
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (!is_folder(folder.empty() ? "." : folder, ErrorKind::write))
    throw FileError(ErrorKind::write, {path, "", "its folder does not exist"});
  const file_type type = status_of(path, ErrorKind::write).type();
  if (type != file_type::not_found && type != file_type::regular)
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  remove_parts_beside(path);
  require_writable_folder(folder.empty() ? "." : folder);
}

}  // namespace tapestry::shell
