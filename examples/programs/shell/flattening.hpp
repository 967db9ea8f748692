#pragma once
#include <Eigen/SparseCholesky>
#include <complex>
#include <map>
#include <numeric>
#include <tapestry/raster/lighting.hpp>

/// \file
/// Surfaces laid flat, cut where they would stretch: parts of a car's skin that can be printed and glued on.

namespace tapestry::shell {
/// A part of a surface, and where its faces lie when it is flat.
struct FlatPart {
  std::vector<std::size_t> faces{};  ///< of the mesh
  /// Places of each face's corners, in units of the mesh. Seen from outside, where corners turn to the left.
  std::vector<std::array<std::array<double, 2>, 3>> places{};
  /// Edges that no other face of the part has: a face's place in `faces`, and the corner where its edge
  /// begins.
  std::vector<std::array<std::size_t, 2>> rim{};
  /// Lengths on the surface over lengths on the flat part, along the directions of most and least stretch:
  /// the 5th and the 95th percentile, by area.
  std::array<double, 2> stretch{1, 1};
};

namespace detail {
using Flat = std::complex<double>;

/// A triangle of the surface in its own plane: its corners, the first at 0 and the second on the real axis.
struct OwnPlane {
  std::array<Flat, 3> corners{};
  double area = 0;
};

[[nodiscard]] inline geometry::Vector3 place_of(const geometry::Mesh& mesh, std::size_t face,
                                                std::size_t corner) {
  return mesh.positions[static_cast<std::size_t>(mesh.faces[face][corner])];
}

[[nodiscard]] inline OwnPlane own_plane(const geometry::Mesh& mesh, std::size_t face) {
  const auto a = place_of(mesh, face, 0);
  const auto p = geometry::subtract(place_of(mesh, face, 1), a),
             q = geometry::subtract(place_of(mesh, face, 2), a);
  OwnPlane plane;
  const double base = geometry::length(p);
  plane.area = geometry::length(geometry::cross(p, q)) / 2;
  plane.corners = {Flat(0), Flat(base), Flat(geometry::dot(p, q) / base, 2 * plane.area / base)};
  return plane;
}

/// Singular values of the linear map that takes the triangle `flat` to `own`: lengths there over lengths
/// here; infinite where `flat` has no area or is turned over.
[[nodiscard]] inline std::array<double, 2> scales_of(const std::array<Flat, 3>& own,
                                                     const std::array<Flat, 3>& flat) {
  const Flat p = flat[1] - flat[0], q = flat[2] - flat[0], s = own[1] - own[0], t = own[2] - own[0];
  const double turn = std::imag(std::conj(p) * q);
  if (!(turn > 0)) return {0, std::numeric_limits<double>::infinity()};
  // The map is z → a z + b conj(z); here a and b are a quarter of a turn off. Standard libraries differ in
  // how they divide by complex numbers.
  const Flat a = (s * std::conj(q) - t * std::conj(p)) / (2 * turn);
  const Flat b = (t * p - s * q) / (2 * turn);
  return {std::abs(std::abs(a) - std::abs(b)), std::abs(a) + std::abs(b)};
}

/// The surface that is cut: faces, their planes and normals, and their neighbours.
struct CutSurface {
  struct Border {
    std::size_t other;  ///< a face, as an index into `faces`
    double length;
  };

  CutSurface(const geometry::Mesh& mesh, std::vector<std::size_t> of_mesh) : faces(std::move(of_mesh)) {
    std::map<geometry::Vector3, std::size_t> places;
    for (const std::size_t face : faces) {
      planes.push_back(own_plane(mesh, face));
      auto& own = corners.emplace_back();
      for (std::size_t k = 0; k < 3; ++k)
        own[k] = places.try_emplace(place_of(mesh, face, k), places.size()).first->second;
      normals.push_back(geometry::normalised(raster::face_normal(mesh, mesh.faces[face])));
    }
    positions.resize(places.size());
    for (const auto& [position, index] : places) positions[index] = position;
    find_borders();
  }

