#pragma once
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::io {

/// Paths of a folder's entries that `accepts` takes, sorted.
/// \throws FileError (malformed) if the folder cannot be listed; std::bad_alloc
template <std::predicate<const std::filesystem::path&> Accepts>
[[nodiscard]] std::vector<std::string> listed_paths(const std::string& folder, Accepts accepts) {
  std::vector<std::string> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (accepts(entry->path())) paths.push_back(entry->path().string());
  if (error == std::errc::not_enough_memory) throw std::bad_alloc();
  if (error)
    throw FileError(ErrorKind::malformed, {folder, "", "cannot list the folder: " + error.message()});
  std::sort(paths.begin(), paths.end());
  return paths;
}

/// How names of pictures that can be read end, for messages.
inline constexpr const char* picture_endings = ".png, .jpg, .jpeg, .bmp, .pgm, .ppm or .pnm";

/// Whether a name ends as that of a picture that can be read.
[[nodiscard]] bool has_picture_name(const std::filesystem::path& path);

}  // namespace tapestry::io
