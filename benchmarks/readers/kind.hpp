#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace tapestry::benchmarks {
/// A reader with files that are bad for it.
struct Kind {
  std::string name;
  /// A file of nearly that many bytes.
  std::function<std::string(std::size_t bytes)> make;
  /// Reads the file of that path; what it throws is the answer to such files.
  std::function<void(const std::string& path)> read;
  /// Bytes that reading that file may take at most, beside a mebibyte, as the reader's comment states it.
  std::function<double(const std::string& path)> most_memory;
  std::size_t largest_mb = 8;  ///< beyond it the reader refuses by size alone
};

[[nodiscard]] inline std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

/// Entries of filled(): `before`, a number that is another each time, and `behind`.
[[nodiscard]] inline auto numbered(const std::string& before, const std::string& behind) {
  return [=](std::size_t i) { return before + std::to_string(i) + behind; };
}

/// Makes files of `beginning`, entries until the file has its size, and `end`. An entry is text, or made of
/// its number. The last one may be cut by `cut` characters, such as a comma.
template <class Entry>
std::function<std::string(std::size_t bytes)> filled(const std::string& beginning, Entry entry,
                                                     const std::string& end = "", std::size_t cut = 0) {
  return [=](std::size_t bytes) {
    std::string text = beginning;
    text.reserve(bytes + 4096);
    for (std::size_t i = 0; text.size() + end.size() < bytes; ++i)
      if constexpr (std::is_invocable_v<Entry, std::size_t>)
        text += entry(i);
      else
        text += entry;
    text.resize(text.size() - cut);
    return text += end;
  };
}

/// The limit of readers that take up to so many times the file.
inline std::function<double(const std::string& path)> times_file(double times) {
  return
      [=](const std::string& path) { return times * static_cast<double>(std::filesystem::file_size(path)); };
}

std::vector<Kind> picture_kinds();
std::vector<Kind> array_kinds();
std::vector<Kind> mesh_kinds();
std::vector<Kind> detector_kinds();
std::vector<Kind> text_kinds();
}  // namespace tapestry::benchmarks
