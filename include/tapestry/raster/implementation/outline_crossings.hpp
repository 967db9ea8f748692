#pragma once
#include <tapestry/raster/deferred.hpp>
#include <tapestry/raster/visibility.hpp>

namespace tapestry::raster::detail {
/// Point where the ray of a pixel meets its face, see barycentrics().
struct SeenPoint {
  std::array<geometry::Vector3, 3> corners;  ///< q, view space
  geometry::Vector3 ray;                     ///< d
  geometry::Vector3 barycentric{};           ///< b; 0 if the face is edge-on
  double sum = 0;                            ///< c_0 + c_1 + c_2

  SeenPoint(const std::array<geometry::Vector3, 3>& of_face, const geometry::Vector3& direction)
      : corners(of_face), ray(direction) {
    geometry::Vector3 c;
    for (std::size_t k = 0; k < 3; ++k)
      c[k] = geometry::dot(ray, geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]));
    sum = c[0] + c[1] + c[2];
    const geometry::Vector3 found = geometry::scale(c, 1 / sum);
    if (geometry::is_finite(found)) barycentric = found;
  }

  /// z of view space.
  [[nodiscard]] double depth() const {
    return barycentric[0] * corners[0][2] + barycentric[1] * corners[1][2] + barycentric[2] * corners[2][2];
  }

  /// Adjoints of the corners in view space. With g_k = (adjoint_k - adjoint · b) / sum, each product's
  /// derivative is
  ///   dL/dq_{k+1} += g_k q_{k+2} x d,   dL/dq_{k+2} += g_k d x q_{k+1}.
  [[nodiscard]] std::array<geometry::Vector3, 3> adjoint_of(const geometry::Vector3& adjoint) const {
    std::array<geometry::Vector3, 3> result{};
    if (barycentric == geometry::Vector3{}) return result;
    const double mean = geometry::dot(adjoint, barycentric);
    for (std::size_t k = 0; k < 3; ++k) {
      const double g = (adjoint[k] - mean) / sum;
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      result[i] = geometry::add(result[i], geometry::scale(geometry::cross(corners[j], ray), g));
      result[j] = geometry::add(result[j], geometry::scale(geometry::cross(ray, corners[i]), g));
    }
    return result;
  }
};

/// The points that a picture's pixels see.
class SeenPoints {
 public:
  explicit SeenPoints(const PixelFaces& pixels)
      : pixels_(pixels),
        positions_(positions_in_view(*pixels.mesh, pixels.camera)),
        rays_(pixels.camera, pixels.height, pixels.width) {}

  [[nodiscard]] const geometry::Vector3& position(std::int32_t index) const {
    return positions_[static_cast<std::size_t>(index)];
  }
  [[nodiscard]] const geometry::Corners& corners(std::int32_t face) const {
    return pixels_.mesh->faces[static_cast<std::size_t>(face)];
  }
  [[nodiscard]] geometry::Vector3 ray(std::size_t pixel) const {
    return rays_.at(static_cast<double>(pixel % pixels_.width) + 0.5,
                    static_cast<double>(pixel / pixels_.width) + 0.5);
  }
  /// \pre the pixel shows a face
  [[nodiscard]] SeenPoint operator[](std::size_t pixel) const {
    const auto& [a, b, c] = corners(pixels_.face[pixel]);
    return {{position(a), position(b), position(c)}, ray(pixel)};
  }
  /// Adds the adjoint of its view coordinates to a position's adjoint.
  void add(const geometry::Vector3& view_adjoint, std::int32_t index,
           std::vector<geometry::Vector3>& positions_adjoint) const {
    auto& to = positions_adjoint[static_cast<std::size_t>(index)];
    to = geometry::add(to, geometry::multiply_transposed(pixels_.camera.rotation, view_adjoint));
  }

 private:
  const PixelFaces& pixels_;
  std::vector<geometry::Vector3> positions_;
  PixelRays rays_;
};

/// Crossing of an outline between the centres of two pixels: n · d = 0 with n = p x q, p and q the ends of
/// the edge in view space, at the share s = A / (A - B) of the way, A = n · d_from and B = n · d_to.
struct OutlineCrossing {
  std::size_t from, to;  ///< pixels
  std::int32_t p, q;     ///< positions
  double a, b;           ///< A and B, of unlike signs

  [[nodiscard]] double share() const { return a / (a - b); }
  [[nodiscard]] std::size_t target() const { return share() > 0.5 ? to : from; }
  [[nodiscard]] std::size_t other() const { return share() > 0.5 ? from : to; }
  [[nodiscard]] double weight() const { return std::abs(share() - 0.5); }
};