  std::vector<std::size_t> faces;
  std::vector<OwnPlane> planes{};
  std::vector<geometry::Vector3> normals{};
  std::vector<std::array<std::size_t, 3>> corners{};
  std::vector<geometry::Vector3> positions{};
  std::vector<std::vector<Border>> borders{};

  [[nodiscard]] std::vector<std::vector<std::size_t>> connected(const std::vector<std::size_t>& some) const {
    std::vector<int> is_open(faces.size(), 0);
    for (const std::size_t i : some) is_open[i] = 1;
    std::vector<std::vector<std::size_t>> parts;
    for (const std::size_t first : some) {
      if (is_open[first] == 0) continue;
      std::vector<std::size_t> part{first};
      is_open[first] = 0;
      for (std::size_t k = 0; k < part.size(); ++k)
        for (const Border& border : borders[part[k]])
          if (std::exchange(is_open[border.other], 0) != 0) part.push_back(border.other);
      parts.push_back(std::move(part));
    }
    return parts;
  }

 private:
  /// Faces on both sides of an edge that turn alike. The flattest, if there are more than two.
  void find_borders() {
    borders.resize(faces.size());
    std::map<std::pair<std::size_t, std::size_t>, std::array<std::vector<std::size_t>, 2>> edges;
    for (std::size_t i = 0; i < faces.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t a = corners[i][k], b = corners[i][(k + 1) % 3];
        edges[std::minmax(a, b)][a < b ? 0 : 1].push_back(i);
      }
    for (auto& [ends, sides] : edges) {
      auto& [here, there] = sides;
      const double length =
          geometry::length(geometry::subtract(positions[ends.first], positions[ends.second]));
      while (!here.empty() && !there.empty()) {
        constexpr double sharpest = -0.5;  // a larger angle is the rim of a sheet, with its inside behind
        double best = sharpest;
        std::size_t at_here = 0, at_there = 0;
        for (std::size_t i = 0; i < here.size(); ++i)
          for (std::size_t k = 0; k < there.size(); ++k)
            if (const double flat = geometry::dot(normals[here[i]], normals[there[k]]); flat > best)
              std::tie(best, at_here, at_there) = std::tuple(flat, i, k);
        if (best <= sharpest) break;
        const std::size_t one = here[at_here], other = there[at_there];
        borders[one].push_back({other, length});
        borders[other].push_back({one, length});
        here.erase(here.begin() + static_cast<std::ptrdiff_t>(at_here));
        there.erase(there.begin() + static_cast<std::ptrdiff_t>(at_there));
      }
    }
  }
};

/// A part of a surface laid flat so that each face keeps its shape as well as it can. Source: Liu, Zhang, Xu,
/// Gotsman and Gortler, "A Local/Global Approach to Mesh Parameterization" (SGP 2008), as rigid as possible.
class FlatLayout {
 public:
  FlatLayout(const CutSurface& surface, std::vector<std::size_t> part)
      : surface_(&surface), part_(std::move(part)) {
    // Faces that touch at a corner only are apart there: corners of faces are joined across borders.
    number_corners();
    if (part_.size() == 1) {
      for (std::size_t k = 0; k < 3; ++k) places_[vertices_[0][k]] = surface.planes[part_[0]].corners[k];
      return;
    }
    project();
    relax();
  }

  /// The faces of the surface that lie there.
  [[nodiscard]] const std::vector<std::size_t>& part() const { return part_; }

  [[nodiscard]] std::array<Flat, 3> flat(std::size_t i) const {
    return {places_[vertices_[i][0]], places_[vertices_[i][1]], places_[vertices_[i][2]]};
  }

  /// Scales of all faces along both directions with their areas, ascending.
  [[nodiscard]] std::vector<std::array<double, 2>> scales() const {
    std::vector<std::array<double, 2>> all;
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const OwnPlane& own = surface_->planes[part_[i]];
      for (const double scale : scales_of(own.corners, flat(i))) all.push_back({scale, own.area});
    }
    std::ranges::sort(all);
    return all;
  }

