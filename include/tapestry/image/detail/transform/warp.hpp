#pragma once
#include <optional>
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/detail/transform/matrix3.hpp>

namespace tapestry::image {
/// A picture seen through another homography: by a camera that was turned or zoomed about its place, or moved
/// by any affine map. Coordinates are half widths of the picture from its middle, x to the right and y down,
/// so that one warp serves pictures of any size.
struct Warp {
  Matrix3<double> source_from_target = identity3;  ///< homogeneous, invertible
};

/// Rotation of a camera about its place, and zoom.
struct CameraMotion {
  double pan_rad = 0;   ///< to the right
  double tilt_rad = 0;  ///< down
  double roll_rad = 0;  ///< clockwise as seen from behind it
  double zoom = 1;      ///< of its focal length, above 0
  double focal = 1;     ///< focal length before it, in half widths of the picture; 1 is a view of 90°
};

/// The warp from the first camera's picture to the moved one's: K·Rᵀ·K′⁻¹, exact for a scene at any depth.
/// Source: Hartley and Zisserman, "Multiple view geometry in computer vision" (2004), section 8.4.
/// \throws DomainError unless zoom and focal are above 0
[[nodiscard]] Warp warp_of(const CameraMotion& motion);

/// Places of a picture's points after a warp, both in pixels from the upper left corner.
class WarpedPoint {
 public:
  WarpedPoint(const Warp& warp, std::size_t height, std::size_t width);

  /// Nothing for a point that lies behind the moved camera.
  [[nodiscard]] std::optional<std::array<double, 2>> operator()(double x, double y) const;

 private:
  Matrix3<double> target_from_source_;
  double middle_x_, middle_y_;
};

/// The picture through the warp, resampled bilinearly; it continues beyond its edges with the edge's values.
///
/// \param picture  [H, W, C], not empty
/// \returns        [H, W, C]
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const Warp& warp);

/// Adds the transpose of transformed() times `out_adjoint` to `picture_adjoint`, pixel by pixel in order; all
/// are [H, W, C].
/// \throws ShapeError if their extents differ
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const Warp& warp, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint);
}  // namespace tapestry::image
