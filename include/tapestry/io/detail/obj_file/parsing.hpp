#pragma once
#include <map>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/polygon_triangulator.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <unordered_set>

namespace tapestry::io::detail {
/// Words of the current record up to its end, or to a comment, which # begins even within a word.
class ObjWords {
 public:
  explicit ObjWords(TextLines& lines) : lines_(lines) {}

  /// Empty at the end.
  std::string_view next() {
    if (is_at_comment_) return {};
    const std::string_view word = lines_.word();
    const std::size_t length = word.find('#');
    is_at_comment_ = length != std::string_view::npos;
    return word.substr(0, length);
  }

  template <std::size_t Most>
  struct Numbers {
    std::array<double, Most> values{};
    std::size_t count = 0;
    std::string_view left_over{};  ///< the first word that is not taken
  };

  /// The finite numbers that come next, up to `Most`.
  /// \param least  the first words that must be numbers, if present
  /// \throws FileError (malformed) otherwise
  template <std::size_t Most>
  Numbers<Most> numbers(std::size_t least) {
    Numbers<Most> found;
    for (std::string_view word = next(); !word.empty(); word = next()) {
      double value = 0;
      const bool is_number = found.count < Most && parse_number(word, value) &&
                             std::abs(value) <= static_cast<double>(std::numeric_limits<float>::max());
      if (!is_number && found.count < least)
        lines_.fail("not a finite number", "a number of single precision", in_quotes(word));
      if (!is_number) {
        found.left_over = word;
        break;
      }
      found.values[found.count++] = value;
    }
    return found;
  }

 private:
  TextLines& lines_;
  bool is_at_comment_ = false;
};

/// Faces with a normal of length 0 count as without normals.
inline void drop_normals_without_length(geometry::Mesh& mesh) {
  const auto is_zero = [&](std::int32_t i) {
    return i >= 0 && mesh.normals[static_cast<std::size_t>(i)] == geometry::Vector3{};
  };
  for (auto& corners : mesh.face_normals)
    if (std::ranges::any_of(corners, is_zero)) corners = {-1, -1, -1};
}

/// Triangles of materials with a texture, but without texture coordinates.
[[nodiscard]] inline std::size_t textured_without_uv_count(const geometry::Mesh& mesh) {
  std::size_t count = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    const std::int32_t material = mesh.face_materials[face];
    if (material >= 0 && mesh.face_uvs[face][0] < 0 &&
        !mesh.materials[static_cast<std::size_t>(material)].texture.empty())
      ++count;
  }
  return count;
}

/// The materials of an OBJ: from its material files, each read once, and names without a definition.
class ObjMaterials {
 public:
  /// \param count  largest number of materials
  /// \param bytes  largest size of all material files together
  ObjMaterials(LoadedMesh& loaded, LineOddities& oddities, std::size_t count, std::uint64_t bytes)
      : loaded_(loaded), oddities_(oddities), most_(count), bytes_left_(bytes) {}

  /// Index of the material that is named on the rest of the line (usemtl), or by its first word where only
  /// that is defined. It may be defined later in the file.
  std::int32_t index(TextLines& lines) {
    std::string_view name = lines.rest_of_line();
    const std::string_view word = lines.word();
    if (!numbers_.contains(name) && numbers_.contains(word)) name = word;
    const std::size_t count = loaded_.mesh.materials.size();
    const std::size_t found = add({std::string(name), geometry::Material{}.colour}, lines);
    if (found == count) undefined_lines_[found] = lines.number();
    return static_cast<std::int32_t>(found);
  }

  /// The rest of the line (mtllib) names one file, or several separated by blanks.
  void read_libraries(TextLines& lines) {
    const std::string names(lines.rest_of_line());
    if (names.empty()) return oddities_.add("mtllib without a name", lines);
    if (names.find_first_of(" \t") == std::string::npos ||
        (can_be_path(names) && is_there((folder_of(lines) / names).string())))
      return read_library(lines, names);
    for (std::string_view name = lines.word(); !name.empty(); name = lines.word())
      read_library(lines, std::string(name));
  }

  /// Remarks on materials that faces name and no file defines, and on files without a named one.
  void finish() {
    const auto& mesh = loaded_.mesh;
    for (std::size_t i = 0; i < mesh.materials.size(); ++i)
      if (undefined_lines_[i] != 0)
        oddities_.add("material % is not defined; it gets a default colour", undefined_lines_[i],
                      mesh.materials[i].name);
    const bool is_one_used = std::ranges::any_of(mesh.face_materials, [](std::int32_t i) { return i >= 0; });
    if (!mesh.materials.empty() && !is_one_used)
      oddities_.add("no face uses a material (usemtl) of the file; all get a default colour", library_line_);
  }

 private:
  /// Whether file systems allow names of this length.
  [[nodiscard]] static bool can_be_path(const std::string& name) {
    constexpr std::size_t longest_name = 255;
    std::size_t length = 0, longest = 0;
    for (const char c : name) longest = std::max(longest, length = c == '/' ? 0 : length + 1);
    return name.size() <= longest_path && longest <= longest_name;
  }

  [[nodiscard]] static std::filesystem::path folder_of(const TextLines& lines) {
    return path_of(lines.path()).parent_path();
  }

