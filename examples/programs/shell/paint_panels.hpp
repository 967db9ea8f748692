#pragma once
#include <tapestry/raster/painted_mesh.hpp>
#include "flattening.hpp"

namespace tapestry::shell {
/// A part of a car's paint laid flat, seen from outside, metres from its lower left corner.
struct PaintPanel {
  using Place = std::array<double, 2>;

  /// A number printed at the same point on the rims of two panels.
  struct Mark {
    std::size_t number;
    Place place_m, inwards;  ///< the direction into the panel, of length 1
  };

  std::vector<std::size_t> faces{};
  std::vector<std::array<Place, 3>> places_m{};  ///< of the corners of each face
  double width_m = 0, height_m = 0;
  double area_m2 = 0;                             ///< of the faces
  std::vector<std::array<std::size_t, 2>> rim{};  ///< where it is cut, see FlatPart
  std::vector<Mark> marks{};
  std::array<double, 2> stretch{1, 1};  ///< see FlatPart
  /// The car's directions on the panel, with the length that they have there: near 0 where they point away
  /// from it.
  Place to_front{}, to_top{};

  [[nodiscard]] std::array<Place, 2> ends_m(const std::array<std::size_t, 2>& edge) const {
    const auto& [face, corner] = edge;
    return {places_m[face][corner], places_m[face][(corner + 1) % 3]};
  }
};

/// Panels, the largest area first, and the number of faces that no panel has, as they have no area.
struct PaintPanels {
  std::vector<PaintPanel> panels;
  std::size_t flat_faces = 0;
};

namespace detail {
using UvPoint = std::array<double, 2>;

inline UvPoint uv_of(const geometry::Mesh& mesh, std::size_t face, std::size_t corner) {
  return mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][corner])];
}

/// Slope of a number on a triangle, from its values at the corners.
inline std::array<double, 2> slope_of(const std::array<PaintPanel::Place, 3>& at,
                                      const std::array<double, 3>& values) {
  const double px = at[1][0] - at[0][0], py = at[1][1] - at[0][1];
  const double qx = at[2][0] - at[0][0], qy = at[2][1] - at[0][1], twice = px * qy - py * qx;
  const double p = values[1] - values[0], q = values[2] - values[0];
  return {(p * qy - q * py) / twice, (q * px - p * qx) / twice};
}

/// The mean slope of a coordinate of the car over a part.
inline std::array<double, 2> mean_slope(const geometry::Mesh& mesh, const FlatPart& part, std::size_t axis) {
  std::array<double, 2> sum{};
  double areas = 0;
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    const double area = own_plane(mesh, part.faces[i]).area;
    const auto slope = slope_of(
        part.places[i], {place_of(mesh, part.faces[i], 0)[axis], place_of(mesh, part.faces[i], 1)[axis],
                         place_of(mesh, part.faces[i], 2)[axis]});
    sum = {sum[0] + area * slope[0], sum[1] + area * slope[1]};
    areas += area;
  }
  return {sum[0] / areas, sum[1] / areas};
}

inline std::array<double, 2> turned(const std::array<double, 2>& place, double cosine, double sine) {
  return {cosine * place[0] - sine * place[1], sine * place[0] + cosine * place[1]};
}

/// The part with the car's top up, or with its front up if the part lies level.
inline PaintPanel panel_of(const geometry::Mesh& mesh, const FlatPart& part, double metres_per_unit) {
  PaintPanel panel;
  panel.faces = part.faces;
  panel.stretch = part.stretch;
  panel.rim = part.rim;
  const auto to_front = mean_slope(mesh, part, 0), to_top = mean_slope(mesh, part, 2);
  constexpr double level = 0.35;
  const auto& up = std::hypot(to_top[0], to_top[1]) > level ? to_top : to_front;
  const double length = std::hypot(up[0], up[1]);
  const double cosine = length > 0 ? up[1] / length : 1, sine = length > 0 ? up[0] / length : 0;
  panel.to_front = turned(to_front, cosine, sine);
  panel.to_top = turned(to_top, cosine, sine);
  constexpr double most = std::numeric_limits<double>::infinity();
  std::array<double, 2> low{most, most}, high{-most, -most};
  for (std::size_t i = 0; i < part.faces.size(); ++i) {
    auto& places = panel.places_m.emplace_back();
    panel.area_m2 += own_plane(mesh, part.faces[i]).area * metres_per_unit * metres_per_unit;
    for (std::size_t k = 0; k < 3; ++k) {
      places[k] = turned(part.places[i][k], cosine, sine);
      for (std::size_t axis = 0; axis < 2; ++axis) {
        places[k][axis] *= metres_per_unit;
        low[axis] = std::min(low[axis], places[k][axis]);
        high[axis] = std::max(high[axis], places[k][axis]);
      }
    }
  }
  for (auto& places : panel.places_m)
    for (auto& place : places) place = {place[0] - low[0], place[1] - low[1]};
  panel.width_m = high[0] - low[0];
  panel.height_m = high[1] - low[1];
  return panel;
}

