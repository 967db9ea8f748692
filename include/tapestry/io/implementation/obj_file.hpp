#pragma once
#include <tapestry/core/finite.hpp>
#include <tapestry/io/detail/obj_file/parsing.hpp>
#include <tapestry/io/obj_file.hpp>

namespace tapestry::io {
namespace detail {
class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& path, const ObjLimits& limits)
      : lines_(text, path, limits.line_bytes),
        limits_(limits),
        beginning_(text.substr(0, 64)),
        faces_(loaded_, lines_, limits.triangulation_work),
        materials_(loaded_, oddities_, limits.records, limits.material_bytes),
        is_last_line_open_(!text.ends_with('\n') && !text.ends_with('\r')) {}

  LoadedMesh parse() {
    if (const std::string format = beginning_format(); !format.empty())
      lines_.fail_at(0, "not an OBJ", "v and f records", format);
    while (lines_.next_joined()) {
      const std::string_view keyword = lines_.word();
      if (keyword.empty() || keyword.starts_with('#')) continue;
      record(lower_case_keyword(keyword));
    }
    check_counts();
    for (std::size_t kind = 0; kind < 3; ++kind) check_highest(kind);
    faces_.finish();
    if (has_zero_normal_) drop_normals_without_length(loaded_.mesh);
    materials_.finish();
    oddities_.append_to(loaded_.warnings, lines_.path());
    measure();
    return std::move(loaded_);
  }

 private:
  static constexpr std::array kind_names{"vertex", "texture coordinate", "normal"};

  void record(std::string_view keyword) {
    auto& mesh = loaded_.mesh;
    if (keyword == "v") {
      const auto [values, count, left_over] = ObjWords(lines_).numbers<7>(3);
      if (count < 3)
        lines_.fail("vertex does not have its coordinates", "v x y z", std::to_string(count) + " numbers");
      append(mesh.positions, {values[0], values[1], values[2]});
      if (count >= 6)
        vertex_colour(values.data() + 3);
      else if (!mesh.vertex_colours.empty())
        mesh.vertex_colours.push_back(geometry::Material{}.colour);
      if (count == 5) oddities_.add("two numbers behind the coordinates of a vertex are ignored", lines_);
      remark_on_left_over(left_over);
    } else if (keyword == "vt") {
      const auto [values, count, left_over] = ObjWords(lines_).numbers<3>(2);
      if (count == 0) lines_.fail("texture coordinate without numbers", "vt u v");
      append(mesh.uvs, {values[0], values[1]});
      remark_on_left_over(left_over);
    } else if (keyword == "vn") {
      normal();
    } else if (keyword == "f") {
      face();
    } else if (keyword == "usemtl") {
      material_ = materials_.index(lines_);
    } else if (keyword == "g" || keyword == "o") {
      group_ = group_index(lines_.rest_of_line());
    } else if (keyword == "mtllib") {
      materials_.read_libraries(lines_);
    } else if (keyword != "s" && keyword != "l" && keyword != "p" && keyword != "vp") {
      oddities_.add("record % is unknown and skipped", lines_, keyword);
    }
  }

  /// Adds a normal, of length 0 if a word is no finite number, as some programs write for faces without area.
  void normal() {
    const auto [values, count, left_over] = ObjWords(lines_).numbers<3>(0);
    if (count < 3 && left_over.empty())
      lines_.fail("normal does not have three numbers", "vn x y z", std::to_string(count));
    const double length = count < 3 ? 0 : hypot(values[0], values[1], values[2]);
    const double scale = length > 0 ? 1 / length : 0;
    append(loaded_.mesh.normals, {values[0] * scale, values[1] * scale, values[2] * scale});
    if (length > 0)
      remark_on_left_over(left_over);
    else
      oddities_.add("normal has no direction; faces with it count as without", lines_);
    has_zero_normal_ = has_zero_normal_ || !(length > 0);
  }

  void remark_on_left_over(std::string_view word) {
    if (!word.empty()) oddities_.add("% and what follows the numbers of a record is ignored", lines_, word);
  }