  void read_library(const TextLines& lines, const std::string& name) {
    if (!can_be_path(name)) return oddities_.add("mtllib % is longer than a path can be", lines, name);
    const std::filesystem::path relative = path_of(name).lexically_normal();
    if (!names_.insert(relative.string()).second) return;
    if (!stays_below(name))
      return oddities_.add("mtllib % lies outside the folder of the OBJ and is not read", lines, name);
    const std::string path = (folder_of(lines) / relative).string();
    if (!is_regular_file(path))
      return oddities_.add("mtllib % is not there; materials get a default colour", lines, name);
    const std::string text = read_text_file(path, bytes_left_);
    bytes_left_ -= text.size();
    loaded_.material_files.push_back(path);
    library_line_ = library_line_ == 0 ? lines.number() : library_line_;
    for (const auto& material : parse_mtl(text, path, loaded_.warnings)) {
      const std::size_t at = add(material, lines);
      if (undefined_lines_[at] != 0) loaded_.mesh.materials[at] = material;
      undefined_lines_[at] = 0;
    }
  }

  /// The index of the material with this name; the first one of a name counts.
  std::size_t add(const geometry::Material& material, const TextLines& lines) {
    auto& materials = loaded_.mesh.materials;
    const auto [place, is_new] = numbers_.try_emplace(material.name, materials.size());
    if (!is_new) return place->second;
    if (materials.size() >= most_)
      lines.fail("mesh is too large", "at most " + std::to_string(most_) + " materials", "more",
                 ErrorKind::limit);
    materials.push_back(material);
    undefined_lines_.push_back(0);
    return place->second;
  }

  LoadedMesh& loaded_;
  LineOddities& oddities_;
  std::vector<std::size_t> undefined_lines_;  // line of each material's first use; 0 once it is defined
  std::size_t library_line_ = 0;              // of the first file that is read
  std::size_t most_;
  std::uint64_t bytes_left_;
  std::unordered_set<std::string> names_;
  std::map<std::string, std::size_t, std::less<>> numbers_;  // by name
};

/// Indices of a face's corner: vertex, texture coordinate and normal, -1 for none.
using ObjCorner = std::array<std::int32_t, 3>;

/// Adds the faces of an OBJ to its mesh as triangles, in their place, two fewer than their corners.
class ObjFaces {
 public:
  /// \param work  of geometry::PolygonTriangulator
  ObjFaces(LoadedMesh& loaded, const TextLines& lines, std::uint64_t work)
      : loaded_(loaded), lines_(lines), triangulator_(work) {}

  /// Adds the face on the current line, of at least three corners.
  void add(const std::vector<ObjCorner>& corners, std::int32_t material, std::int32_t group) {
    auto& mesh = loaded_.mesh;
    const Polygon polygon{mesh.faces.size(), corners.size(), lines_.number()};
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      mesh.faces.emplace_back();
      mesh.face_uvs.emplace_back();
      mesh.face_normals.emplace_back();
      mesh.face_materials.push_back(material);
      mesh.face_groups.push_back(group);
      write_triangle(polygon.first + i - 1, corners[0], corners[i], corners[i + 1]);
    }
    if (corners.size() == 3) return;
    ++loaded_.polygon_count;
    const auto known = static_cast<std::int32_t>(mesh.positions.size());
    if (std::ranges::any_of(corners, [&](const ObjCorner& corner) { return corner[0] >= known; })) {
      waiting_.push_back(polygon);
    } else {
      cut(polygon, corners);
    }
  }

  /// Cuts the polygons whose vertices came later in the file, now that all are there.
  void finish() {
    const auto& mesh = loaded_.mesh;
    std::vector<ObjCorner> corners;
    for (const Polygon& polygon : waiting_) {
      corners.clear();
      const auto add_corner = [&](std::size_t face, std::size_t i) {
        corners.push_back({mesh.faces[face][i], mesh.face_uvs[face][i], mesh.face_normals[face][i]});
      };
      add_corner(polygon.first, 0);
      add_corner(polygon.first, 1);
      for (std::size_t i = 0; i + 2 < polygon.corner_count; ++i) add_corner(polygon.first + i, 2);
      cut(polygon, corners);
    }
  }

  /// Line of the first polygon that crosses itself; 0 if there is none.
  [[nodiscard]] std::size_t first_crossing() const { return first_crossing_; }

 private:
  /// A polygon that the mesh holds as the fan around its first corner.
  struct Polygon {
    std::size_t first;  // first of its triangles
    std::size_t corner_count;
    std::size_t line;
  };

  void write_triangle(std::size_t face, const ObjCorner& a, const ObjCorner& b, const ObjCorner& c) {
    auto& mesh = loaded_.mesh;
    mesh.faces[face] = {a[0], b[0], c[0]};
    mesh.face_uvs[face] = {a[1], b[1], c[1]};
    mesh.face_normals[face] = {a[2], b[2], c[2]};
  }

  /// Replaces the fan by the correct triangles if it is not one of the polygon.
  void cut(const Polygon& polygon, const std::vector<ObjCorner>& corners) {
    outline_.clear();
    for (const ObjCorner& corner : corners)
      outline_.push_back(loaded_.mesh.positions[static_cast<std::size_t>(corner[0])]);
    const auto shape = triangulator_.triangulate(outline_);
    if (shape == geometry::PolygonShape::intricate)
      lines_.fail_at(polygon.line, "concave polygons take too long to be cut into triangles", "fewer corners",
                     std::to_string(polygon.corner_count), ErrorKind::limit);
    if (shape == geometry::PolygonShape::crossing && loaded_.crossing_count++ == 0)
      first_crossing_ = polygon.line;
    if (shape != geometry::PolygonShape::concave) return;
    std::size_t face = polygon.first;
    for (const auto& [a, b, c] : triangulator_.triangles())
      write_triangle(face++, corners[a], corners[b], corners[c]);
  }

  LoadedMesh& loaded_;
  const TextLines& lines_;
  geometry::PolygonTriangulator triangulator_;
  std::vector<Polygon> waiting_;
  std::vector<geometry::Vector3> outline_;
  std::size_t first_crossing_ = 0;
};
}  // namespace tapestry::io::detail
