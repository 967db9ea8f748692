#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/text_lines.hpp>
#include <unordered_set>
#include <vector>

namespace tapestry::io {
namespace detail {
/// The three numbers of a Kd record, cut to 0 to 1 with a warning.
inline std::array<float, 3> diffuse_colour(TextLines& lines, std::vector<std::string>& warnings) {
  std::array<float, 3> colour{};
  bool outside = false;
  for (float& channel : colour) {
    const std::string_view word = lines.word();
    double value = 0;
    if (!parse_number(word, value))
      lines.fail("diffuse colour is not three numbers", "Kd r g b", in_quotes(word));
    outside = outside || value < 0 || value > 1;
    channel = static_cast<float>(std::clamp(value, 0.0, 1.0));
  }
  if (outside) lines.warn(warnings, "colour outside 0 to 1 is cut to it");
  return colour;
}
}  // namespace detail

/// Reads the names and diffuse colours of a Wavefront material file held in memory; the other properties are
/// ignored, with a warning where there are maps. The name may be empty; a material without a colour has that
/// of geometry::Material.
///
/// \param path      names the file in messages
/// \param warnings  receives oddities that are no reason to refuse, one line each and at most 100
/// \throws FileError: malformed (colours that are not numbers, or before the first material)
[[nodiscard]] inline std::vector<geometry::Material> parse_mtl(std::string_view text, const std::string& path,
                                                               std::vector<std::string>& warnings) {
  TextLines lines(text, path);
  std::vector<geometry::Material> materials;
  std::unordered_set<std::string_view> names;
  bool has_map = false;
  bool counts = false;  // whether the present material is the first of its name
  while (lines.next()) {
    const std::string_view keyword = lines.word();
    if (keyword == "newmtl") {
      const std::string_view name = lines.rest_of_line();
      counts = names.insert(name).second;
      if (counts) {
        materials.push_back({std::string(name), geometry::Material{}.colour});
      } else {
        lines.warn(warnings,
                   "material " + in_quotes(name) + " is defined again; the first definition counts");
      }
    } else if (keyword == "map_Kd" && !has_map) {
      has_map = true;
      lines.warn(warnings, "textures (map_Kd) are not read; colours (Kd) are");
    } else if (keyword == "Kd") {
      if (names.empty()) lines.fail("colour before the first material", "newmtl");
      const auto colour = detail::diffuse_colour(lines, warnings);
      if (counts) materials.back().colour = colour;
    }
  }
  return materials;
}

/// Reads a Wavefront material file of at most 16 MiB; otherwise as parse_mtl().
/// \throws FileError as parse_mtl() and read_text_file()
[[nodiscard]] inline std::vector<geometry::Material> read_mtl(const std::string& path,
                                                              std::vector<std::string>& warnings) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 24U);
  return parse_mtl(text, path, warnings);
}

}  // namespace tapestry::io