/// Finds edges that two panels share, and marks points on them.
class PanelRims {
 public:
  PanelRims(const geometry::Mesh& mesh, std::vector<PaintPanel>& panels) : panels_(panels) {
    std::map<std::pair<geometry::Vector3, geometry::Vector3>, std::vector<Edge>> at;
    for (std::size_t p = 0; p < panels.size(); ++p)
      for (const auto& edge : panels[p].rim) {
        const std::size_t face = panels[p].faces[edge[0]];
        const auto from = place_of(mesh, face, edge[1]), to = place_of(mesh, face, (edge[1] + 1) % 3);
        at[std::minmax(from, to)].push_back({p, edge, from < to});
      }
    for (const auto& [ends, edges] : at) match(edges);
  }

  /// \param spacing_m  of marks between two panels, at least
  void mark(double spacing_m) {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<PaintPanel::Place>> marked;
    std::size_t number = 0;
    for (const auto& [one, other] : pairs_) {
      auto& before = marked[{one.panel, other.panel}];
      const auto middle = middle_of(one);
      const auto is_near = [&](const PaintPanel::Place& place) {
        return std::hypot(place[0] - middle[0], place[1] - middle[1]) < spacing_m;
      };
      if (std::ranges::any_of(before, is_near)) continue;
      before.push_back(middle);
      ++number;
      for (const Edge& edge : {one, other})
        panels_[edge.panel].marks.push_back({number, middle_of(edge), inwards(edge)});
    }
  }

 private:
  struct Edge {
    std::size_t panel;
    std::array<std::size_t, 2> of_rim;
    bool is_forwards;
  };

  /// Pairs edges at one place of the car that run opposite ways.
  void match(const std::vector<Edge>& edges) {
    for (auto edge = edges.begin(); edge != edges.end(); ++edge) {
      const auto partner = std::ranges::find_if(
          edges, [&](const Edge& other) { return other.is_forwards != edge->is_forwards; });
      if (partner != edges.end() && partner > edge) pairs_.push_back({*edge, *partner});
    }
  }

  [[nodiscard]] std::array<PaintPanel::Place, 2> ends_of(const Edge& edge) const {
    return panels_[edge.panel].ends_m(edge.of_rim);
  }
  [[nodiscard]] PaintPanel::Place middle_of(const Edge& edge) const {
    const auto [a, b] = ends_of(edge);
    return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
  }
  /// Faces turn to the left, so that they lie to the left of their edges.
  [[nodiscard]] PaintPanel::Place inwards(const Edge& edge) const {
    const auto [a, b] = ends_of(edge);
    const double length = std::hypot(b[0] - a[0], b[1] - a[1]);
    return {-(b[1] - a[1]) / length, (b[0] - a[0]) / length};
  }

  std::vector<PaintPanel>& panels_;
  std::vector<std::pair<Edge, Edge>> pairs_{};
};
}  // namespace detail

inline PaintPanels paint_panels(const raster::PaintedMesh& body, double metres_per_unit) {
  PaintPanels found;
  std::vector<std::size_t> faces;
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    if (detail::own_plane(body.mesh, face).area > 0)
      faces.push_back(face);
    else
      ++found.flat_faces;
  }
  double area = 0;
  for (const FlatPart& part : flattened(body.mesh, std::move(faces))) {
    found.panels.push_back(detail::panel_of(body.mesh, part, metres_per_unit));
    area += found.panels.back().area_m2;
  }
  std::ranges::stable_sort(found.panels, std::ranges::greater{}, &PaintPanel::area_m2);
  detail::PanelRims(body.mesh, found.panels).mark(std::sqrt(area) / 8);
  return found;
}
}  // namespace tapestry::shell
