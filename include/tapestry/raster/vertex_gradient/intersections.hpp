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
    const std::vector<Plane> planes = make_planes();
    constexpr std::size_t block = 64;
    std::vector<std::vector<VertexShare>> shares(block_count(scene_.field.cell_count(), block));
    parallel_for(shares.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, scene_.field.cell_count(), block);
      std::vector<Plane> own;
      std::vector<std::size_t> others;
      for (std::size_t index_of_cell = begin; index_of_cell < end; ++index_of_cell) {
        const FaceField::Cell cell = scene_.field.cell(index_of_cell);
        own.clear();
        for (const auto* entry = cell.begin; entry < cell.end; ++entry)
          own.push_back(planes[static_cast<std::size_t>(entry->face)]);
        others.resize(own.size());
        add_cell(cell, own, others, shares[index]);
      }
    });
    add_shares(shares, scene_.camera, positions_adjoint);
  }

 private:
  struct Pair {
    std::int32_t i;
    std::int32_t j;
    Affine difference;        // D
    double steepness;         // |∇D|
    std::int32_t hider = -1;  // the face that hid the last point that was hidden
  };

  /// What is asked of a face before it is cut with another one.
  struct Plane {
    std::array<float, 3> low, high;       // its column, row and 1/z, rounded outwards
    geometry::Vector3 n;                  // n·q = 1 for points q of its plane in view space
    std::array<std::int32_t, 3> corners;  // welded

    /// Whether the boxes overlap and no corner is shared. Without branches, which would be guessed wrong.
    [[nodiscard]] int may_cut(const Plane& other) const {
      int result = 1;
      for (std::size_t axis = 0; axis < 3; ++axis)
        result &= int{low[axis] <= other.high[axis]} & int{other.low[axis] <= high[axis]};
      for (const std::int32_t corner : other.corners)
        result &= int{corner != corners[0]} & int{corner != corners[1]} & int{corner != corners[2]};
      return result;
    }
  };

  [[nodiscard]] Plane plane_of(std::int32_t face) const {
    Plane plane{};
    const FaceBox& box = scene_.field.box(face);
    const auto outwards = [](double value, double way) {
      return static_cast<float>(value + way * std::abs(value) * 1e-6);
    };
    for (std::size_t axis = 0; axis < 2; ++axis) {
      plane.low[axis] = outwards(box.low[axis], -1);
      plane.high[axis] = outwards(box.high[axis], 1);
    }
    plane.low[2] = outwards(box.inverse_depth_min, -1);
    plane.high[2] = outwards(box.inverse_depth_max, 1);
    const Affine f = scene_.field.inverse_depth(face);
    const PixelRays& rays = scene_.field.rays();
    plane.n = {f.a / rays.step[0], f.b / rays.step[1], 0};
    plane.n[2] = f.c - plane.n[0] * rays.first[0] - plane.n[1] * rays.first[1];
    for (std::int32_t k = 0; k < 3; ++k)
      plane.corners[static_cast<std::size_t>(k)] =
          scene_.edges.welded[static_cast<std::size_t>(corner_of(scene_.mesh, face, k))];
    return plane;
  }

  [[nodiscard]] std::vector<Plane> make_planes() const {
    std::vector<Plane> planes(scene_.mesh.faces.size());
    constexpr std::size_t block = 4096;
    parallel_for(block_count(planes.size(), block), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, planes.size(), block);
      for (std::size_t face = begin; face < end; ++face)
        if (scene_.field.winding(static_cast<std::int32_t>(face)) != 0)
          planes[face] = plane_of(static_cast<std::int32_t>(face));
    });
    return planes;
  }

  /// Whether all corners of a face lie on one side of a plane, by more than rounding may cause.
  [[nodiscard]] bool is_beside(const Plane& face, const Plane& plane) const {
    bool all_above = true, all_below = true;
    for (const std::int32_t corner : face.corners) {
      const double height =
          geometry::dot(plane.n, scene_.positions_view[static_cast<std::size_t>(corner)]) - 1;
      all_above &= height > 1e-9;
      all_below &= height < -1e-9;
    }
    return all_above || all_below;
  }

  /// \param own     the planes of the cell's faces
  /// \param others  as many
  void add_cell(const FaceField::Cell& cell, const std::vector<Plane>& own, std::vector<std::size_t>& others,
                std::vector<VertexShare>& shares) const {
    for (std::size_t i = 0; i + 1 < own.size(); ++i) {
      std::size_t count = 0;
      for (std::size_t j = i + 1; j < own.size(); ++j) {
        if (cell.begin[j].inverse_depth_max < cell.begin[i].inverse_depth_min) break;
        others[count] = j;
        count += static_cast<std::size_t>(own[i].may_cut(own[j]));
      }
      for (std::size_t k = 0; k < count; ++k) {
        const std::size_t j = others[k];
        if (!is_beside(own[i], own[j]) && !is_beside(own[j], own[i]))
          add_pair(cell, cell.begin[i].face, cell.begin[j].face, shares);
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
    const std::array<double, 2> from = end(range[0]), to = end(range[1]);
    if (is_hidden_by_one(pair, from, to)) return;
    for_each_piece(from, to, scene_.longest_piece, [&](double column, double row, double length) {
      add_piece(pair, column, row, length, shares);
    });
  }

  [[nodiscard]] bool is_hidden(Pair& pair, double column, double row) const {
    const double inverse_depth = scene_.field.inverse_depth(pair.i).at(column, row);
    if (pair.hider >= 0 && scene_.field.hides(pair.hider, column, row, inverse_depth)) return true;
    pair.hider = scene_.field.hider(column, row, inverse_depth,
                                    [&](std::int32_t face) { return face == pair.i || face == pair.j; });
    return pair.hider >= 0;
  }

  /// Whether one face hides the line from end to end.
  [[nodiscard]] bool is_hidden_by_one(Pair& pair, const std::array<double, 2>& from,
                                      const std::array<double, 2>& to) const {
    if (!is_hidden(pair, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2)) return false;
    const Affine inverse_depth = scene_.field.inverse_depth(pair.i);
    return scene_.field.hides(pair.hider, from[0], from[1], inverse_depth.at(from[0], from[1])) &&
           scene_.field.hides(pair.hider, to[0], to[1], inverse_depth.at(to[0], to[1]));
  }

  void add_piece(Pair& pair, double column, double row, double length,
                 std::vector<VertexShare>& shares) const {
    const typename Colour::Colour adjoint = scene_.adjoint_of(column, row);
    if (adjoint == typename Colour::Colour{}) return;
    if (is_hidden(pair, column, row)) return;
    const auto at_i = scene_.colour.at(pair.i, scene_.field.barycentric(pair.i, column, row));
    const auto at_j = scene_.colour.at(pair.j, scene_.field.barycentric(pair.j, column, row));
    double jump = 0;
    for (std::size_t c = 0; c < adjoint.size(); ++c) jump += adjoint[c] * (at_i[c] - at_j[c]);
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
