#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/geometry/polygon_triangulator.hpp>
#include <tapestry/io/loaded_mesh.hpp>
#include <tapestry/io/text_lines.hpp>
#include <vector>

namespace tapestry::io::detail {

/// Indices of a face's corner: vertex, texture coordinate and normal, -1 for none.
using ObjCorner = std::array<std::int32_t, 3>;

/// Puts the faces of an OBJ into its mesh as triangles, two fewer than their corners and in their place.
class ObjFaces {
 public:
  /// \param work  of geometry::PolygonTriangulator
  ObjFaces(LoadedMesh& loaded, const TextLines& lines, std::uint64_t work)
      : loaded_(loaded), lines_(lines), triangulator_(work) {}

  /// Adds the face of the present line, of three corners or more.
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

  /// Cuts the polygons that came before their vertices, which are all there now.
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

  /// Line of the first polygon that crosses itself; 0 without one.
  [[nodiscard]] std::size_t first_crossing() const { return first_crossing_; }

 private:
  /// A polygon of which the mesh holds the fan around its first corner.
  struct Polygon {
    std::size_t first;  // of its triangles
    std::size_t corner_count;
    std::size_t line;
  };

  void write_triangle(std::size_t face, const ObjCorner& a, const ObjCorner& b, const ObjCorner& c) {
    auto& mesh = loaded_.mesh;
    mesh.faces[face] = {a[0], b[0], c[0]};
    mesh.face_uvs[face] = {a[1], b[1], c[1]};
    mesh.face_normals[face] = {a[2], b[2], c[2]};
  }

  /// Cuts into other triangles what is no fan.
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
