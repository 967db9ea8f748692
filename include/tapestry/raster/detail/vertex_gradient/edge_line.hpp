#pragma once
#include <tapestry/raster/detail/face_field.hpp>

namespace tapestry::raster::detail {
/// Scene of the integrals over boundaries of a picture, which are outlines and intersections.
template <class Colour, class Adjoint>
struct BoundaryScene {
  const geometry::Mesh& mesh;
  const MeshEdges& edges;
  const std::vector<geometry::Vector3>& positions_view;
  const FaceField& field;
  const geometry::Camera& camera;
  const Colour& colour;
  Adjoint adjoint_of;  ///< (column, row) → the derivatives by the pixel's channels there, as Colour::Colour
  double longest_piece;  ///< px
};
template <class Colour, class Adjoint>
BoundaryScene(const geometry::Mesh&, const MeshEdges&, const std::vector<geometry::Vector3>&,
              const FaceField&, const geometry::Camera&, const Colour&, Adjoint, double)
    -> BoundaryScene<Colour, Adjoint>;

/// An edge in a picture: the points where m·r = 0, m = q_a × q_b, between its ends.
struct EdgeLine {
  std::span<const HalfEdge> own;
  geometry::Vector3 a, b;          ///< its ends in view space, of the first half-edge
  std::array<double, 2> from, to;  ///< its ends in the picture
  geometry::Vector3 m;
  std::array<double, 2> normal;  ///< unit, in the picture, towards m·r > 0
  double steepness;              ///< |∂(m·r)/∂(column, row)|
  Affine inverse_depth;          ///< 1/z where it appears
  std::array<double, 2> way;     ///< unit, in the picture, from its first end to the other
  double length;                 ///< in the picture
  double hidden_to = 0;          ///< hidden from its first end up to here, in pixels

  [[nodiscard]] bool has(std::int32_t face) const {
    return std::any_of(own.begin(), own.end(), [&](const HalfEdge& half) { return half.face == face; });
  }

  /// The point at this distance from its first end.
  [[nodiscard]] std::array<double, 2> at(double place) const {
    return {from[0] + place * way[0], from[1] + place * way[1]};
  }

  /// Distance of a point from its first end.
  [[nodiscard]] double place_of(double column, double row) const {
    return (column - from[0]) * way[0] + (row - from[1]) * way[1];
  }

  /// Sets the line of an edge from `first` to `last`, in view space. Returns false if nothing of it lies in
  /// the view, it has no length there, or it goes through the eye.
  [[nodiscard]] bool set(const geometry::Vector3& first, const geometry::Vector3& last,
                         const geometry::Camera& camera, const PixelRays& rays) {
    a = first;
    b = last;
    std::array<double, 2> range{0, 1};
    if (!usable(a) || !usable(b) || !cut_to_view(camera, range)) return false;
    const auto end = [&](double t) {
      return rays.picture_point(geometry::add(a, geometry::scale(geometry::subtract(b, a), t)));
    };
    from = end(range[0]);
    to = end(range[1]);
    m = geometry::cross(a, b);
    normal = {m[0] * rays.step[0], m[1] * rays.step[1]};
    steepness = std::hypot(normal[0], normal[1]);
    length = distance(from, to);
    if (!(steepness > 0) || !(length > 0)) return false;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      normal[axis] /= steepness;
      way[axis] = (to[axis] - from[axis]) / length;
    }
    // r = α·a + β·b there, so 1/z = α + β; solved by products with m.
    const auto depth =
        geometry::scale(geometry::cross(geometry::subtract(a, b), m), -1 / geometry::dot(m, m));
    inverse_depth = {depth[0] * rays.step[0], depth[1] * rays.step[1],
                     depth[0] * rays.first[0] + depth[1] * rays.first[1] + depth[2]};
    return true;
  }

 private:
  /// The part of a + t·(b − a), t in [0, 1], within near, far and the picture's sides.
  [[nodiscard]] bool cut_to_view(const geometry::Camera& camera, std::array<double, 2>& range) const {
    const auto keep = [&](double at_a, double at_b) {  // where a linear function is ≥ 0
      if (at_a < 0 && at_b < 0) return false;
      if (at_a < 0) range[0] = std::max(range[0], at_a / (at_a - at_b));
      if (at_b < 0) range[1] = std::min(range[1], at_a / (at_a - at_b));
      return range[0] < range[1];
    };
    const double x = camera.tan_half_fov_x, y = camera.tan_half_fov_y;
    return keep(a[2] - camera.near, b[2] - camera.near) && keep(camera.far - a[2], camera.far - b[2]) &&
           keep(x * a[2] - a[0], x * b[2] - b[0]) && keep(x * a[2] + a[0], x * b[2] + b[0]) &&
           keep(y * a[2] - a[1], y * b[2] - b[1]) && keep(y * a[2] + a[1], y * b[2] + b[1]);
  }
};
}  // namespace tapestry::raster::detail
