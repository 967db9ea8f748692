#pragma once
#include <tapestry/geometry/point_columns.hpp>

namespace tapestry::geometry {
/// Shape of a polygon, as PolygonTriangulator classifies it.
enum class PolygonShape {
  fan,        ///< right as a fan around its first corner: convex polygons, and others that all of it sees
  concave,    ///< cut into other triangles
  crossing,   ///< crosses itself: no triangles of its corners cover it
  intricate,  ///< not finished within the work allowed
};

/// Cuts polygons into triangles of their corners, by clipping ears.
///
/// The polygon is seen along the axis that shortens its area least, and every decision there is exact. All
/// triangles have the polygon's orientation, or no area. So each point is covered as often as the polygon
/// winds around it, and the triangles' areas add up to the polygon's, however often it touches itself:
/// bridges to holes, repeated corners and corners in a line are no errors. A polygon of n corners has n − 2
/// triangles. Ears are compared with the corners that could lie in them, which PointColumns finds; about
/// n^1.5 of them for most polygons, n² for some. The work is bounded, since such polygons may come from a
/// file. Source: Meisters, Polygons Have Ears (1975). Our own addition: points on the border of an ear block
/// it where an edge leads from them into it.
class PolygonTriangulator {
 public:
  /// \param work  most comparisons of corners with ears over the life of this object; the default takes
  ///              some seconds
  explicit PolygonTriangulator(std::uint64_t work = std::uint64_t(1) << 30U) : work_(work) {}

  /// Finds the triangles of one polygon.
  /// \param corners  in order, three or more, finite; any unit
  PolygonShape triangulate(std::span<const Vector3> corners);

  /// Triangles of the last polygon, if it was concave: three positions among its corners each.
  [[nodiscard]] const std::vector<std::array<std::size_t, 3>>& triangles() const { return triangles_; }

 private:
  struct Blocker {
    Vector2 point;
    std::size_t corner;
  };

  void flatten(std::span<const Vector3> corners);

  [[nodiscard]] bool turns_one_way(int sense) const;

  /// Clips ears until none is left; false if corners are left, but no ear.
  bool clip_all();

  void begin();

  [[nodiscard]] int turn(std::size_t corner) const {
    return orientation(points_[before_[corner]], points_[corner], points_[next_[corner]]);
  }

  /// Corners that turn left never block an ear alone.
  void classify(std::size_t corner);

  void retire(std::size_t corner);

  /// Clips the ear at a corner, and returns the corner to test next.
  std::size_t clip(std::size_t corner);

  /// \param loose  also takes corners in a line, and ears whose new edge runs through a corner
  bool is_ear(std::size_t corner, bool loose);

  /// Like PointColumns::any_in(), over the listed blockers.
  template <class Answers>
  [[nodiscard]] bool any_listed_in(const std::array<Vector2, 3>& ear, Answers answers) {
    const auto& [a, b, c] = ear;
    work_ -= std::min<std::uint64_t>(work_, blockers_.size());
    const Vector2 low{std::min({a[0], b[0], c[0]}), std::min({a[1], b[1], c[1]})};
    const Vector2 high{std::max({a[0], b[0], c[0]}), std::max({a[1], b[1], c[1]})};
    return std::ranges::any_of(blockers_, [&](const Blocker& blocker) {
      const auto& [point, other] = blocker;
      return point[0] >= low[0] && point[0] <= high[0] && point[1] >= low[1] && point[1] <= high[1] &&
             answers(other);
    });
  }

  /// Whether b, on one line with a and c, lies strictly between them; if not, it is the tip of a spike.
  [[nodiscard]] static bool lies_between(const Vector2& a, const Vector2& b, const Vector2& c);

  /// Whether `other` lies inside the ear at `corner`, or on its border with an edge that leads inside.
  [[nodiscard]] bool is_in_the_way(std::size_t other, std::size_t corner, bool loose) const;

  static constexpr std::size_t few_blockers = 64;  // for so few, a list is as quick

  std::uint64_t work_;
  std::vector<Vector2> points_;
  PointColumns columns_;  // all corners, used if many block
  std::vector<std::size_t> before_, next_;
  std::vector<Blocker> blockers_;  // and some that have retired
  std::size_t retired_ = 0;
  std::vector<char> is_blocker_, is_listed_;
  std::vector<std::array<std::size_t, 3>> triangles_;
};
}  // namespace tapestry::geometry
