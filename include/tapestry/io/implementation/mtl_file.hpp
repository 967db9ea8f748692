#pragma once
#include <set>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {
namespace detail {
/// The colour of a Kd record, of three numbers or of one for all channels, clipped to 0 to 1; none for other
/// words, such as the kinds xyz and spectral.
inline std::optional<std::array<float, 3>> diffuse_colour(TextLines& lines, LineOddities& oddities) {
  const std::string_view record = lines.rest_of_line();
  std::array<double, 3> values{};
  std::size_t count = 0;
  bool is_number = true;
  while (count < 3 && is_number) {
    const std::string_view word = lines.word();
    if (word.empty() || word.starts_with('#')) break;
    is_number = parse_number(word.substr(0, word.find('#')), values[count++]);
  }
  if (!is_number || (count != 1 && count != 3)) {
    oddities.add("Kd % is not red, green and blue; the colour stays as it was", lines, record);
    return {};
  }
  if (count == 1) values[1] = values[2] = values[0];
  std::array<float, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c) colour[c] = static_cast<float>(std::clamp(values[c], 0.0, 1.0));
  if (std::ranges::any_of(values, [](double value) { return value < 0 || value > 1; }))
    oddities.add("colour outside 0 to 1 is cut to it", lines);
  return colour;
}

/// Adds an oddity for a record that makes the material transparent or luminous: it is drawn opaque, and emits
/// no light.
inline void remark_on_undrawn(const std::string& keyword, TextLines& lines, LineOddities& oddities) {
  const std::string record = keyword + " " + std::string(lines.rest_of_line());
  if (keyword.starts_with("map_"))
    return oddities.add("% is not drawn: the material is opaque and emits no light", lines, record);
  const double plain = keyword == "d" ? 1 : 0;
  for (std::string_view word = lines.word(); !word.empty() && !word.starts_with('#'); word = lines.word()) {
    double value = plain;
    if (!parse_number(word, value) || std::clamp(value, 0.0, 1.0) == plain) continue;
    return oddities.add(keyword == "ke" ? "% is not drawn: the material emits no light"
                                        : "% is not drawn: the material is opaque",
                        lines, record);
  }
}

/// Options of a map record with the least and largest number of words behind them.
struct MapOptions {
  std::string_view names;
  std::size_t least, most;
};

inline constexpr std::array<MapOptions, 3> map_options{
    {{"-blendu -blendv -bm -boost -cc -clamp -colorspace -imfchan -texres -type", 1, 1},
     {"-mm", 2, 2},
     {"-o -s -t", 1, 3}}};

/// The file that a map record names, if it is in the folder of the material file or below; else empty, with a
/// warning.
inline std::string map_file(const TextLines& lines, LineOddities& oddities) {
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
    const auto* const option = std::ranges::find_if(
        map_options, [&](const MapOptions& some) { return is_word_of(some.names, word); });
    if (option == map_options.end()) break;
    oddities.add("option % of a texture is ignored", lines, next_word());
    for (std::size_t i = 0; i < option->most && (i < option->least || is_number()); ++i) (void)next_word();
  }
  std::string name(rest);
  std::ranges::replace(name, '\\', '/');
  if (name.empty()) {
    oddities.add("texture without a file name", lines);
  } else if (!stays_below(name)) {
    oddities.add("texture % lies outside the folder of the material file and is not read", lines, name);
  } else {
    return (path_of(lines.path()).parent_path() / path_of(name).lexically_normal()).string();
  }
  return {};
}
}  // namespace detail

std::vector<geometry::Material> parse_mtl(std::string_view text, const std::string& path,
                                          std::vector<std::string>& warnings) {
  TextLines lines(text, path);
  LineOddities oddities;
  std::vector<geometry::Material> materials;
  std::set<std::string> names;
  bool counts = false;  // whether the present material is the first of its name
  while (lines.next()) {
    const std::string keyword = lower_case_keyword(lines.word());
    if (keyword == "newmtl") {
      const std::string_view name = lines.rest_of_line();
      counts = names.emplace(name).second;
      if (counts) {
        materials.push_back({std::string(name), geometry::Material{}.colour});
      } else {
        oddities.add("material % is defined again; the first definition counts", lines, name);
      }
    } else if (keyword == "map_kd") {
      std::string file = detail::map_file(lines, oddities);
      if (counts) materials.back().texture = std::move(file);
      if (materials.empty()) oddities.add("texture before the first material (newmtl) is ignored", lines);
    } else if (keyword == "kd") {
      const auto colour = detail::diffuse_colour(lines, oddities);
      if (counts && colour) materials.back().colour = *colour;
      if (materials.empty()) oddities.add("colour before the first material (newmtl) is ignored", lines);
    } else if (keyword == "d" || keyword == "tr" || keyword == "ke" || keyword == "map_d" ||
               keyword == "map_ke") {
      detail::remark_on_undrawn(keyword, lines, oddities);
    }
  }
  oddities.append_to(warnings, path);
  return materials;
}

std::vector<geometry::Material> read_mtl(const std::string& path, std::vector<std::string>& warnings) {
  const std::string text = read_text_file(path, std::uint64_t(1) << 24U);
  return parse_mtl(text, path, warnings);
}
}  // namespace tapestry::io
