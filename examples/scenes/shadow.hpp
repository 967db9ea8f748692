#pragma once
#include "scene_builder.hpp"

namespace tapestry::scenes {
using Ground = std::array<double, 2>;

/// Corners of the convex hull, counter-clockwise. Source: Andrew's monotone chain (1979).
[[nodiscard]] inline std::vector<Ground> convex_hull(std::vector<Ground> points) {
  std::sort(points.begin(), points.end());
  std::vector<Ground> hull;
  const auto extend = [&](const Ground& point, std::size_t kept) {
    while (hull.size() >= kept + 2) {
      const Ground& a = hull[hull.size() - 2];
      const Ground& b = hull.back();
      if ((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]) > 0) break;
      hull.pop_back();
    }
    hull.push_back(point);
  };
  for (const Ground& point : points) extend(point, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) extend(points[i], lower);
  hull.pop_back();
  return hull;
}

[[nodiscard]] inline Shadow make_shadow(const std::vector<Ground>& outline, double softness, double depth) {
  Shadow shadow{{}, {0, 0}, 0, softness, depth};
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Ground& a = outline[i];
    const Ground& b = outline[(i + 1) % outline.size()];
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    const double nx = (b[1] - a[1]) / length, ny = (a[0] - b[0]) / length;
    shadow.sides.push_back({nx, ny, nx * a[0] + ny * a[1]});
    for (std::size_t axis = 0; axis < 2; ++axis)
      shadow.centre[axis] += a[axis] / static_cast<double>(outline.size());
  }
  for (const Ground& corner : outline)
    shadow.reach = std::max(
        shadow.reach, std::hypot(corner[0] - shadow.centre[0], corner[1] - shadow.centre[1]) + 2 * softness);
  return shadow;
}

/// Shadow that the light throws of a point set, and the dark contact patch under it.
/// \param solid  points in the thing's own frame
inline void cast_shadows(SceneBuilder& builder, const std::vector<Point>& solid, const Pose& pose,
                         double contact_depth) {
  const raster::Light& light = builder.scene().light;
  const auto& towards = light.direction;  // unit length, above the horizon
  std::vector<Ground> thrown, footprint;
  for (const Point& local : solid) {
    const Point p = pose(local);
    thrown.push_back({p[0] - towards[0] / towards[2] * p[2], p[1] - towards[1] / towards[2] * p[2]});
    footprint.push_back({p[0], p[1]});
  }
  const double direct = light.directional * towards[2];
  builder.cast_shadow(make_shadow(convex_hull(thrown), 0.12, direct / (light.ambient + direct)));
  builder.cast_shadow(make_shadow(convex_hull(footprint), 0.35, contact_depth));
}

/// The light that reaches a point of the ground, 1 where no shadow falls.
[[nodiscard]] inline double light_share(const std::vector<Shadow>& shadows, double x, double y) {
  double share = 1;
  for (const Shadow& shadow : shadows) {
    const double dx = x - shadow.centre[0], dy = y - shadow.centre[1];
    if (dx * dx + dy * dy > shadow.reach * shadow.reach) continue;
    double outside = -1e9;  // signed distance to the outline; near corners a little too small
    for (const Shadow::Side& side : shadow.sides)
      outside = std::max(outside, side.normal_x * x + side.normal_y * y - side.offset);
    const double t = std::clamp(0.5 - outside / (2 * shadow.softness), 0.0, 1.0);
    share *= 1 - shadow.depth * t * t * (3 - 2 * t);
  }
  return share;
}
}  // namespace tapestry::scenes