  /// Sets the colour of the last vertex; earlier vertices without a colour get the colour
  /// of a face without material.
  void vertex_colour(const double* channels) {
    auto& colours = loaded_.mesh.vertex_colours;
    colours.resize(loaded_.mesh.positions.size(), geometry::Material{}.colour);
    for (std::size_t c = 0; c < 3; ++c) {
      colours.back()[c] = static_cast<float>(std::clamp(channels[c], 0.0, 1.0));
    }
    if (std::any_of(channels, channels + 3, [](double channel) { return channel < 0 || channel > 1; }))
      oddities_.add("vertex colour outside 0 to 1 is cut to it", lines_);
  }

  void require_room(std::size_t count) const {
    if (count > limits_.records)
      lines_.fail("mesh is too large", "at most " + std::to_string(limits_.records) + " records of a kind",
                  "more", ErrorKind::limit);
  }

  template <class Element>
  void append(std::vector<Element>& to, const Element& element) {
    require_room(to.size() + 1);
    to.push_back(element);
  }

  /// Zero-based index of a corner's vertex (kind 0), texture coordinate (1) or normal (2).
  std::int32_t index(std::string_view text, std::size_t kind) {
    const std::size_t count = kind == 0   ? loaded_.mesh.positions.size()
                              : kind == 1 ? loaded_.mesh.uvs.size()
                                          : loaded_.mesh.normals.size();
    std::int32_t value = 0;
    const auto expected = [&] {
      return count == 0 ? "1 or more"
                        : "1 to " + std::to_string(count) + " or -" + std::to_string(count) + " to -1";
    };
    const std::string name = kind_names[kind];
    if (!parse_integer(text, value))
      lines_.fail(name + " index is not a whole number", expected(), in_quotes(text));
    if (value == 0) lines_.fail(name + " index 0, though they count from 1", expected(), "0");
    if (value < 0 && kind > 0 && count == 0) {
      if (before_first_[kind] == 0) before_first_[kind] = lines_.number();
      return -1;
    }
    if (value < 0) {
      if (static_cast<std::size_t>(-static_cast<std::int64_t>(value)) > count)
        lines_.fail(name + " index reaches back before the first", expected(), std::to_string(value));
      return static_cast<std::int32_t>(static_cast<std::int64_t>(count) + value);
    }
    if (value > highest_[kind].first) highest_[kind] = {value, lines_.number()};
    return value - 1;
  }

