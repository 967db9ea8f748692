#pragma once
#include <new>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::shell {

/// Whether a file may be a frame by its name, see io::frame_paths().
inline bool is_frame_file(const std::filesystem::path& path) {
  return path.extension() == ".npz" || path.extension() == ".json";
}

using io::is_folder, io::is_there, io::status_of;

/// File that a path leads to, without links and dots; the path itself if that cannot be resolved.
inline std::filesystem::path place_of(const std::string& path) {
  std::error_code failure;
  auto place = std::filesystem::weakly_canonical(io::path_of(path), failure);
  if (failure == std::errc::not_enough_memory) throw std::bad_alloc();
  return failure ? io::path_of(path) : place;
}

/// Checks that files can be written into a folder, before hours of work. The file that it writes for the
/// check has the name of a temporary: if it cannot be removed, the next run in the folder removes it.
inline void require_writable_folder(const std::string& folder) {
  const std::string probe = io::detail::part_path(folder + "/.tapestry-probe", 0);
  const auto remove_probe = [&] {
    std::error_code failure;
    for (int attempt = 0; attempt < 2; ++attempt)
      if (std::filesystem::remove(io::path_of(probe), failure) || !failure) return;
  };
  try {
    io::write_file_atomically(probe, std::string_view("tapestry\n"));
  } catch (const FileError&) {
    remove_probe();  // the file exists if flushing its folder failed
    throw;
  }
  remove_probe();
}

/// Checks that a file can be written, before hours of work; removes temporaries of killed processes beside
/// it.
inline void require_writable_file(const std::string& path) {
  using std::filesystem::file_type;
  const std::string folder = io::path_of(path).parent_path().string();
  if (!is_folder(folder.empty() ? "." : folder, ErrorKind::write))
    throw FileError(ErrorKind::write, {path, "", "its folder does not exist"});
  const file_type type = status_of(path, ErrorKind::write).type();
  if (type != file_type::not_found && type != file_type::regular)
    throw FileError(ErrorKind::write, {path, "", "exists and is not a regular file"});
  io::remove_abandoned_parts(folder);
  require_writable_folder(folder.empty() ? "." : folder);
}

}  // namespace tapestry::shell
