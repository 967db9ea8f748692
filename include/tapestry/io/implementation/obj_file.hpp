#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/name_numbers.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/io/obj_file/parsing.hpp>
#include <tapestry/io/text_lines.hpp>
#include <utility>
#include <vector>

namespace tapestry::io::detail {

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& path, const ObjLimits& limits)
      : lines_(text, path, limits.line_bytes),
        limits_(limits),
        beginning_(text.substr(0, 64)),
        faces_(loaded_, lines_, limits.triangulation_work),
        materials_(loaded_, limits.records, limits.material_bytes) {}

  LoadedMesh parse() {
    if (const std::string format = beginning_format(); !format.empty())
      lines_.fail_at(0, "not an OBJ", "v and f records", format);
    while (lines_.next_joined()) {
      const std::string_view keyword = lines_.word();
      if (keyword.empty() || keyword.starts_with('#')) continue;
      record(keyword);
    }
    check_counts();
    for (std::size_t kind = 0; kind < 3; ++kind) check_highest(kind);
    faces_.finish();
    measure();
    return std::move(loaded_);
  }

 private:
  static constexpr std::array kind_names{"vertex", "texture coordinate", "normal"};

  void record(std::string_view keyword) {
    auto& mesh = loaded_.mesh;
    if (keyword == "v") {
      const auto [values, count] = numbers<7>();
      if (count != 3 && count != 4 && count != 6 && count != 7)
        lines_.fail("vertex does not have its coordinates", "v x y z", std::to_string(count) + " numbers");
      append(mesh.positions, {values[0], values[1], values[2]});
      if (count >= 6)
        vertex_colour(values.data() + count - 3);
      else if (!mesh.vertex_colours.empty())
        mesh.vertex_colours.push_back(geometry::Material{}.colour);
    } else if (keyword == "vt") {
      const auto [values, count] = numbers<3>();
      if (count == 0) lines_.fail("texture coordinate without numbers", "vt u v");
      append(mesh.uvs, {values[0], values[1]});
    } else if (keyword == "vn") {
      const auto [values, count] = numbers<3>();
      if (count != 3) lines_.fail("normal does not have three numbers", "vn x y z", std::to_string(count));
      const double length = std::hypot(values[0], values[1], values[2]);
      const double scale = length > 0 ? 1 / length : 0;
      append(mesh.normals, {values[0] * scale, values[1] * scale, values[2] * scale});
    } else if (keyword == "f") {
      face();
    } else if (keyword == "usemtl") {
      material_ = materials_.index(lines_);
    } else if (keyword == "g" || keyword == "o") {
      group_ = group_index(lines_.rest_of_line());
    } else if (keyword == "mtllib") {
      materials_.read_libraries(lines_);
    } else if (keyword != "s" && keyword != "l" && keyword != "p" && keyword != "vp") {
      if (unknown_count_++ == 0)
        lines_.warn(loaded_.warnings, "record " + in_quotes(keyword) + " is unknown and skipped");
    }
  }

  /// Sets the colour of the last vertex; earlier vertices without a colour get that of a face without
  /// material.
  void vertex_colour(const double* channels) {
    auto& colours = loaded_.mesh.vertex_colours;
    colours.resize(loaded_.mesh.positions.size(), geometry::Material{}.colour);
    for (std::size_t c = 0; c < 3; ++c) {
      colours.back()[c] = static_cast<float>(std::clamp(channels[c], 0.0, 1.0));
      if (channels[c] < 0 || channels[c] > 1) has_wide_colour_ = true;
    }
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

  template <std::size_t Most>
  std::pair<std::array<double, Most>, std::size_t> numbers() {
    std::array<double, Most> values{};
    std::size_t count = 0;
    for (std::string_view word = lines_.word(); !word.empty() && word[0] != '#';
         word = lines_.word(), ++count) {
      if (count == Most) lines_.fail("too many numbers", "at most " + std::to_string(Most), "more");
      if (!parse_number(word, values[count]) ||
          !(std::abs(values[count]) <= static_cast<double>(std::numeric_limits<float>::max())))
        lines_.fail("not a finite number", "a number of single precision", in_quotes(word));
    }
    return {values, count};
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
    if (value < 0) {
      if (static_cast<std::size_t>(-static_cast<std::int64_t>(value)) > count)
        lines_.fail(name + " index reaches back before the first", expected(), std::to_string(value));
      return static_cast<std::int32_t>(static_cast<std::int64_t>(count) + value);
    }
    if (value > highest_[kind].first) highest_[kind] = {value, lines_.number()};
    return value - 1;
  }

  /// v, v/vt, v//vn or v/vt/vn
  ObjCorner corner(std::string_view word) {
    ObjCorner indices{-1, -1, -1};
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const std::size_t slash = word.find('/');
      const std::string_view part = word.substr(0, slash);
      const bool left_out = kind == 1 && part.empty() && slash != std::string_view::npos;
      if (!left_out) indices[kind] = index(part, kind);
      if (slash == std::string_view::npos) return indices;
      word.remove_prefix(slash + 1);
    }
    lines_.fail("face corner has more than three indices", "v/vt/vn");
  }

  void face() {
    corners_.clear();
    for (std::string_view word = lines_.word(); !word.empty() && word[0] != '#'; word = lines_.word()) {
      corners_.push_back(corner(word));
    }
    if (corners_.size() < 3)
      lines_.fail("face has too few corners", "3 or more", std::to_string(corners_.size()));
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
    const std::size_t index =
        group_numbers_.add(name, [&](std::size_t i) -> std::string_view { return groups[i]; });
    if (index == groups.size()) append(groups, std::string(name));
    return static_cast<std::int32_t>(index);
  }

  [[nodiscard]] std::string beginning_format() const {
    return std::string(
        recognised_format(std::as_bytes(std::span<const char>(beginning_.data(), beginning_.size()))));
  }

  void check_counts() const {
    const std::string found = beginning_.empty() ? "0 bytes" : "none";
    if (loaded_.mesh.positions.empty()) lines_.fail_at(0, "OBJ has no vertices", "v records", found);
    if (loaded_.mesh.faces.empty()) lines_.fail_at(0, "OBJ has no faces", "f records", found);
  }

  void check_highest(std::size_t kind) {
    const std::array counts{loaded_.mesh.positions.size(), loaded_.mesh.uvs.size(),
                            loaded_.mesh.normals.size()};
    const auto [value, line] = highest_[kind];
    constexpr std::size_t normal = 2;  // some programs write normal indices but no normals
    if (kind == normal && counts[normal] == 0 && value > 0) {
      for (auto& corners : loaded_.mesh.face_normals) corners = {-1, -1, -1};
      loaded_.warnings.push_back(lines_.path() + ":" + std::to_string(line) +
                                 ": normals are named, but there are none (vn); faces count as without");
    } else if (counts[kind] == 0 && value > 0) {
      lines_.fail_at(line, std::string(kind_names[kind]) + " index, but the file has none", "no index",
                     std::to_string(value));
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
    note(has_wide_colour_ ? 1 : 0, "or more vertex colours outside 0 to 1 are cut to it");
    note(loaded_.polygon_count, "polygons are split into triangles; face lists count the triangles");
    if (loaded_.crossing_count > 0)
      note(loaded_.crossing_count,
           "polygons cross themselves; they became fans around their first corners, the first on line " +
               std::to_string(faces_.first_crossing()));
    note(loaded_.degenerate_count, "triangles have no area; they keep their number and are never seen");
    note(unknown_count_ > 1 ? unknown_count_ : 0, "records are unknown and skipped");
  }

  TextLines lines_;
  ObjLimits limits_;
  std::string_view beginning_;
  LoadedMesh loaded_;
  std::vector<ObjCorner> corners_;
  std::array<std::pair<std::int32_t, std::size_t>, 3>
      highest_{};  // the largest index of each kind and its line
  NameNumbers group_numbers_;
  ObjFaces faces_;
  ObjMaterials materials_;
  std::int32_t material_ = -1;
  std::int32_t group_ = -1;
  std::size_t unknown_count_ = 0;
  std::array<std::size_t, 3> mixed_count_{};  // faces with a kind of index at some corners only
  bool has_wide_colour_ = false;
};

}  // namespace tapestry::io::detail

namespace tapestry::io {

LoadedMesh parse_obj(std::string_view text, const std::string& path, const ObjLimits& limits) {
  return detail::ObjParser(text, path, limits).parse();
}

LoadedMesh read_obj(const std::string& path, const ObjLimits& limits) {
  const std::string text = read_text_file(path, limits.file_bytes);
  return parse_obj(text, path, limits);
}

}  // namespace tapestry::io