  /// v, v/vt, v//vn or v/vt/vn, also with slashes at the end
  ObjCorner corner(std::string_view word) {
    ObjCorner indices{-1, -1, -1};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const std::size_t slash = word.find('/');
      const std::string_view part = word.substr(0, slash);
      const bool is_left_out = kind > 0 && part.empty();
      if (!is_left_out) indices[kind] = index(part, kind);
      if (slash == std::string_view::npos) return indices;
      word.remove_prefix(slash + 1);
    }
    lines_.fail("face corner has more than three indices", "v/vt/vn");
  }

  void face() {
    corners_.clear();
    ObjWords words(lines_);
    for (std::string_view word = words.next(); !word.empty(); word = words.next())
      corners_.push_back(corner(word));
    if (corners_.size() < 3) {
      short_line_ = lines_.number();
      return oddities_.add("face of fewer than three corners is left out", lines_);
    }
    require_room(loaded_.mesh.faces.size() + corners_.size() - 2);
    for (std::size_t kind = 1; kind < 3; ++kind) {
      const auto lacks = [&](const ObjCorner& corner) { return corner[kind] < 0; };
      if (std::ranges::none_of(corners_, lacks) || std::ranges::all_of(corners_, lacks)) continue;
      for (ObjCorner& corner : corners_) corner[kind] = -1;
      ++mixed_count_[kind];
    }
    faces_.add(corners_, material_, group_);
  }

  std::int32_t group_index(std::string_view name) {
    if (name.empty()) name = "default";
    auto& groups = loaded_.mesh.groups;
    const auto [place, is_new] = group_numbers_.try_emplace(std::string(name), groups.size());
    if (is_new) append(groups, place->first);
    return static_cast<std::int32_t>(place->second);
  }

  [[nodiscard]] std::string beginning_format() const {
    return std::string(
        recognised_format(std::as_bytes(std::span<const char>(beginning_.data(), beginning_.size()))));
  }

  void check_counts() const {
    if (is_last_line_open_ && short_line_ != 0 && short_line_ == lines_.number())
      lines_.fail_at(short_line_, "file ends within a face: too few corners", "3 or more");
    const std::string found = beginning_.empty() ? "0 bytes" : "none";
    if (loaded_.mesh.positions.empty()) lines_.fail_at(0, "OBJ has no vertices", "v records", found);
    if (loaded_.mesh.faces.empty()) lines_.fail_at(0, "OBJ has no faces", "f records", found);
  }

  void check_highest(std::size_t kind) {
    const std::array counts{loaded_.mesh.positions.size(), loaded_.mesh.uvs.size(),
                            loaded_.mesh.normals.size()};
    const auto [value, line] = highest_[kind];
    const std::size_t absent_line = before_first_[kind];
    if (kind > 0 && counts[kind] == 0 && (value > 0 || absent_line > 0)) {
      for (auto& corners : kind == 1 ? loaded_.mesh.face_uvs : loaded_.mesh.face_normals)
        corners = {-1, -1, -1};
      oddities_.add(kind == 1
                        ? "texture coordinates are named, but there are none (vt); faces count as without"
                        : "normals are named, but there are none (vn); faces count as without",
                    absent_line > 0 ? absent_line : line);
    } else if (absent_line > 0) {
      lines_.fail_at(absent_line, std::string(kind_names[kind]) + " index reaches back before the first");
    } else if (static_cast<std::size_t>(value) > counts[kind])
      lines_.fail_at(line, std::string(kind_names[kind]) + " index beyond the last",
                     "1 to " + std::to_string(counts[kind]), std::to_string(value));
  }

  void measure() {
    const double extent = measure_mesh(loaded_);
    if (!(extent >= 1e-9 && extent <= 1e9))
      lines_.fail_at(0, "mesh has no usable size", "an extent of 1e-9 to 1e9 units", std::to_string(extent),
                     ErrorKind::mismatch);
    const auto note = [&](std::size_t count, const std::string& what) {
      if (count > 0) loaded_.warnings.push_back(lines_.path() + ": " + std::to_string(count) + " " + what);
    };
    note(mixed_count_[1], "faces have texture coordinates at some corners only; they count as without");
    note(mixed_count_[2], "faces have normals at some corners only; they count as without");
    note(textured_without_uv_count(loaded_.mesh),
         "faces of a material with a texture (map_Kd) have no texture coordinates (vt); it is not drawn "
         "there");
    note(loaded_.polygon_count, "polygons are split into triangles; face lists count the triangles");
    if (loaded_.crossing_count > 0)
      note(loaded_.crossing_count,
           "polygons cross themselves; they became fans around their first corners, the first on line " +
               std::to_string(faces_.first_crossing()));
    note(loaded_.degenerate_count, "triangles have no area; they keep their number and are never seen");
  }

  TextLines lines_;
  ObjLimits limits_;
  std::string_view beginning_;
  LoadedMesh loaded_;
  LineOddities oddities_;
  std::vector<ObjCorner> corners_;
  std::array<std::pair<std::int32_t, std::size_t>, 3>
      highest_{};  // the largest index of each kind and its line
  std::map<std::string, std::size_t> group_numbers_;
  ObjFaces faces_;
  ObjMaterials materials_;
  std::int32_t material_ = -1;
  std::int32_t group_ = -1;
  std::array<std::size_t, 3> before_first_{};  // line of the first relative index without a target
  std::size_t short_line_ = 0;                 // of the last face of fewer than three corners
  bool is_last_line_open_ = false;
  bool has_zero_normal_ = false;
  std::array<std::size_t, 3> mixed_count_{};  // faces with a kind of index at some corners only
};
}  // namespace detail

LoadedMesh parse_obj(std::string_view text, const std::string& path, const ObjLimits& limits) {
  return detail::ObjParser(text, path, limits).parse();
}

LoadedMesh read_obj(const std::string& path, const ObjLimits& limits) {
  const std::string text = read_text_file(path, limits.file_bytes);
  return parse_obj(text, path, limits);
}
}  // namespace tapestry::io
