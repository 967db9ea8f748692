#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <utility>
#include <vector>

namespace tapestry::shell {

/// A part of a car's paint that lies flat in the texture: faces that are connected on the car and in uv.
///
/// The point (u, v) of the texture lies at
///
///   x = right · u − left_m,   y = up · v − bottom_m   metres
///
/// on the panel, seen from outside, y up. right · up is the ratio of the faces' area on the car to that in
/// uv, and right : up the geometric mean of |∂P/∂u| : |∂P/∂v| over the faces with places P, by area: a
/// texture that is stretched along an axis everywhere prints true.
struct PaintPanel {
  std::vector<std::size_t> faces;
  double right = 1, up = 1;  ///< metres by u, negative where the texture is mirrored, and by v
  double left_m = 0, bottom_m = 0;
  double width_m = 0, height_m = 0;
  double area_m2 = 0;  ///< of the faces
  /// Where it is cut, in uv: edges of one of its faces only.
  std::vector<std::array<std::array<double, 2>, 2>> rim{};
  /// Local scales, lengths on the car over lengths on the panel: all but the smallest and the largest
  /// hundredth of the area, each counted along its directions of most and least stretch.
  std::array<double, 2> stretch{1, 1};

  [[nodiscard]] std::array<double, 2> place_m(const std::array<double, 2>& uv) const {
    return {right * uv[0] - left_m, up * uv[1] - bottom_m};
  }
  [[nodiscard]] std::array<double, 2> uv(const std::array<double, 2>& place_m) const {
    return {(place_m[0] + left_m) / right, (place_m[1] + bottom_m) / up};
  }
};

/// Panels, the largest area first, and the number of faces that no panel can have, as they have no area in
/// the texture or on the car.
struct PaintPanels {
  std::vector<PaintPanel> panels;
  std::size_t flat_faces = 0;
};

namespace detail {
using UvPoint = std::array<double, 2>;

inline UvPoint uv_of(const geometry::Mesh& mesh, std::size_t face, std::size_t corner) {
  return mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][corner])];
}

inline geometry::Vector3 place_of(const geometry::Mesh& mesh, std::size_t face, std::size_t corner) {
  return mesh.positions[static_cast<std::size_t>(mesh.faces[face][corner])];
}

