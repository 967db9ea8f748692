#pragma once
#include <tapestry/raster/detail/vertex_gradient/edge_line.hpp>
#include <tapestry/raster/detail/vertex_gradient/interior.hpp>

namespace tapestry::raster::detail {
/// The integral over all visible parts of the mesh's edges of
///   (colour on one side − colour on the other) · (motion of the edge across itself).
/// Each edge is cut at the borders of pixels and into pieces of at most 1/samples of a pixel; each piece
/// counts by its middle. Rays just beside an edge find the face on either side. Borders, seams, repeated
/// faces and surfaces that meet in one edge therefore need no special rules: if both sides have the same
/// colour, there is no edge. An edge through q_a and q_b appears where m·r = 0, m = q_a × q_b. It moves
/// across itself by −(dm·r)/|∂(m·r)/∂(column, row)|, which holds for ends behind the camera, too.
template <class Colour, class Adjoint>
class Outlines {
 public:
  explicit Outlines(const BoundaryScene<Colour, Adjoint>& scene) : scene_(scene) {}

  /// Finds the edges that may be visible, and marks them.
  void find(FaceField& field) {
    constexpr std::size_t block = 2048;
    const std::size_t count = scene_.edges.size();
    const bool is_continuous = scene_.colour.is_continuous();
    found_.resize(block_count(count, block));
    parallel_for(found_.size(), [&](std::size_t index) {
      const auto [begin, end] = block_range(index, count, block);
      for (std::size_t edge = begin; edge < end; ++edge) {
        EdgeLine line;
        if (!may_show(edge, is_continuous) || !cut(edge, line)) continue;
        hide_by_seen(line);
        if (line.hidden_to > line.length) continue;
        found_[index].push_back(
            {static_cast<std::uint32_t>(edge), line.hidden_to, line.at(line.hidden_to), line.to});
      }
    });
    first_line_ = field.mark_count();
    for (const auto& found : found_)
      for (const Found& line : found) field.mark(line.from, line.to);
  }

  /// \pre find(), and the field is filled
  void add_to(std::vector<geometry::Vector3>& positions_adjoint) const {
    constexpr std::size_t block = 64;
    std::vector<Found> lines;
    for (const auto& found : found_) lines.insert(lines.end(), found.begin(), found.end());
    std::vector<std::vector<VertexShare>> shares(block_count(lines.size(), block));
    parallel_for(shares.size(), [&](std::size_t index) {
      Workspace work;
      const auto [begin, end] = block_range(index, lines.size(), block);
      for (std::size_t i = begin; i < end; ++i) {
        work.line = first_line_ + i;
        add_edge(lines[i], work, shares[index]);
      }
    });
    add_shares(shares, scene_.camera, positions_adjoint);
  }

 private:
  static constexpr double beside = 1e-5;  // px; distance from an edge to test its two sides

  /// The face that a ray beside an edge meets.
  struct Side {
    std::int32_t face = -1;
    std::int32_t half_edge = -1;  // index into `own` if the face has the edge
  };

  /// Derivatives of a half-edge with respect to its two ends, in the order of the line's.
  using EndsAdjoint = std::array<geometry::Vector3, 2>;

  /// A face that has the edge.
  struct OwnFace {
    Affine inverse_depth{};
    std::array<bool, 2> is_on_side{};  ///< on the side m·r < 0, and on the side m·r > 0
    EndsAdjoint sum{};
  };

  using Values = typename Colour::Colour;

  /// Memory for one edge at a time. Its pieces in one segment wait and are looked up together.
  struct Workspace {
    std::vector<OwnFace> own;
    std::size_t line;     // of the field
    std::size_t segment;  // of the waiting pieces
    double begin;         // place of the line's first end
    LinePoints points;    // middles of pieces
    std::array<double, LinePoints::most> length;
    std::array<Values, LinePoints::most> adjoint;
    std::array<std::array<Side, 2>, LinePoints::most> own_sides;
    std::vector<LineFace> near;
  };

  struct Found {
    std::uint32_t edge;
    double hidden_to;  // see EdgeLine
    std::array<double, 2> from, to;
  };

  [[nodiscard]] const geometry::Vector3& position(std::int32_t vertex) const {
    return scene_.positions_view[static_cast<std::size_t>(vertex)];
  }

  /// Whether an edge may separate two colours: not if none of its faces is drawn, or if it lies between two
  /// faces that continue each other. For most edges the faces' windings alone decide it.
  [[nodiscard]] bool may_show(std::size_t edge, bool is_continuous) const {
    const auto own = scene_.edges.of(edge);
    const FacesInView& faces = scene_.field.faces();
    const int way = scene_.edges.way[edge];
    if (way == 0)
      return std::any_of(own.begin(), own.end(),
                         [&](const HalfEdge& half) { return faces.winding(half.face) != 0; });
    const int first = faces.winding(own[0].face), second = faces.winding(own[1].face);
    if (first * second == 0) return first != second;
    if (first * second != (way > 0 ? 1 : -1)) return true;
    const bool is_seam = way > 1 || way < -1;
    return !((is_continuous && !is_seam) || scene_.colour.agrees(own[0], own[1]));
  }

