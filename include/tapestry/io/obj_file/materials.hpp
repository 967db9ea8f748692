#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/file_status.hpp>
#include <tapestry/io/loaded_mesh.hpp>
#include <tapestry/io/mtl_file.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/text_lines.hpp>
#include <unordered_set>

namespace tapestry::io::detail {

/// The materials of an OBJ: those of its material files, each read once, and those it only names.
class ObjMaterials {
 public:
  /// \param count  materials that there may be
  /// \param bytes  that all material files together may have
  ObjMaterials(LoadedMesh& loaded, std::size_t count, std::uint64_t bytes)
      : loaded_(loaded), most_(count), bytes_left_(bytes) {}

  /// Index of the material that is named on the rest of the line (usemtl).
  std::int32_t index(const TextLines& lines) {
    const std::string_view name = lines.rest_of_line();
    const std::size_t before = loaded_.mesh.materials.size();
    const std::int32_t found = add({std::string(name), geometry::Material{}.colour}, lines);
    if (loaded_.mesh.materials.size() > before)
      lines.warn(loaded_.warnings,
                 "material " + in_quotes(name) + " is not defined before; it gets a default colour");
    return found;
  }

  /// The rest of the line (mtllib) names one file, or several separated by blanks.
  void read_libraries(TextLines& lines) {
    const std::string names(lines.rest_of_line());
    if (names.empty()) lines.fail("mtllib without a name");
    if (names.find_first_of(" \t") == std::string::npos ||
        (can_be_path(names) && is_there((folder_of(lines) / names).string())))
      return read_library(lines, names);
    for (std::string_view name = lines.word(); !name.empty(); name = lines.word())
      read_library(lines, std::string(name));
  }

 private:
  /// Whether file systems have names as long.
  [[nodiscard]] static bool can_be_path(const std::string& name) {
    constexpr std::size_t longest_name = 255;
    std::size_t length = 0, longest = 0;
    for (const char c : name) longest = std::max(longest, length = c == '/' ? 0 : length + 1);
    return name.size() <= longest_path && longest <= longest_name;
  }

  [[nodiscard]] static std::filesystem::path folder_of(const TextLines& lines) {
    return std::filesystem::path(lines.path()).parent_path();
  }

  void read_library(const TextLines& lines, const std::string& name) {
    if (!can_be_path(name))
      return lines.warn(loaded_.warnings, "mtllib " + in_quotes(name) + " is longer than a path can be");
    const std::filesystem::path relative = std::filesystem::path(name).lexically_normal();
    if (!names_.insert(relative.string()).second) return;
    if (!stays_below(name))
      return lines.warn(loaded_.warnings,
                        "mtllib " + in_quotes(name) + " lies outside the folder of the OBJ and is not read");
    const std::string path = (folder_of(lines) / relative).string();
    if (!is_regular_file(path))
      return lines.warn(loaded_.warnings, "mtllib " + in_quotes(name) + " is not there (" + path +
                                              "); materials get a default colour");
    const std::string text = read_text_file(path, bytes_left_);
    bytes_left_ -= text.size();
    loaded_.material_files.push_back(path);
    for (const auto& material : parse_mtl(text, path, loaded_.warnings)) add(material, lines);
  }

  /// The index of the material of this name; the first one of a name counts.
  std::int32_t add(const geometry::Material& material, const TextLines& lines) {
    auto& materials = loaded_.mesh.materials;
    const std::size_t index =
        numbers_.add(material.name, [&](std::size_t i) -> std::string_view { return materials[i].name; });
    if (index < materials.size()) return static_cast<std::int32_t>(index);
    if (materials.size() >= most_)
      lines.fail("mesh is too large", "at most " + std::to_string(most_) + " materials", "more",
                 ErrorKind::limit);
    materials.push_back(material);
    return static_cast<std::int32_t>(index);
  }

  LoadedMesh& loaded_;
  std::size_t most_;
  std::uint64_t bytes_left_;
  std::unordered_set<std::string> names_;
  NameNumbers numbers_;
};

}  // namespace tapestry::io::detail
