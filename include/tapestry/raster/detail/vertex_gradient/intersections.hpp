#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/detail/crossing_faces.hpp>
#include <tapestry/raster/detail/face_field.hpp>
#include <tapestry/raster/detail/vertex_gradient/edge_line.hpp>
#include <tapestry/raster/detail/vertex_gradient/interior.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster::detail {

/// The same integral over lines where faces cut through each other. Faces i and j change places where D =
/// 1/z_i − 1/z_j, affine in the picture, is 0; i is seen where D > 0. The line moves across itself by
/// −dD/|∇D|, and a displacement d of a face's surface there changes its 1/z by −(n·d)/(n·r)/z².
template <class Colour, class Adjoint>
class Intersections {
 public:
  /// \param scene  must outlive this
  Intersections(const BoundaryScene<Colour, Adjoint>& scene, std::vector<FacePair> pairs)
      : scene_(scene), pairs_(std::move(pairs)), line_counts_(block_count(pairs_.size(), block)) {}

  /// Finds the lines that may be visible, and marks their cells. In each block of pairs, those with a line
  /// move to its front; the lines, seven times as large, are not kept.
  void find(FaceField& field) {
    parallel_for(line_counts_.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, pairs_.size(), block);
      for (std::size_t pair = begin; pair < end; ++pair) {
        Line line;
        if (!cut(pairs_[pair], line)) continue;
        field.mark(line.from, line.to);
        pairs_[begin + line_counts_[index]++] = pairs_[pair];
      }
    });
  }

  /// \pre find(), and the field is filled
  void add_to(std::vector<geometry::Vector3>& positions_adjoint) {
    std::vector<std::vector<VertexShare>> shares(line_counts_.size());
    parallel_for(shares.size(), [&](std::size_t index) {
      for (std::size_t pair = 0; pair < line_counts_[index]; ++pair) {
        Line line;
        if (!cut(pairs_[index * block + pair], line) || is_hidden_by_one(line)) continue;
        for_each_piece(line.from, line.to, scene_.longest_piece,
                       [&](double column, double row, double length) {
                         add_piece(line, column, row, length, shares[index]);
                       });
      }
    });
    add_shares(shares, scene_.camera, positions_adjoint);
  }

 private:
  static constexpr std::size_t block = 512;  // pairs

  struct Line {
    std::int32_t i = -1;
    std::int32_t j = -1;
    double steepness = 0;          // |∇D|
    std::array<double, 2> from{};  // its ends in the picture
    std::array<double, 2> to{};
    std::int32_t hider = -1;  // the face that hid the last point that was hidden
  };

  /// Computes the line of two faces; returns false if they have no line in common in the view.
  [[nodiscard]] bool cut(const FacePair& pair, Line& line) const {
    const FacesInView& faces = scene_.field.faces();
    if (faces.winding(pair.first) * faces.winding(pair.second) == 0) return false;
    const std::array<std::int32_t, 2> both{pair.first, pair.second};
    std::array<FaceWeights, 2> weights;
    std::array<double, 2> low{0, 0}, high = faces.frame().size;
    for (std::size_t side = 0; side < 2; ++side) {
      const auto face = static_cast<std::size_t>(both[side]);
      if (!weights[side].set(scene_.field.rays(), faces.corners(face))) return false;
      for (std::size_t axis = 0; axis < 2; ++axis) {  // a little wider than the boxes, which are rounded
        low[axis] = std::max(low[axis], static_cast<double>(faces.box(face).low[axis]) - 0.01);
        high[axis] = std::min(high[axis], static_cast<double>(faces.box(face).high[axis]) + 0.01);
      }
    }
    if (!(low[0] <= high[0] && low[1] <= high[1])) return false;
    line.i = pair.first;
    line.j = pair.second;
    return cut_to_box(weights, low, high, line);
  }

  [[nodiscard]] bool cut_to_box(const std::array<FaceWeights, 2>& weights, const std::array<double, 2>& low,
                                const std::array<double, 2>& high, Line& line) const {
    const Affine at_i = weights[0].inverse_depth(), at_j = weights[1].inverse_depth();
    const Affine d{at_i.a - at_j.a, at_i.b - at_j.b, at_i.c - at_j.c};
    line.steepness = std::sqrt(d.a * d.a + d.b * d.b);
    // The point of the line nearest to the box's middle, and the way along it.
    const std::array<double, 2> middle{(low[0] + high[0]) / 2, (low[1] + high[1]) / 2};
    if (!(line.steepness > 1e-9 * std::abs(at_i.at(middle[0], middle[1])))) return false;  // coplanar
    const double off = d.at(middle[0], middle[1]) / (line.steepness * line.steepness);
    const std::array<double, 2> point{middle[0] - off * d.a, middle[1] - off * d.b};
    const std::array<double, 2> way{-d.b / line.steepness, d.a / line.steepness};
    std::array<double, 2> range{-1e30, 1e30};
    const auto keep = [&](const Affine& f) {  // where f ≥ 0
      const double value = f.at(point[0], point[1]), slope = f.a * way[0] + f.b * way[1];
      if (slope > 0) range[0] = std::max(range[0], -value / slope);
      if (slope < 0) range[1] = std::min(range[1], -value / slope);
      return (slope != 0 || value >= 0) && range[0] < range[1];
    };
    if (!keep({1, 0, -low[0]}) || !keep({-1, 0, high[0]}) || !keep({0, 1, -low[1]}) ||
        !keep({0, -1, high[1]}))
      return false;
    for (const FaceWeights& face : weights)
      for (const Affine& w : face.w)
        if (!keep(w)) return false;
    const double least = 1 / scene_.camera.far, most = 1 / scene_.camera.near;
    if (!keep({at_i.a, at_i.b, at_i.c - least}) || !keep({-at_i.a, -at_i.b, most - at_i.c})) return false;
    if (range[1] - range[0] < 1e-7) return false;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      line.from[axis] = point[axis] + range[0] * way[axis];
      line.to[axis] = point[axis] + range[1] * way[axis];
    }
    return true;
  }

  [[nodiscard]] bool is_hidden(Line& line, double column, double row) const {
    const double inverse_depth = scene_.field.inverse_depth(line.i).at(column, row);
    if (line.hider >= 0 && scene_.field.hides(line.hider, column, row, inverse_depth)) return true;
    line.hider = scene_.field.hider(column, row, inverse_depth,
                                    [&](std::int32_t face) { return face == line.i || face == line.j; });
    return line.hider >= 0;
  }

  /// Whether one face hides the line from end to end.
  [[nodiscard]] bool is_hidden_by_one(Line& line) const {
    const auto &from = line.from, &to = line.to;
    if (!is_hidden(line, (from[0] + to[0]) / 2, (from[1] + to[1]) / 2)) return false;
    const Affine inverse_depth = scene_.field.inverse_depth(line.i);
    return scene_.field.hides(line.hider, from[0], from[1], inverse_depth.at(from[0], from[1])) &&
           scene_.field.hides(line.hider, to[0], to[1], inverse_depth.at(to[0], to[1]));
  }

  void add_piece(Line& line, double column, double row, double length,
                 std::vector<VertexShare>& shares) const {
    const typename Colour::Colour adjoint = scene_.adjoint_of(column, row);
    if (adjoint == typename Colour::Colour{}) return;
    if (is_hidden(line, column, row)) return;
    const auto at_i = scene_.colour.at(line.i, scene_.field.weights(line.i).barycentric(column, row));
    const auto at_j = scene_.colour.at(line.j, scene_.field.weights(line.j).barycentric(column, row));
    double jump = 0;
    for (std::size_t c = 0; c < adjoint.size(); ++c) jump += adjoint[c] * (at_i[c] - at_j[c]);
    const double weight = jump * length / line.steepness;
    add_face(line.i, weight, column, row, shares);
    add_face(line.j, -weight, column, row, shares);
  }

  /// Adds weight · ∂(1/z)/∂corners.
  void add_face(std::int32_t face, double weight, double column, double row,
                std::vector<VertexShare>& shares) const {
    const auto corners = scene_.field.faces().corners(static_cast<std::size_t>(face));
    const geometry::Vector3 normal = geometry::cross(geometry::subtract(corners[1], corners[0]),
                                                     geometry::subtract(corners[2], corners[0]));
    const double inverse_depth = scene_.field.inverse_depth(face).at(column, row);
    const double scale =
        -weight * inverse_depth * inverse_depth / geometry::dot(normal, scene_.field.rays().at(column, row));
    if (!std::isfinite(scale)) return;
    const auto b = scene_.field.weights(face).barycentric(column, row);
    for (std::int32_t k = 0; k < 3; ++k) {
      shares.push_back(
          {corner_of(scene_.mesh, face, k), geometry::scale(normal, scale * b[static_cast<std::size_t>(k)])});
    }
  }

  const BoundaryScene<Colour, Adjoint>& scene_;
  std::vector<FacePair> pairs_;
  std::vector<std::size_t> line_counts_;  // of each block
};

}  // namespace tapestry::raster::detail