  /// Cuts the line of an edge to the view; returns false if nothing of it shows.
  [[nodiscard]] bool cut(std::size_t edge, EdgeLine& line) const {
    line.own = scene_.edges.of(edge);
    const HalfEdge& first = line.own[0];
    return line.set(position(corner_of(scene_.mesh, first.face, first.corner)),
                    position(corner_of(scene_.mesh, first.face, first.corner + 1)), scene_.camera,
                    scene_.field.rays());
  }

  /// Follows a line from its first end, as long as faces that samples see hide it: most edges of most meshes
  /// are hidden from end to end.
  void hide_by_seen(EdgeLine& line) const {
    constexpr double beyond = 1e-7;  // px beyond the border of a hiding face
    constexpr int most = 8;          // faces
    for (int i = 0; i < most && line.hidden_to <= line.length; ++i) {
      const auto [column, row] = line.at(line.hidden_to + beyond);
      const std::int32_t hider = scene_.field.seen_hider(column, row, line.inverse_depth.at(column, row),
                                                         [&](std::int32_t face) { return line.has(face); });
      if (hider < 0) return;
      hide(line, hider, column, row);
    }
  }

  void add_edge(const Found& found, Workspace& work, std::vector<VertexShare>& shares) const {
    EdgeLine line;
    if (!cut(found.edge, line)) return;
    line.hidden_to = found.hidden_to;
    work.begin = line.hidden_to;
    work.segment = scene_.field.first_segment(work.line);
    std::vector<OwnFace>& own = work.own;
    own.clear();
    for (const HalfEdge& half : line.own) {
      const double side = geometry::dot(line.m, position(corner_of(scene_.mesh, half.face, half.corner + 2)));
      own.push_back({scene_.field.inverse_depth(half.face), {side<0, side> 0}});
    }
    for_each_piece(line.from, line.to, scene_.longest_piece,
                   [&](double x, double y, double piece) { add_piece(line, x, y, piece, work); });
    add_waiting(line, work);
    for (std::size_t i = 0; i < own.size(); ++i) add_half_edge(line, i, own[i].sum, shares);
  }

  /// Stores how far along the edge the face that hides it here continues to hide it.
  void hide(EdgeLine& line, std::int32_t hider, double column, double row) const {
    line.hidden_to =
        line.place_of(column, row) + scene_.field.weights(hider).hidden_length(
                                         column, row, line.way, line.inverse_depth, scene_.field.limits());
  }

  void add_half_edge(const EdgeLine& line, std::size_t i, const EndsAdjoint& sum,
                     std::vector<VertexShare>& shares) const {
    if (geometry::dot(sum[0], sum[0]) + geometry::dot(sum[1], sum[1]) == 0) return;
    const HalfEdge& half = line.own[i];
    const std::int32_t from = corner_of(scene_.mesh, half.face, half.corner);
    const std::int32_t to = corner_of(scene_.mesh, half.face, half.corner + 1);
    const bool runs_alike =
        scene_.edges.welded[static_cast<std::size_t>(from)] ==
        scene_.edges
            .welded[static_cast<std::size_t>(corner_of(scene_.mesh, line.own[0].face, line.own[0].corner))];
    shares.push_back({runs_alike ? from : to, sum[0]});
    shares.push_back({runs_alike ? to : from, sum[1]});
  }

  void add_piece(EdgeLine& line, double column, double row, double length, Workspace& work) const {
    LinePoints& points = work.points;
    const double place = line.place_of(column, row);
    if (place < line.hidden_to) return;
    const Values adjoint = scene_.adjoint_of(column, row);
    if (adjoint == Values{}) return;
    const std::size_t segment = scene_.field.segment_at(work.line, work.segment, place - work.begin);
    if (points.size == LinePoints::most || segment != work.segment) {
      add_waiting(line, work);
      work.segment = segment;
      if (place < line.hidden_to) return;
    }
    const std::size_t i = points.size++;
    points.column[i] = column;
    points.row[i] = row;
    work.length[i] = length;
    work.adjoint[i] = adjoint;
  }