  [[nodiscard]] std::vector<std::array<std::size_t, 2>> rim() const {
    std::map<std::pair<std::size_t, std::size_t>, std::vector<std::array<std::size_t, 2>>> edges;
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        edges[std::minmax(vertices_[i][k], vertices_[i][(k + 1) % 3])].push_back({i, k});
    std::vector<std::array<std::size_t, 2>> found;
    for (const auto& [ends, of_faces] : edges)
      if (of_faces.size() == 1) found.push_back(of_faces[0]);
    return found;
  }

  [[nodiscard]] bool overlaps_or_flips() const {
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const auto [a, b, c] = flat(i);
      if (!(std::imag(std::conj(b - a) * (c - a)) > 0)) return true;
    }
    return rim_crosses_itself();
  }

 private:
  struct Segment {
    std::array<std::size_t, 2> ends;  ///< vertices
    double left, right, bottom, top;
  };

  [[nodiscard]] Segment segment(const std::array<std::size_t, 2>& edge) const {
    const std::size_t from = vertices_[edge[0]][edge[1]], to = vertices_[edge[0]][(edge[1] + 1) % 3];
    const auto [left, right] = std::minmax({places_[from].real(), places_[to].real()});
    const auto [bottom, top] = std::minmax({places_[from].imag(), places_[to].imag()});
    return {{from, to}, left, right, bottom, top};
  }

  /// Whether edges of the rim cross: without turned faces, a part overlaps itself only there.
  [[nodiscard]] bool rim_crosses_itself() const {
    std::vector<Segment> segments;
    for (const auto& edge : rim()) segments.push_back(segment(edge));
    std::ranges::sort(segments, {}, &Segment::left);
    const auto side = [&](const Segment& line, std::size_t vertex) {
      const Flat a = places_[line.ends[0]];
      return std::imag(std::conj(places_[line.ends[1]] - a) * (places_[vertex] - a));
    };
    for (std::size_t i = 0; i < segments.size(); ++i)
      for (std::size_t k = i + 1; k < segments.size() && segments[k].left < segments[i].right; ++k) {
        const Segment &one = segments[i], &other = segments[k];
        const bool is_joined = std::ranges::find_first_of(one.ends, other.ends) != one.ends.end();
        if (other.bottom >= one.top || other.top <= one.bottom || is_joined) continue;
        if (side(one, other.ends[0]) * side(one, other.ends[1]) < 0 &&
            side(other, one.ends[0]) * side(other, one.ends[1]) < 0)
          return true;
      }
    return false;
  }

