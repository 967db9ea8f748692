#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <utility>
#include <vector>

namespace tapestry::io::detail {

/// The three numbers of a Kd record, clipped to 0 to 1 with a warning.
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

/// Least and largest number of words behind an option of a map record; none for a word that is no option.
struct MapOption {
  std::string_view name;
  std::size_t least, most;
};

inline constexpr std::array<MapOption, 12> map_options{{{"-blendu", 1, 1},
                                                        {"-blendv", 1, 1},
                                                        {"-bm", 1, 1},
                                                        {"-boost", 1, 1},
                                                        {"-cc", 1, 1},
                                                        {"-clamp", 1, 1},
                                                        {"-imfchan", 1, 1},
                                                        {"-mm", 2, 2},
                                                        {"-o", 1, 3},
                                                        {"-s", 1, 3},
                                                        {"-t", 1, 3},
                                                        {"-texres", 1, 1}}};

/// The file that a map record names, if it is in the folder of the material file or below; else empty, with a
/// warning.
inline std::string map_file(TextLines& lines, std::vector<std::string>& warnings) {
  std::string_view rest = lines.rest_of_line();
  const auto next_word = [&] {
    const std::size_t end = std::min(rest.find_first_of(" \t"), rest.size());
    const std::string_view word = rest.substr(0, end);
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t", end), rest.size()));
    return word;
  };
  const auto is_number = [&] {
    double ignored = 0;
    return parse_number(rest.substr(0, rest.find_first_of(" \t")), ignored);
  };
  while (rest.starts_with('-')) {
    const std::string_view word = rest.substr(0, rest.find_first_of(" \t"));
    const auto* const option =
        std::ranges::find_if(map_options, [&](const MapOption& one) { return one.name == word; });
    if (option == map_options.end()) break;
    lines.warn(warnings, "option " + in_quotes(next_word()) + " of a texture is ignored");
    for (std::size_t i = 0; i < option->most && (i < option->least || is_number()); ++i) (void)next_word();
  }
  std::string name(rest);
  std::ranges::replace(name, '\\', '/');
  if (name.empty()) {
    lines.warn(warnings, "texture without a file name");
  } else if (!stays_below(name)) {
    lines.warn(warnings, "texture " + in_quotes(name) +
                             " lies outside the folder of the material file and is not read");
  } else {
    return (std::filesystem::path(lines.path()).parent_path() /
            std::filesystem::path(name).lexically_normal())
        .string();
  }
  return {};
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

std::vector<geometry::Material> parse_mtl(std::string_view text, const std::string& path,
                                          std::vector<std::string>& warnings) {
  TextLines lines(text, path);
  std::vector<geometry::Material> materials;
  NameNumbers names;
  bool counts = false;  // whether the present material is the first of its name
  while (lines.next()) {
    const std::string_view keyword = lines.word();
    if (keyword == "newmtl") {
      const std::string_view name = lines.rest_of_line();
      counts = names.add(name, [&](std::size_t i) -> std::string_view { return materials[i].name; }) ==
               materials.size();
      if (counts) {
        materials.push_back({std::string(name), geometry::Material{}.colour});
      } else {
        lines.warn(warnings,
                   "material " + in_quotes(name) + " is defined again; the first definition counts");
      }
    } else if (keyword == "map_Kd") {
      if (materials.empty()) lines.fail("texture before the first material", "newmtl");
      std::string file = detail::map_file(lines, warnings);
      if (counts) materials.back().texture = std::move(file);
    } else if (keyword == "Kd") {
      if (materials.empty()) lines.fail("colour before the first material", "newmtl");
      const auto colour = detail::diffuse_colour(lines, warnings);
      if (counts) materials.back().colour = colour;
    }
  }
  return materials;
}

std::vector<geometry::Material> read_mtl(const std::string& path, std::vector<std::string>& warnings) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 24U);
  return parse_mtl(text, path, warnings);
}

}  // namespace tapestry::io