/// Finds the crossings of a picture.
class OutlineSearch {
 public:
  explicit OutlineSearch(const PixelFaces& pixels)
      : pixels_(pixels), points_(pixels), edge_of_(3 * pixels.mesh->faces.size(), no_edge) {
    for (std::size_t edge = 0; edge < pixels.edges->size(); ++edge)
      for (const HalfEdge& half : pixels.edges->of(edge))
        edge_of_[static_cast<std::size_t>(3 * half.face + half.corner)] = static_cast<std::uint32_t>(edge);
  }

  [[nodiscard]] const SeenPoints& points() const { return points_; }

  /// Crossings in the order of pixels; for each the pair along the row comes first.
  [[nodiscard]] std::vector<OutlineCrossing> crossings() const {
    std::vector<std::vector<OutlineCrossing>> of_row(pixels_.height);
    parallel_for(pixels_.height, [&](std::size_t row) {
      for (std::size_t column = 0; column < pixels_.width; ++column) {
        const std::size_t pixel = row * pixels_.width + column;
        if (column + 1 < pixels_.width) add_pair(pixel, pixel + 1, of_row[row]);
        if (row + 1 < pixels_.height) add_pair(pixel, pixel + pixels_.width, of_row[row]);
      }
    });
    std::vector<OutlineCrossing> all;
    for (const auto& row : of_row) all.insert(all.end(), row.begin(), row.end());
    return all;
  }

 private:
  static constexpr std::uint32_t no_edge = 0xFFFFFFFFU;

  void add_pair(std::size_t from, std::size_t to, std::vector<OutlineCrossing>& found) const {
    const std::int32_t first = pixels_.face[from], second = pixels_.face[to];
    if (first == second) return;
    const bool is_first = second < 0 || (first >= 0 && points_[from].depth() <= points_[to].depth());
    const std::int32_t face = is_first ? first : second;
    const auto d_from = points_.ray(from), d_to = points_.ray(to);
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::int32_t p = points_.corners(face)[corner], q = points_.corners(face)[(corner + 1) % 3];
      const auto &at_p = points_.position(p), &at_q = points_.position(q);
      const auto n = geometry::cross(at_p, at_q);
      const OutlineCrossing crossing{from, to, p, q, geometry::dot(n, d_from), geometry::dot(n, d_to)};
      if (!(crossing.a * crossing.b < 0)) continue;
      const auto way = geometry::scale(geometry::subtract(d_to, d_from), crossing.share());
      const auto ray = geometry::add(d_from, way);  // between p and q where both parts are not negative
      if (geometry::dot(geometry::cross(at_p, ray), n) < 0 ||
          geometry::dot(geometry::cross(ray, at_q), n) < 0)
        continue;
      if (is_outline(face, corner, n)) found.push_back(crossing);
      return;  // a ray leaves a face through one edge
    }
  }

  /// Whether all faces at an edge lie on one side of the plane through it and the eye, of normal n.
  [[nodiscard]] bool is_outline(std::int32_t face, std::size_t corner, const geometry::Vector3& n) const {
    const std::uint32_t edge = edge_of_[3 * static_cast<std::size_t>(face) + corner];
    if (edge == no_edge) return true;
    const auto side = [&](const HalfEdge& half) {
      const auto opposite = static_cast<std::size_t>((half.corner + 2) % 3);
      return geometry::dot(n, points_.position(points_.corners(half.face)[opposite]));
    };
    const double own = side({face, static_cast<std::int32_t>(corner)});
    const auto halves = pixels_.edges->of(edge);
    return std::none_of(halves.begin(), halves.end(),
                        [&](const HalfEdge& half) { return side(half) * own < 0; });
  }

  const PixelFaces& pixels_;
  SeenPoints points_;
  std::vector<std::uint32_t> edge_of_;  ///< by half-edge
};

/// Adds the derivatives by the ends of a crossing's edge, given that by its share s: with
///   ds/dA = -B / (A - B)^2,   ds/dB = A / (A - B)^2,   dL/dn = dL/dA d_from + dL/dB d_to,
///   dL/dp = q x dL/dn,   dL/dq = dL/dn x p.
inline void add_crossing(const OutlineCrossing& crossing, const SeenPoints& points, double share_adjoint,
                         std::vector<geometry::Vector3>& positions_adjoint) {
  const double scale = share_adjoint / ((crossing.a - crossing.b) * (crossing.a - crossing.b));
  const auto by_n = geometry::add(geometry::scale(points.ray(crossing.from), -crossing.b * scale),
                                  geometry::scale(points.ray(crossing.to), crossing.a * scale));
  points.add(geometry::cross(points.position(crossing.q), by_n), crossing.p, positions_adjoint);
  points.add(geometry::cross(by_n, points.position(crossing.p)), crossing.q, positions_adjoint);
}
}  // namespace tapestry::raster::detail