  void number_corners() {
    // Union of the corners of faces that share a border.
    std::vector<std::size_t> parent(3 * part_.size());
    std::iota(parent.begin(), parent.end(), std::size_t{0});
    const auto root = [&](std::size_t i) {
      while (parent[i] != i) i = parent[i] = parent[parent[i]];
      return i;
    };
    std::map<std::size_t, std::size_t> own;  // of a face of the surface, its place in the part
    for (std::size_t i = 0; i < part_.size(); ++i) own[part_[i]] = i;
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (const auto& border : surface_->borders[part_[i]]) {
        const auto found = own.find(border.other);
        if (found == own.end()) continue;
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t l = 0; l < 3; ++l)
            if (surface_->corners[part_[i]][k] == surface_->corners[border.other][l])
              parent[root(3 * i + k)] = root(3 * found->second + l);
      }
    std::map<std::size_t, std::size_t> numbers;
    vertices_.resize(part_.size());
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k)
        vertices_[i][k] = numbers.try_emplace(root(3 * i + k), numbers.size()).first->second;
    places_.resize(numbers.size());
  }

  /// Onto the plane of the mean normal.
  void project() {
    geometry::Vector3 normal{0, 0, 0};
    for (const std::size_t i : part_)
      normal = geometry::add(normal, geometry::scale(surface_->normals[i], surface_->planes[i].area));
    normal = geometry::normalised(normal);
    const geometry::Vector3 other =
        std::abs(normal[2]) < 0.9 ? geometry::Vector3{0, 0, 1} : geometry::Vector3{1, 0, 0};
    const auto right = geometry::normalised(geometry::cross(other, normal)),
               up = geometry::cross(normal, right);
    for (std::size_t i = 0; i < part_.size(); ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& position = surface_->positions[surface_->corners[part_[i]][k]];
        places_[vertices_[i][k]] = Flat(geometry::dot(position, right), geometry::dot(position, up));
      }
  }

  using Matrix = Eigen::SparseMatrix<double>;

  [[nodiscard]] Eigen::Index vertex(std::size_t i, std::size_t corner) const {
    return static_cast<Eigen::Index>(vertices_[i][corner % 3]);
  }

  /// Weights each edge of a face by the cotangent of the angle opposite to it.
  [[nodiscard]] Matrix laplacian() {
    std::vector<Eigen::Triplet<double>> entries;
    weights_.resize(part_.size());
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const auto& corners = surface_->planes[part_[i]].corners;
      for (std::size_t k = 0; k < 3; ++k) {
        const Flat p = corners[k] - corners[(k + 2) % 3], q = corners[(k + 1) % 3] - corners[(k + 2) % 3];
        const Flat turned = std::conj(p) * q;
        const double w = std::clamp(turned.real() / std::max(turned.imag(), 1e-300), 1e-2, 1e2);
        const Eigen::Index a = vertex(i, k), b = vertex(i, k + 1);
        for (const auto& [row, column, value] :
             {std::tuple(a, a, w), std::tuple(b, b, w), std::tuple(a, b, -w), std::tuple(b, a, -w)})
          entries.emplace_back(row, column, value);
        weights_[i][k] = w;
      }
    }
    entries.emplace_back(0, 0, anchor);
    const auto n = static_cast<Eigen::Index>(places_.size());
    Matrix matrix(n, n);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
  }

  /// The right-hand side that keeps every face's shape, turned as it lies.
  [[nodiscard]] Eigen::MatrixX2d wanted() const {
    Eigen::MatrixX2d sums = Eigen::MatrixX2d::Zero(static_cast<Eigen::Index>(places_.size()), 2);
    for (std::size_t i = 0; i < part_.size(); ++i) {
      const auto& own = surface_->planes[part_[i]].corners;
      Flat sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += weights_[i][k] * (places_[vertices_[i][(k + 1) % 3]] - places_[vertices_[i][k]]) *
               std::conj(own[(k + 1) % 3] - own[k]);
      const Flat rotation = std::abs(sum) > 0 ? sum / std::abs(sum) : Flat(1);
      for (std::size_t k = 0; k < 3; ++k) {
        const Flat edge = weights_[i][k] * rotation * (own[(k + 1) % 3] - own[k]);
        const Eigen::RowVector2d step(edge.real(), edge.imag());
        sums.row(vertex(i, k + 1)) += step;
        sums.row(vertex(i, k)) -= step;
      }
    }
    sums.row(0) += anchor * Eigen::RowVector2d(places_[0].real(), places_[0].imag());
    return sums;
  }

  void relax() {
    const Eigen::SimplicialLDLT<Matrix> solver(laplacian());
    for (int round = 0; round < rounds; ++round) {
      const Eigen::MatrixX2d solved = solver.solve(wanted());
      for (std::size_t v = 0; v < places_.size(); ++v)
        places_[v] = {solved(static_cast<Eigen::Index>(v), 0), solved(static_cast<Eigen::Index>(v), 1)};
    }
  }

  static constexpr double anchor = 1e-6;  ///< the whole may lie anywhere
  static constexpr int rounds = 20;
  const CutSurface* surface_;
  std::vector<std::size_t> part_;
  std::vector<std::array<std::size_t, 3>> vertices_{};
  std::vector<Flat> places_{};
  std::vector<std::array<double, 3>> weights_{};  ///< of the edges from corner k of a face to the next
};

