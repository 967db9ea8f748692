#pragma once
#include <algorithm>
#include <filesystem>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/io/folder_listing.hpp>
#include <tapestry/io/frame_folder.hpp>
#include <utility>
#include <vector>

namespace tapestry::io::detail {

/// What sorts file names with numbers by value: each number with zeros before it, to at least 20 digits.
inline std::string numeric_order_key(const std::string& path) {
  std::string key;
  const std::string stem = std::filesystem::path(path).stem().string();
  for (std::size_t i = 0; i < stem.size();) {
    std::size_t end = i;
    while (end < stem.size() && stem[end] >= '0' && stem[end] <= '9') ++end;
    if (end > i) key += std::string(20 - std::min<std::size_t>(20, end - i), '0');
    end = std::max(end, i + 1);
    key += stem.substr(i, end - i);
    i = end;
  }
  return key;
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

std::vector<std::string> frame_paths(const std::string& folder) {
  auto paths =
      listed_paths(folder, [](const std::filesystem::path& path) { return path.extension() == ".npz"; });
  if (paths.empty()) throw FileError(ErrorKind::mismatch, {.path = folder, .what = "holds no frame (*.npz)"});
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::pair(detail::numeric_order_key(a), a) < std::pair(detail::numeric_order_key(b), b);
  });
  return paths;
}

}  // namespace tapestry::io