  void add_waiting(EdgeLine& line, Workspace& work) const {
    LinePoints& points = work.points;
    if (points.size == 0) return;
    const std::array<double, 2> step{beside * line.normal[0], beside * line.normal[1]};
    for (std::size_t i = 0; i < points.size; ++i) {
      const std::array<double, 2> point{points.column[i], points.row[i]};
      points.hidden_from[i] = FaceField::hidden_from(line.inverse_depth.at(point[0], point[1]));
      work.own_sides[i] = {};
      const auto known = own_sides(line, work.own, point, step, work.own_sides[i]);
      for (std::size_t side = 0; side < 2; ++side) points.inverse_depth[side][i] = known[side];
    }
    scene_.field.look(work.segment, step, line.own, points, work.near);
    for (std::size_t i = 0; i < points.size; ++i)
      if (points.hider[i] < 0) add_point(line, i, work);
    const std::size_t last = points.size - 1;
    if (points.hider[last] >= 0)
      hide(line, static_cast<std::int32_t>(points.hider[last]), points.column[last], points.row[last]);
    points.size = 0;
  }

  /// Adds a piece that no face hides.
  void add_point(const EdgeLine& line, std::size_t i, Workspace& work) const {
    const double column = work.points.column[i], row = work.points.row[i];
    std::array<Side, 2> sides = work.own_sides[i];
    for (std::size_t side = 0; side < 2; ++side)
      if (const auto face = static_cast<std::int32_t>(work.points.face[side][i]); face >= 0)
        sides[side] = {face, -1};
    const auto& [low, high] = sides;
    if (low.half_edge < 0 && high.half_edge < 0) return;  // hidden
    double jump = 0;
    const auto at = [&](const Side& shown) {
      return shown.face < 0
                 ? Values{}
                 : scene_.colour.at(shown.face, scene_.field.weights(shown.face).barycentric(column, row));
    };
    const Values low_colour = at(low), high_colour = at(high);
    const Values& adjoint = work.adjoint[i];
    for (std::size_t c = 0; c < adjoint.size(); ++c) jump += adjoint[c] * (low_colour[c] - high_colour[c]);
    const bool is_shared = low.half_edge >= 0 && high.half_edge >= 0;
    const double part = is_shared || is_continued(line, low, high, column, row) ? 0.5 : 1;
    const double weight = -part * jump * work.length[i] / line.steepness;
    const geometry::Vector3 ray = scene_.field.rays().at(column, row);
    const auto at_a = geometry::scale(geometry::cross(line.b, ray), weight);
    const auto at_b = geometry::scale(geometry::cross(ray, line.a), weight);
    for (const Side* shown : {&low, &high}) {
      if (shown->half_edge < 0) continue;
      auto& sum = work.own[static_cast<std::size_t>(shown->half_edge)].sum;
      sum = {geometry::add(sum[0], at_a), geometry::add(sum[1], at_b)};
    }
  }

  /// Stores the nearest of the edge's own faces at point − step, where m·r < 0, and at point + step; returns
  /// their 1/z. They reach up to the edge on the side of their third corner, even where rounding denies it.
  [[nodiscard]] std::array<double, 2> own_sides(const EdgeLine& line, const std::vector<OwnFace>& own,
                                                const std::array<double, 2>& point,
                                                const std::array<double, 2>& step,
                                                std::array<Side, 2>& sides) const {
    std::array<double, 2> best{0, 0};
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t side = 0; side < 2; ++side) {
        if (!own[i].is_on_side[side]) continue;
        const double sign = side == 0 ? -1 : 1;
        const double x = point[0] + sign * step[0], y = point[1] + sign * step[1];
        if (own[i].inverse_depth.at(x, y) <= best[side]) continue;
        best[side] = own[i].inverse_depth.at(x, y);
        sides[side] = {line.own[i].face, static_cast<std::int32_t>(i)};
      }
    }
    return best;
  }

  /// Whether the surface continues beyond the edge in a face that does not have the edge but ends there as
  /// well (a T-junction): the edge of that face counts the other half.
  [[nodiscard]] bool is_continued(const EdgeLine& line, const Side& low, const Side& high, double column,
                                  double row) const {
    const bool low_is_own = low.half_edge >= 0;
    const std::int32_t own = low_is_own ? low.face : high.face, other = low_is_own ? high.face : low.face;
    if (other < 0) return false;
    const double nearness = scene_.field.inverse_depth(own).at(column, row);
    const double farther = nearness - scene_.field.inverse_depth(other).at(column, row);
    if (std::abs(farther) > 1e-6 * nearness) return false;
    const double sign = low_is_own ? -1 : 1;  // does the other face lie under this one?
    return scene_.field.hit(other, column + sign * beside * line.normal[0],
                            row + sign * beside * line.normal[1]) == 0;
  }

  const BoundaryScene<Colour, Adjoint>& scene_;
  std::vector<std::vector<Found>> found_;
  std::size_t first_line_ = 0;  // of the field
};
}  // namespace tapestry::raster::detail
