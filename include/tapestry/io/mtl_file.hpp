#pragma once
#include <tiny_obj_loader.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <tapestry/core/file_source.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io {
namespace detail {
/// Refuses what the material reader would swallow: colours that are not three numbers, statements before a
/// material.
inline void check_mtl(std::string_view text, const std::string& path, std::vector<std::string>& warnings) {
  TextLines lines(text, path);
  std::set<std::string_view> names;
  bool has_map = false;
  while (lines.next()) {
    const std::string_view keyword = lines.word();
    if (keyword == "newmtl") {
      const std::string_view name = lines.rest_of_line();
      if (name.empty()) lines.fail("material without a name");
      if (!names.insert(name).second)
        warnings.push_back(path + ":" + std::to_string(lines.number()) + ": material " + in_quotes(name) +
                           " is defined again; the first definition counts");
    }
    if (keyword == "map_Kd" && !has_map) {
      has_map = true;
      warnings.push_back(path + ":" + std::to_string(lines.number()) +
                         ": textures (map_Kd) are not read; colours (Kd) are");
    }
    if (keyword != "Kd") continue;
    if (names.empty()) lines.fail("colour before the first material", "newmtl");
    bool outside = false;
    for (int channel = 0; channel < 3; ++channel) {
      const std::string_view word = lines.word();
      double value = 0;
      if (!parse_number(word, value))
        lines.fail("diffuse colour is not three numbers", "Kd r g b", in_quotes(word));
      outside = outside || value < 0 || value > 1;
    }
    if (outside)
      warnings.push_back(path + ":" + std::to_string(lines.number()) +
                         ": colour outside 0 to 1 is cut to it");
  }
}
}  // namespace detail

/// Reads the names and diffuse colours of a Wavefront material file; the other properties are ignored,
/// with a warning where there are maps.
///
/// \param warnings  receives oddities that are no reason to refuse, one line each
/// \throws FileError: malformed (unreadable, colours that are not numbers), limit
[[nodiscard]] inline std::vector<geometry::Material> read_mtl(const std::string& path,
                                                              std::vector<std::string>& warnings) {
  std::string text = read_text_file(path, std::uint64_t(1) << 24U);
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  detail::check_mtl(text, path, warnings);
  std::map<std::string, int> index;
  std::vector<tinyobj::material_t> parsed;
  std::string warning, error;
  std::istringstream stream(text);
  tinyobj::LoadMtl(&index, &parsed, &stream, &warning, &error);
  std::vector<geometry::Material> materials;
  for (std::size_t i = 0; i < parsed.size(); ++i) {
    const auto& material = parsed[i];
    if (material.name.empty() || index.at(material.name) != static_cast<int>(i))
      continue;  // an earlier one counts
    std::array<float, 3> colour{};
    for (std::size_t c = 0; c < 3; ++c)
      colour[c] = std::clamp(static_cast<float>(material.diffuse[c]), 0.0F, 1.0F);
    materials.push_back({material.name, colour});
  }
  return materials;
}

}  // namespace tapestry::io