/// Twice the area of a triangle, positive if it turns to the left.
inline double turn(const UvPoint& a, const UvPoint& b, const UvPoint& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

inline double uv_turn(const geometry::Mesh& mesh, std::size_t face) {
  return turn(uv_of(mesh, face, 0), uv_of(mesh, face, 1), uv_of(mesh, face, 2));
}

/// A face's map from uv to places P: its area there, and the products of its derivatives.
struct FaceStretch {
  double area = 0, uv_area = 0;
  double uu = 0, uv = 0, vv = 0;  ///< ∂P/∂u · ∂P/∂u, ∂P/∂u · ∂P/∂v, ∂P/∂v · ∂P/∂v
};

/// \returns nothing if the face has no area in uv or on the car
inline std::optional<FaceStretch> face_stretch(const geometry::Mesh& mesh, std::size_t face) {
  const auto a = place_of(mesh, face, 0);
  const auto p = geometry::subtract(place_of(mesh, face, 1), a);
  const auto q = geometry::subtract(place_of(mesh, face, 2), a);
  const UvPoint origin = uv_of(mesh, face, 0), s = uv_of(mesh, face, 1), t = uv_of(mesh, face, 2);
  const double twice = uv_turn(mesh, face);
  FaceStretch found{geometry::length(geometry::cross(p, q)) / 2, std::abs(twice) / 2};
  if (!(found.area > 0 && found.uv_area > 0 && std::isfinite(found.area / found.uv_area)))
    return std::nullopt;
  const auto u = geometry::scale(
      geometry::subtract(geometry::scale(p, t[1] - origin[1]), geometry::scale(q, s[1] - origin[1])),
      1 / twice);
  const auto v = geometry::scale(
      geometry::subtract(geometry::scale(q, s[0] - origin[0]), geometry::scale(p, t[0] - origin[0])),
      1 / twice);
  found.uu = geometry::dot(u, u);
  found.uv = geometry::dot(u, v);
  found.vv = geometry::dot(v, v);
  return found;
}

/// Faces at an edge, by the side of it on which they lie in uv, and by whether they turn to the left there.
using FacesAtEdge = std::array<std::array<std::vector<std::size_t>, 2>, 2>;

/// Calls join(a, b) for the faces at an edge that lie on the same surface. Such faces lie on either side of
/// the edge in uv. Those on one side are halves of a car that share a mirrored texture, or the outside and
/// the inside of sheet metal, which turn differently.
template <class Join>
void join_across(const FacesAtEdge& edge, Join join) {
  const auto& [right, left] = edge;
  for (std::size_t turned = 0; turned < 2; ++turned) {
    for (const auto& equal : {right[turned], left[turned]})
      for (std::size_t i = 1; i < equal.size(); ++i) join(equal[0], equal[i]);
    if (right[turned].empty()) continue;
    if (!left[turned].empty())
      join(right[turned][0], left[turned][0]);
    else if (!left[1 - turned].empty() && right[1 - turned].empty())
      join(right[turned][0], left[1 - turned][0]);  // the mesh does not turn its faces alike
  }
}

/// The faces beside each across edges whose ends are the same on the car and in uv, see join_across().
/// \param faces  with area in uv
inline std::vector<std::vector<std::size_t>> uv_neighbours(const geometry::Mesh& mesh,
                                                           const std::vector<std::size_t>& faces) {
  using End = std::pair<geometry::Vector3, UvPoint>;
  std::map<std::pair<End, End>, FacesAtEdge> edges;
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t next = (k + 1) % 3;
      End a{place_of(mesh, faces[i], k), uv_of(mesh, faces[i], k)};
      End b{place_of(mesh, faces[i], next), uv_of(mesh, faces[i], next)};
      if (b < a) std::swap(a, b);
      const bool is_left = turn(a.second, b.second, uv_of(mesh, faces[i], (k + 2) % 3)) > 0;
      edges[{a, b}][is_left ? 1 : 0][uv_turn(mesh, faces[i]) > 0 ? 1 : 0].push_back(i);
    }
  std::vector<std::vector<std::size_t>> neighbours(faces.size());
  for (const auto& [ends, edge] : edges)
    join_across(edge, [&](std::size_t a, std::size_t b) {
      neighbours[a].push_back(b);
      neighbours[b].push_back(a);
    });
  return neighbours;
}

/// \param faces  with area in uv and on the car
inline std::vector<std::vector<std::size_t>> connected_faces(const geometry::Mesh& mesh,
                                                             const std::vector<std::size_t>& faces) {
  const auto neighbours = uv_neighbours(mesh, faces);
  std::vector<std::vector<std::size_t>> parts;
  std::vector<bool> is_taken(faces.size(), false);
  for (std::size_t first = 0; first < faces.size(); ++first) {
    if (is_taken[first]) continue;
    std::vector<std::size_t> part{first};
    is_taken[first] = true;
    for (std::size_t i = 0; i < part.size(); ++i)
      for (const std::size_t neighbour : neighbours[part[i]]) {
        if (!is_taken[neighbour]) part.push_back(neighbour);
        is_taken[neighbour] = true;
      }
    for (std::size_t& face : part) face = faces[face];
    parts.push_back(std::move(part));
  }
  return parts;
}

/// The value below which a share of the weight lies.
/// \param values  with their weights, ascending, at least one
inline double weighted_quantile(const std::vector<std::array<double, 2>>& values, double share) {
  double total = 0, sum = 0;
  for (const auto& [value, weight] : values) total += weight;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= share * total) return value;
  }
  return values.back()[0];
}

