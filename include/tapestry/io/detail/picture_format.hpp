#pragma once
#include <span>
#include <tapestry/core/array.hpp>

namespace tapestry::io::detail {
/// A format of pictures that is read. Its readers take the content of a file, its name for messages, and
/// where warnings go, or null; see read_image() and read_mask().
struct PictureFormat {
  std::string_view names;    ///< words between spaces
  std::string_view endings;  ///< of files' names, likewise
  bool (*recognises)(std::string_view file);
  Array<std::uint8_t, 3> (*picture)(std::string file, const std::string& path,
                                    std::vector<std::string>* warnings, bool is_texture);
  Array<float, 2> (*mask)(std::string file, const std::string& path,
                          std::vector<std::string>* warnings);  ///< null for one with losses
};

/// All of them, the only list: a new format is a row of it.
[[nodiscard]] std::span<const PictureFormat> picture_formats();
}  // namespace tapestry::io::detail
