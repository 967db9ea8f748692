#pragma once
#include <tapestry/raster/detail/vertex_gradient/edge_line.hpp>
#include <tapestry/raster/detail/vertex_gradient/interior.hpp>

namespace tapestry::raster::detail {
/// The same integral over lines where faces cut through each other. Faces i and j change places where D =
/// 1/z_i − 1/z_j, affine in the picture, is 0; i is seen where D > 0. The line moves across itself by
/// −dD/|∇D|, and a displacement d of a face's surface there changes its 1/z by −(n·d)/(n·r)/z².
template <class Colour, class Adjoint>
class Intersections {
 public:
  /// \param scene  must outlive this
  Intersections(const BoundaryScene<Colour, Adjoint>& scene, std::vector<FacePair> pairs)
      : scene_(scene), pairs_(std::move(pairs)) {}

  /// Finds the lines that may be visible, and marks them.
  void find(FaceField& field) {
    constexpr std::size_t block = 512;
    std::vector<std::vector<Line>> found(block_count(pairs_.size(), block));
    parallel_for(found.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, pairs_.size(), block);
      Line line;
      for (std::size_t pair = begin; pair < end; ++pair)
        if (cut(pairs_[pair], line)) found[index].push_back(line);
    });
    pairs_ = {};
    for (const auto& block_lines : found)
      for (const Line& line : block_lines) {
        lines_.push_back(line);
        lines_.back().marked = field.mark(line.from, line.to);
      }
  }

  /// \pre find(), and the field is filled
  void add_to(std::vector<geometry::Vector3>& positions_adjoint) {
    constexpr std::size_t block = 64;
    std::vector<std::vector<VertexShare>> shares(block_count(lines_.size(), block));
    parallel_for(shares.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, lines_.size(), block);
      for (std::size_t i = begin; i < end; ++i) {
        Line& line = lines_[i];
        if (is_hidden_by_one(line)) continue;
        std::array<Moving, 2> sides{moving(line.i), moving(line.j)};
        for_each_piece(
            line.from, line.to, scene_.longest_piece,
            [&](double column, double row, double length) { add_piece(line, column, row, length, sides); });
        for (const Moving& face : sides) add_face(face, shares[index]);
      }
    });
    add_shares(shares, scene_.camera, positions_adjoint);
  }

 private:
  struct Line {
    std::int32_t i = -1;
    std::int32_t j = -1;
    double steepness = 0;          // |∇D|
    std::array<double, 2> from{};  // its ends in the picture
    std::array<double, 2> to{};
    std::size_t marked = 0;   // of the field
    std::int32_t hider = -1;  // the face that hid the last hidden point
  };

  /// A face of a line, and the derivatives with respect to its corners along its normal.
  struct Moving {
    std::int32_t face;
    geometry::Vector3 normal;
    std::array<double, 3> along{};
  };

  [[nodiscard]] Moving moving(std::int32_t face) const {
    const auto corners = scene_.field.faces().corners(static_cast<std::size_t>(face));
    return {face, geometry::cross(geometry::subtract(corners[1], corners[0]),
                                  geometry::subtract(corners[2], corners[0]))};
  }

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
    // The point of the line nearest to the box's middle, and the direction along it.
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
    const double place = distance(line.from, {column, row});
    const std::size_t first = scene_.field.first_segment(line.marked);
    line.hider =
        scene_.field.hider(scene_.field.segment_at(line.marked, first, place), column, row, inverse_depth,
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

  void add_piece(Line& line, double column, double row, double length, std::array<Moving, 2>& sides) const {
    const typename Colour::Colour adjoint = scene_.adjoint_of(column, row);
    if (adjoint == typename Colour::Colour{}) return;
    if (is_hidden(line, column, row)) return;
    std::array<std::array<double, 3>, 2> b;
    for (std::size_t side = 0; side < 2; ++side)
      b[side] = scene_.field.weights(sides[side].face).barycentric(column, row);
    const auto at_i = scene_.colour.at(line.i, b[0]), at_j = scene_.colour.at(line.j, b[1]);
    double jump = 0;
    for (std::size_t c = 0; c < adjoint.size(); ++c) jump += adjoint[c] * (at_i[c] - at_j[c]);
    const double weight = jump * length / line.steepness;
    for (std::size_t side = 0; side < 2; ++side)
      add_motion(sides[side], side == 0 ? weight : -weight, column, row, b[side]);
  }

  /// Adds weight · ∂(1/z)/∂corners.
  void add_motion(Moving& side, double weight, double column, double row,
                  const std::array<double, 3>& b) const {
    const double inverse_depth = scene_.field.inverse_depth(side.face).at(column, row);
    const double scale = -weight * inverse_depth * inverse_depth /
                         geometry::dot(side.normal, scene_.field.rays().at(column, row));
    if (!std::isfinite(scale)) return;
    for (std::size_t k = 0; k < 3; ++k) side.along[k] += scale * b[k];
  }

  void add_face(const Moving& side, std::vector<VertexShare>& shares) const {
    if (side.along == std::array<double, 3>{}) return;
    for (std::int32_t k = 0; k < 3; ++k)
      shares.push_back({corner_of(scene_.mesh, side.face, k),
                        geometry::scale(side.normal, side.along[static_cast<std::size_t>(k)])});
  }

  const BoundaryScene<Colour, Adjoint>& scene_;
  std::vector<FacePair> pairs_;
  std::vector<Line> lines_;
};
}  // namespace tapestry::raster::detail