[[nodiscard]] inline double quantile(const std::vector<std::array<double, 2>>& values, double share) {
  double total = 0, sum = 0;
  for (const auto& [value, weight] : values) total += weight;
  for (const auto& [value, weight] : values) {
    sum += weight;
    if (sum >= share * total) return value;
  }
  return values.back()[0];
}

/// Cuts a surface until every part lies flat.
class Flattening {
 public:
  Flattening(const geometry::Mesh& mesh, std::vector<std::size_t> faces, double most)
      : surface_(mesh, std::move(faces)), most_(most) {}

  [[nodiscard]] std::vector<FlatPart> parts() {
    std::vector<std::size_t> all(surface_.faces.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    waiting_ = surface_.connected(all);
    while (!waiting_.empty()) {
      FlatLayout layout(surface_, std::move(waiting_.back()));
      waiting_.pop_back();
      if (layout.part().size() == 1 || is_flat(layout)) {
        done_.push_back(std::move(layout));
        continue;
      }
      for (auto& half : halves(layout.part())) waiting_.push_back(std::move(half));
    }
    join();
    std::vector<FlatPart> flat;
    for (const auto& layout : done_) flat.push_back(made(*layout));
    return flat;
  }

 private:
  [[nodiscard]] bool is_flat(const FlatLayout& layout) const {
    if (layout.overlaps_or_flips()) return false;
    const auto scales = layout.scales();
    return quantile(scales, 0.005) >= 1 / most_ && quantile(scales, 0.995) <= most_;
  }

  [[nodiscard]] FlatPart made(const FlatLayout& layout) const {
    FlatPart flat;
    flat.rim = layout.rim();
    for (std::size_t i = 0; i < layout.part().size(); ++i) {
      flat.faces.push_back(surface_.faces[layout.part()[i]]);
      const auto corners = layout.flat(i);
      auto& places = flat.places.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) places[k] = {corners[k].real(), corners[k].imag()};
    }
    const auto scales = layout.scales();
    flat.stretch = {quantile(scales, 0.05), quantile(scales, 0.95)};
    return flat;
  }

  [[nodiscard]] const geometry::Vector3& farthest_normal(const std::vector<std::size_t>& part,
                                                         const geometry::Vector3& from) const {
    const auto along = [&](std::size_t i) { return geometry::dot(surface_.normals[i], from); };
    return surface_.normals[*std::ranges::min_element(part, {}, along)];
  }

  /// Two groups of normals, by area, with borders that are short.
  [[nodiscard]] std::vector<std::vector<std::size_t>> halves(const std::vector<std::size_t>& part) const {
    std::array<geometry::Vector3, 2> centres{};
    centres[0] = farthest_normal(part, surface_.normals[part.front()]);
    centres[1] = farthest_normal(part, centres[0]);
    std::map<std::size_t, std::size_t> side;
    double area = 0;
    for (const std::size_t i : part) area += surface_.planes[i].area;
    const double border_price = 0.015 * std::sqrt(area);
    for (int round = 0; round < 12; ++round) {
      std::array<geometry::Vector3, 2> sums{};
      for (const std::size_t i : part) {
        std::array<double, 2> cost{};
        for (std::size_t s = 0; s < 2; ++s) {
          const auto off = geometry::subtract(surface_.normals[i], centres[s]);
          cost[s] = surface_.planes[i].area * geometry::dot(off, off);
        }
        for (const auto& border : surface_.borders[i])
          if (const auto other = side.find(border.other); other != side.end())
            cost[1 - other->second] += border_price * border.length;
        const std::size_t chosen = cost[1] < cost[0] ? 1 : 0;
        side[i] = chosen;
        sums[chosen] =
            geometry::add(sums[chosen], geometry::scale(surface_.normals[i], surface_.planes[i].area));
      }
      for (std::size_t s = 0; s < 2; ++s)
        if (geometry::length(sums[s]) > 0) centres[s] = geometry::normalised(sums[s]);
    }
    std::array<std::vector<std::size_t>, 2> groups;
    for (const std::size_t i : part) groups[side[i]].push_back(i);
    if (groups[0].empty() || groups[1].empty()) groups = cut_in_the_middle(part);
    std::vector<std::vector<std::size_t>> parts;
    for (const auto& group : groups)
      for (auto& connected : surface_.connected(group)) parts.push_back(std::move(connected));
    return parts;
  }

