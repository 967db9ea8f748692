#pragma once
#include <tapestry/raster/visibility.hpp>

namespace tapestry::raster {
/// A mesh seen from infinitely far along a direction: decides which of its points a distant light reaches.
///
/// Visibility is computed by the rasteriser and exact at each texel of a square map around the mesh. The
/// projective map (X, Y, H) → (X, Y, 1)/(2 + H) takes the parallel rays of the light to rays through a
/// pinhole, planes to planes, and keeps the order of the heights H towards the light. A point is compared
/// with the planes of the faces in the four texels around it, and the results are weighted bilinearly
/// (percentage-closer filtering, Reeves, Salesin & Cook 1987). The receiver is taken as the plane of its own
/// face, so a plane does not shadow itself, however low the light is.
class ParallelView {
 public:
  /// \param mesh     faces with a corner that is not finite are left out
  /// \param towards  the light or the eye, any length but 0
  /// \param pixels   texels of the map along an axis, 1 to 32768
  /// \throws DomainError for a direction without a length, or such a map; Error (mismatch) if a face refers
  ///         to a missing position
  ParallelView(const geometry::Mesh& mesh, const geometry::Vector3& towards, std::size_t pixels)
      : pixels_(pixels) {
    axes_[2] = geometry::normalised(towards);
    if (!(geometry::length(axes_[2]) > 0.5)) throw DomainError("parallel view: the direction needs a length");
    const auto& [x, y, z] = axes_[2];
    const bool is_along_x = std::abs(x) < std::abs(y) && std::abs(x) < std::abs(z);
    const geometry::Vector3 other = is_along_x                  ? geometry::Vector3{1, 0, 0}
                                    : std::abs(y) < std::abs(z) ? geometry::Vector3{0, 1, 0}
                                                                : geometry::Vector3{0, 0, 1};
    axes_[0] = geometry::normalised(geometry::cross(axes_[2], other));
    axes_[1] = geometry::cross(axes_[2], axes_[0]);
    const double half_height = fit(mesh);
    geometry::Mesh seen;
    seen.faces = mesh.faces;
    seen.positions.resize(mesh.positions.size());
    for (std::size_t i = 0; i < seen.positions.size(); ++i) {
      const geometry::Vector3 texel = in_texels(mesh.positions[i]);
      const double size = static_cast<double>(pixels), z_seen = 1 / (2 + texel[2] / half_height);
      seen.positions[i] = {(2 * texel[0] / size - 1) * z_seen, (2 * texel[1] / size - 1) * z_seen, z_seen};
    }
    faces_ = visibility(seen, geometry::Camera{}, pixels, pixels, 1).face;
    set_planes(mesh);
  }

  /// Share of the light that reaches a point, in [0, 1], whichever side of its face is lit.
  /// \param face   that the point lies on
  /// \param point  in the world
  [[nodiscard]] double visible_share(std::size_t face, const geometry::Vector3& point) const {
    const geometry::Vector3 at = in_texels(point);
    if (!geometry::is_finite(at)) return 1;
    const Plane own = planes_[face];
    const double column = std::floor(at[0] - 0.5), row = std::floor(at[1] - 0.5);
    const double right = at[0] - 0.5 - column, below = at[1] - 0.5 - row;
    double hidden = 0;
    for (int tap = 0; tap < 4; ++tap) {
      const double u = column + (tap & 1), v = row + (tap >> 1);
      const double weight = ((tap & 1) != 0 ? right : 1 - right) * ((tap >> 1) != 0 ? below : 1 - below);
      if (weight > 0 && hides(u, v, face, own, at)) hidden += weight;
    }
    return 1 - hidden;
  }

  /// Number of faces of the mesh that this view was made of.
  [[nodiscard]] std::size_t face_count() const { return planes_.size(); }

 private:
  /// height = per_column · (column + ½) + per_row · (row + ½) + first, all in texels
  struct Plane {
    double per_column = 0, per_row = 0, first = 0;
  };

  /// Column and row of a point in the map, and its height above the middle of the mesh, in texels.
  [[nodiscard]] geometry::Vector3 in_texels(const geometry::Vector3& point) const {
    return geometry::add(geometry::scale(geometry::multiply(axes_, point), per_unit_), shift_);
  }

  /// Puts the mesh in the middle of the map.
  /// \returns half of its height, in texels
  double fit(const geometry::Mesh& mesh) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    geometry::Vector3 low{infinity, infinity, infinity}, high{-infinity, -infinity, -infinity};
    for (const auto& position : mesh.positions) {
      if (!geometry::is_finite(position)) continue;
      const geometry::Vector3 at = geometry::multiply(axes_, position);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::min(low[axis], at[axis]);
        high[axis] = std::max(high[axis], at[axis]);
      }
    }
    const double side = std::max(high[0] - low[0], high[1] - low[1]), size = static_cast<double>(pixels_);
    if (!(side > 0) || !std::isfinite(side)) return 1;  // nothing that could hide anything
    per_unit_ = size / (side * (1 + 2 / size));
    for (std::size_t axis = 0; axis < 3; ++axis)
      shift_[axis] = (axis < 2 ? size / 2 : 0) - per_unit_ * (low[axis] + high[axis]) / 2;
    return std::max(per_unit_ * (high[2] - low[2]) / 2, 1e-9);
  }

  void set_planes(const geometry::Mesh& mesh) {
    planes_.resize(mesh.faces.size());
    for (std::size_t face = 0; face < planes_.size(); ++face) {
      std::array<geometry::Vector3, 3> corner;
      for (std::size_t k = 0; k < 3; ++k)
        corner[k] = in_texels(mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])]);
      const auto normal =
          geometry::cross(geometry::subtract(corner[1], corner[0]), geometry::subtract(corner[2], corner[0]));
      const Plane plane{-normal[0] / normal[2], -normal[1] / normal[2],
                        geometry::dot(normal, corner[0]) / normal[2]};
      const bool is_flat = std::isfinite(plane.per_column) && std::isfinite(plane.per_row);
      planes_[face] = is_flat ? plane : Plane{0, 0, corner[0][2]};  // seen edge-on
    }
  }

  /// Whether the face in a texel lies above the receiver there. Faces that meet within a texel differ in
  /// height by up to the difference of their slopes; that much, at most two texels, is not a shadow.
  [[nodiscard]] bool hides(double column, double row, std::size_t face, const Plane& own,
                           const geometry::Vector3& at) const {
    const double size = static_cast<double>(pixels_);
    if (!(column >= 0 && row >= 0 && column < size && row < size)) return false;
    const std::int32_t shown =
        faces_[static_cast<std::size_t>(row) * pixels_ + static_cast<std::size_t>(column)];
    if (shown < 0 || static_cast<std::size_t>(shown) == face) return false;
    const Plane& other = planes_[static_cast<std::size_t>(shown)];
    const double u = column + 0.5, v = row + 0.5;
    const double height = at[2] + own.per_column * (u - at[0]) + own.per_row * (v - at[1]);
    const double slope = std::abs(other.per_column - own.per_column) + std::abs(other.per_row - own.per_row);
    return other.per_column * u + other.per_row * v + other.first > height + 0.05 + std::min(slope, 2.0);
  }

  std::size_t pixels_;
  geometry::Matrix3 axes_{};  ///< of the map: column, row, towards the light
  double per_unit_ = 1;       ///< texels in a unit of the world
  geometry::Vector3 shift_{0, 0, 0};
  std::vector<std::int32_t> faces_;  ///< face that each texel shows, −1 for none
  std::vector<Plane> planes_;
};
}  // namespace tapestry::raster
