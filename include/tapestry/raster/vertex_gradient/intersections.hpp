#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/face_field.hpp>
#include <tapestry/raster/vertex_gradient/boundary_scene.hpp>
#include <tapestry/raster/vertex_gradient/shares.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// The same integral over lines where faces cut through each other. Faces i and j change places where
/// D = 1/z_i − 1/z_j, affine in the picture, is 0; i is seen where D > 0. The line moves across itself by
/// −dD/|∇D|, and a displacement d of a face's surface there changes its 1/z by −(n·d)/(n·r)/z².
/// Faces with a common corner meet there, and are taken not to cut each other elsewhere.
template <class Colour, class Adjoint>
class Intersections {
 public:
  explicit Intersections(const BoundaryScene<Colour, Adjoint>& scene) : scene_(scene) {}

  void add_to(std::vector<geometry::Vector3>& positions_adjoint) const {
    constexpr std::size_t block = 64;
    std::vector<std::vector<VertexShare>> shares(block_count(scene_.field.cell_count(), block));
    parallel_for(shares.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, scene_.field.cell_count(), block);
      std::vector<Plane> planes;
      for (std::size_t cell = begin; cell < end; ++cell)
        add_cell(scene_.field.cell(cell), planes, shares[index]);
    });
    add_shares(shares, scene_.camera, positions_adjoint);
  }

 private:
  struct Pair {
    std::int32_t i;
    std::int32_t j;
    Affine difference;  // D
    double steepness;   // |∇D|
  };

  /// 1/z of a face's plane: at the cell's middle, and how far it goes up and down within the cell.
  struct Plane {
    double middle, a, b;
    std::int32_t face;
    std::array<std::int32_t, 3> corners;
    [[nodiscard]] bool meets(const Plane& other) const {
      bool found = false;
      for (const std::int32_t corner : other.corners)
        found = found || corner == corners[0] || corner == corners[1] || corner == corners[2];
      return found;
    }
  };

  [[nodiscard]] std::array<std::int32_t, 3> welded_corners(std::int32_t face) const {
    std::array<std::int32_t, 3> corners{};
    for (std::int32_t k = 0; k < 3; ++k)
      corners[static_cast<std::size_t>(k)] =
          scene_.edges.welded[static_cast<std::size_t>(corner_of(scene_.mesh, face, k))];
    return corners;
  }

  void add_cell(const FaceField::Cell& cell, std::vector<Plane>& planes,
                std::vector<VertexShare>& shares) const {
    const double column = (cell.low[0] + cell.high[0]) / 2, row = (cell.low[1] + cell.high[1]) / 2;
    const double half = (cell.high[0] - cell.low[0]) / 2;
    planes.clear();
    for (const auto* entry = cell.begin; entry < cell.end; ++entry) {
      const Affine f = scene_.field.inverse_depth(entry->face);
      planes.push_back({f.at(column, row), f.a * half, f.b * half, entry->face, welded_corners(entry->face)});
    }
    for (std::size_t i = 0; i + 1 < planes.size(); ++i) {
      const Plane& first = planes[i];
      const double lowest = first.middle - std::abs(first.a) - std::abs(first.b);
      for (std::size_t j = i + 1; j < planes.size(); ++j) {
        const Plane& second = planes[j];
        if (cell.begin[j].inverse_depth_max < lowest) break;
        const double reach = std::abs(first.a - second.a) + std::abs(first.b - second.b);
        if (std::abs(first.middle - second.middle) > reach || first.meets(second)) continue;
        add_pair(cell, first.face, second.face, shares);
      }
    }
  }

  void add_pair(const FaceField::Cell& cell, std::int32_t i, std::int32_t j,
                std::vector<VertexShare>& shares) const {
    const Affine at_i = scene_.field.inverse_depth(i), at_j = scene_.field.inverse_depth(j);
    Pair pair{i, j, {at_i.a - at_j.a, at_i.b - at_j.b, at_i.c - at_j.c}, 0};
    const Affine& d = pair.difference;
    pair.steepness = std::sqrt(d.a * d.a + d.b * d.b);
    const double size = std::abs(at_i.at(cell.low[0], cell.low[1]));
    if (!(pair.steepness > 1e-9 * size)) return;  // as good as coplanar
    // The point of the line nearest to the cell's middle, and the way along it.
    const std::array<double, 2> middle{(cell.low[0] + cell.high[0]) / 2, (cell.low[1] + cell.high[1]) / 2};
    const double off = d.at(middle[0], middle[1]) / (pair.steepness * pair.steepness);
    const std::array<double, 2> point{middle[0] - off * d.a, middle[1] - off * d.b};
    const std::array<double, 2> way{-d.b / pair.steepness, d.a / pair.steepness};
    std::array<double, 2> range{-1e30, 1e30};
    const auto keep = [&](const Affine& f) {  // where f ≥ 0
      const double value = f.at(point[0], point[1]), slope = f.a * way[0] + f.b * way[1];
      if (slope > 0) range[0] = std::max(range[0], -value / slope);
      if (slope < 0) range[1] = std::min(range[1], -value / slope);
      return (slope != 0 || value >= 0) && range[0] < range[1];
    };
    if (!keep({1, 0, -cell.low[0]}) || !keep({-1, 0, cell.high[0]}) || !keep({0, 1, -cell.low[1]}) ||
        !keep({0, -1, cell.high[1]}))
      return;
    for (const std::int32_t face : {i, j})
      for (const Affine& w : scene_.field.weights(face))
        if (!keep(w)) return;
    if (range[1] - range[0] < 1e-7) return;
    const auto end = [&](double t) {
      return std::array<double, 2>{point[0] + t * way[0], point[1] + t * way[1]};
    };
    for_each_piece(
        end(range[0]), end(range[1]), scene_.longest_piece,
        [&](double column, double row, double length) { add_piece(pair, column, row, length, shares); });
  }

  void add_piece(const Pair& pair, double column, double row, double length,
                 std::vector<VertexShare>& shares) const {
    const std::array<double, 3> adjoint = scene_.adjoint_of(column, row);
    if (adjoint[0] == 0 && adjoint[1] == 0 && adjoint[2] == 0) return;
    const double depth = scene_.field.inverse_depth(pair.i).at(column, row) * (1 + 1e-9);
    if (scene_.field
            .nearest(column, row, depth, [&](std::int32_t face) { return face == pair.i || face == pair.j; })
            .face >= 0)
      return;  // hidden
    const auto at_i = scene_.colour.at(pair.i, scene_.field.barycentric(pair.i, column, row));
    const auto at_j = scene_.colour.at(pair.j, scene_.field.barycentric(pair.j, column, row));
    double jump = 0;
    for (std::size_t c = 0; c < 3; ++c) jump += adjoint[c] * (at_i[c] - at_j[c]);
    const double weight = jump * length / pair.steepness;
    add_face(pair.i, weight, column, row, shares);
    add_face(pair.j, -weight, column, row, shares);
  }

  /// Adds weight · ∂(1/z)/∂corners.
  void add_face(std::int32_t face, double weight, double column, double row,
                std::vector<VertexShare>& shares) const {
    const auto corners = corners_in_view(scene_.mesh, scene_.positions_view, face);
    const geometry::Vector3 normal = geometry::cross(geometry::subtract(corners[1], corners[0]),
                                                     geometry::subtract(corners[2], corners[0]));
    const double inverse_depth = scene_.field.inverse_depth(face).at(column, row);
    const double scale =
        -weight * inverse_depth * inverse_depth / geometry::dot(normal, scene_.field.rays().at(column, row));
    if (!std::isfinite(scale)) return;
    const auto b = scene_.field.barycentric(face, column, row);
    for (std::int32_t k = 0; k < 3; ++k) {
      shares.push_back(
          {corner_of(scene_.mesh, face, k), geometry::scale(normal, scale * b[static_cast<std::size_t>(k)])});
    }
  }

  const BoundaryScene<Colour, Adjoint>& scene_;
};

}  // namespace tapestry::raster::detail
