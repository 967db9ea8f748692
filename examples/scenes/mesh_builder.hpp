#pragma once
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::scenes {
using Point = geometry::Vector3;
using Uv = std::array<double, 2>;
using Colour = std::array<float, 3>;

/// Collects triangles into a mesh; triangles without area are left out.
class MeshBuilder {
 public:
  /// Index of a new material.
  std::int32_t material(const std::string& name, const Colour& colour) {
    mesh_.materials.push_back({name, colour});
    return static_cast<std::int32_t>(mesh_.materials.size()) - 1;
  }

  std::int32_t vertex(const Point& position) {
    mesh_.positions.push_back(position);
    return static_cast<std::int32_t>(mesh_.positions.size()) - 1;
  }

  std::int32_t uv(const Uv& coordinates) {
    mesh_.uvs.push_back(coordinates);
    return static_cast<std::int32_t>(mesh_.uvs.size()) - 1;
  }

  /// \param corners  counter-clockwise seen from outside
  void triangle(const geometry::Corners& corners, std::int32_t material_index,
                const geometry::Corners& uvs = {-1, -1, -1}) {
    const Point& a = position(corners[0]);
    const Point normal = geometry::cross(geometry::subtract(position(corners[1]), a),
                                         geometry::subtract(position(corners[2]), a));
    if (geometry::length(normal) < 1e-7) return;
    mesh_.faces.push_back(corners);
    mesh_.face_uvs.push_back(uvs);
    mesh_.face_normals.push_back({-1, -1, -1});
    mesh_.face_materials.push_back(material_index);
    mesh_.face_groups.push_back(-1);
  }

  /// Two triangles, corners counter-clockwise seen from outside.
  void quad(const std::array<std::int32_t, 4>& corners, std::int32_t material_index,
            const std::array<std::int32_t, 4>& uvs = {-1, -1, -1, -1}) {
    triangle({corners[0], corners[1], corners[2]}, material_index, {uvs[0], uvs[1], uvs[2]});
    triangle({corners[0], corners[2], corners[3]}, material_index, {uvs[0], uvs[2], uvs[3]});
  }

  /// A quad of its own four vertices.
  void quad(const Point& a, const Point& b, const Point& c, const Point& d, std::int32_t material_index) {
    quad({vertex(a), vertex(b), vertex(c), vertex(d)}, material_index);
  }

  /// Axis-aligned box from `low` to `high`; the bottom is left out.
  void box(const Point& low, const Point& high, std::int32_t material_index) {
    std::array<std::int32_t, 8> v{};
    for (std::size_t i = 0; i < 8; ++i)
      v[i] = vertex({(i & 1U) != 0 ? high[0] : low[0], (i & 2U) != 0 ? high[1] : low[1],
                     (i & 4U) != 0 ? high[2] : low[2]});
    quad({v[4], v[5], v[7], v[6]}, material_index);
    quad({v[0], v[1], v[5], v[4]}, material_index);
    quad({v[1], v[3], v[7], v[5]}, material_index);
    quad({v[3], v[2], v[6], v[7]}, material_index);
    quad({v[2], v[0], v[4], v[6]}, material_index);
  }

  [[nodiscard]] const Point& position(std::int32_t index) const {
    return mesh_.positions[static_cast<std::size_t>(index)];
  }

  [[nodiscard]] geometry::Mesh& mesh() { return mesh_; }

 private:
  geometry::Mesh mesh_;
};
}  // namespace tapestry::scenes