/// Sets the scales of a panel with its faces, and its stretch. The local scales are the singular values of
/// (∂P/∂u / right, ∂P/∂v / up).
inline void fit_scales(PaintPanel& panel, const geometry::Mesh& mesh, double metres_per_unit) {
  std::vector<FaceStretch> all;
  double area = 0, uv_area = 0, log_ratio = 0, mirrored = 0;
  for (const std::size_t face : panel.faces) {
    all.push_back(*face_stretch(mesh, face));
    const FaceStretch& own = all.back();
    area += own.area;
    uv_area += own.uv_area;
    log_ratio += own.area * std::log(own.uu / own.vv) / 2;
    mirrored += uv_turn(mesh, face) < 0 ? own.area : -own.area;
  }
  panel.area_m2 = area * metres_per_unit * metres_per_unit;
  const double mean = std::sqrt(panel.area_m2 / uv_area), root = std::exp(log_ratio / area / 2);
  panel.right = mean * root;
  panel.up = mean / root;
  std::vector<std::array<double, 2>> scales;
  for (const FaceStretch& own : all) {
    const double e = own.uu / (panel.right * panel.right), f = own.uv / (panel.right * panel.up);
    const double g = own.vv / (panel.up * panel.up);
    const double middle = (e + g) / 2, half = std::hypot((e - g) / 2, f);
    for (const double square : {middle - half, middle + half})
      scales.push_back({metres_per_unit * std::sqrt(std::max(square, 0.0)), own.area});
  }
  std::ranges::sort(scales);
  panel.stretch = {weighted_quantile(scales, 0.01), weighted_quantile(scales, 0.99)};
  if (mirrored > 0) panel.right = -panel.right;
}

inline void find_rim(PaintPanel& panel, const geometry::Mesh& mesh) {
  std::map<std::array<UvPoint, 2>, std::size_t> counts;
  for (const std::size_t face : panel.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      UvPoint a = uv_of(mesh, face, k), b = uv_of(mesh, face, (k + 1) % 3);
      if (b < a) std::swap(a, b);
      ++counts[{a, b}];
    }
  for (const auto& [ends, count] : counts)
    if (count == 1) panel.rim.push_back(ends);
}

inline void fit_bounds(PaintPanel& panel, const geometry::Mesh& mesh) {
  constexpr double most = std::numeric_limits<double>::infinity();
  std::array<double, 2> low{most, most}, high{-most, -most};
  for (const std::size_t face : panel.faces)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto place = panel.place_m(uv_of(mesh, face, k));
      for (std::size_t axis = 0; axis < 2; ++axis) {
        low[axis] = std::min(low[axis], place[axis]);
        high[axis] = std::max(high[axis], place[axis]);
      }
    }
  panel.left_m = low[0];
  panel.bottom_m = low[1];
  panel.width_m = high[0] - low[0];
  panel.height_m = high[1] - low[1];
}
}  // namespace detail

/// The panels of the painted faces.
/// \param body  with a finite uv for every corner of a painted face
inline PaintPanels paint_panels(const raster::PaintedMesh& body, double metres_per_unit) {
  PaintPanels found;
  std::vector<std::size_t> faces;
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    if (detail::face_stretch(body.mesh, face))
      faces.push_back(face);
    else
      ++found.flat_faces;
  }
  for (auto& part : detail::connected_faces(body.mesh, faces)) {
    PaintPanel panel{std::move(part)};
    detail::fit_scales(panel, body.mesh, metres_per_unit);
    detail::fit_bounds(panel, body.mesh);
    detail::find_rim(panel, body.mesh);
    found.panels.push_back(std::move(panel));
  }
  std::ranges::stable_sort(found.panels, std::ranges::greater{}, &PaintPanel::area_m2);
  return found;
}

}  // namespace tapestry::shell