  [[nodiscard]] std::array<std::vector<std::size_t>, 2> cut_in_the_middle(
      const std::vector<std::size_t>& part) const {
    const auto middle = [&](std::size_t i) {
      geometry::Vector3 sum{0, 0, 0};
      for (const std::size_t corner : surface_.corners[i])
        for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += surface_.positions[corner][axis] / 3;
      return sum;
    };
    std::vector<geometry::Vector3> middles;
    for (const std::size_t i : part) middles.push_back(middle(i));
    const auto bounds = geometry::bounds_of(middles);
    const auto extents = geometry::subtract(bounds.high, bounds.low);
    const auto axis = static_cast<std::size_t>(std::ranges::max_element(extents) - extents.begin());
    std::vector<std::size_t> order = part;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return middle(i)[axis]; });
    const auto half = order.begin() + static_cast<std::ptrdiff_t>(order.size() / 2);
    return {std::vector(order.begin(), half), std::vector(half, order.end())};
  }

  /// Joins small parts to those they have the longest border with, where both lie flat together.
  void join() {
    std::vector<std::size_t> owner(surface_.faces.size());
    for (std::size_t p = 0; p < done_.size(); ++p)
      for (const std::size_t i : done_[p]->part()) owner[i] = p;
    const auto area_of = [&](std::size_t p) {
      double sum = 0;
      for (const std::size_t i : done_[p]->part()) sum += surface_.planes[i].area;
      return sum;
    };
    std::vector<std::size_t> order(done_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, {}, area_of);
    for (const std::size_t p : order) {
      std::map<std::size_t, double> borders;
      for (const std::size_t i : done_[p]->part())
        for (const auto& border : surface_.borders[i])
          if (owner[border.other] != p) borders[owner[border.other]] += border.length;
      std::vector<std::pair<double, std::size_t>> tries;
      for (const auto& [other, length] : borders) tries.push_back({-length, other});
      std::ranges::sort(tries);
      for (std::size_t k = 0; k < std::min<std::size_t>(tries.size(), 3); ++k) {
        const std::size_t other = tries[k].second;
        std::vector<std::size_t> both = done_[other]->part();
        both.insert(both.end(), done_[p]->part().begin(), done_[p]->part().end());
        FlatLayout joined(surface_, std::move(both));
        if (!is_flat(joined)) continue;
        for (const std::size_t i : done_[p]->part()) owner[i] = other;
        done_[other] = std::move(joined);
        done_[p].reset();
        break;
      }
    }
    std::erase_if(done_, [](const auto& layout) { return !layout; });
  }

  CutSurface surface_;
  double most_;
  std::vector<std::vector<std::size_t>> waiting_{};
  std::vector<std::optional<FlatLayout>> done_{};  ///< empty where it was joined to another
};
}  // namespace detail

/// Lays faces of a mesh flat, in the fewest parts that keep lengths.
/// \param faces  with area
/// \param most   largest stretch of a part, but for a hundredth of its area
[[nodiscard]] inline std::vector<FlatPart> flattened(const geometry::Mesh& mesh,
                                                     std::vector<std::size_t> faces, double most = 1.02) {
  return detail::Flattening(mesh, std::move(faces), most).parts();
}
}  // namespace tapestry::shell
