#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/file_source.hpp>
#include <vector>

namespace tapestry::detect {

/// Names of a detector's classes, one a line; blank lines at the end and CRLF are accepted.
/// \throws FileError  malformed for an empty name or one given twice, mismatch unless there are
///                    `class_count` of them
[[nodiscard]] inline std::vector<std::string> read_class_names(const std::string& path,
                                                               std::size_t class_count) {
  const std::string text = read_text_file(path, std::uint64_t(4) << 20U);
  std::vector<std::string> names;
  std::size_t blank_line = 0;
  std::size_t line = 0;
  for (std::size_t begin = 0; begin < text.size(); ++line) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string name = text.substr(begin, end - begin);
    begin = end + 1;
    while (!name.empty() && (name.back() == '\r' || name.back() == ' ' || name.back() == '\t'))
      name.pop_back();
    if (name.empty()) {
      if (blank_line == 0) blank_line = line + 1;
      continue;
    }
    if (blank_line != 0) {
      throw FileError(ErrorKind::malformed,
                      {path, std::to_string(blank_line), "empty line among class names"});
    }
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      throw FileError(ErrorKind::malformed,
                      {path, std::to_string(line + 1), "class name given twice", "", name});
    }
    names.push_back(std::move(name));
  }
  if (names.size() != class_count) {
    throw FileError(ErrorKind::mismatch,
                    {path, "", "as many class names as the detector has classes are needed",
                     std::to_string(class_count), std::to_string(names.size())});
  }
  return names;
}

/// Position of a class among the names.
/// \throws Error (mismatch) listing the names that exist, if it is not one of them
[[nodiscard]] inline std::size_t class_index_of(const std::vector<std::string>& names,
                                                std::string_view name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
  std::string list;
  for (const std::string& existing : names) list += (list.empty() ? "" : ", ") + existing;
  throw Error(ErrorKind::mismatch, "no class '" + std::string(name) + "'; the detector knows " + list);
}

}  // namespace tapestry::detect
