#pragma once
#include <limits>
#include <tapestry/raster/detail/pixel_rays.hpp>
#include <tapestry/raster/detail/view_clip.hpp>

namespace tapestry::raster {

/// The part of a picture that a face may touch, in pixels, {column, row}, and its 1/z; empty when low > high.
struct FaceBox {
  std::array<double, 2> low{1, 1};
  std::array<double, 2> high{0, 0};
  double inverse_depth_min = std::numeric_limits<double>::infinity();
  double inverse_depth_max = 0;

  [[nodiscard]] bool is_empty() const { return !(low[0] <= high[0] && low[1] <= high[1]); }
};

namespace detail {

inline void add_point(FaceBox& box, const std::array<double, 2>& point, double inverse_depth) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    box.low[axis] = std::min(box.low[axis], point[axis]);
    box.high[axis] = std::max(box.high[axis], point[axis]);
  }
  box.inverse_depth_min = std::min(box.inverse_depth_min, inverse_depth * (1 - 1e-9));
  box.inverse_depth_max = std::max(box.inverse_depth_max, inverse_depth * (1 + 1e-9));
}

}  // namespace detail

/// The frame that boxes of faces are measured in.
struct PictureFrame {
  PixelRays rays;
  ViewClip clip;
  std::array<double, 2> size;  ///< columns, rows

  PictureFrame(const geometry::Camera& camera, std::size_t height, std::size_t width)
      : rays(camera, height, width),
        clip(camera, height, width),
        size{static_cast<double>(width), static_cast<double>(height)} {}

  /// The box of a face between near and far, cut to the picture; empty if it lies outside.
  /// \param corners  in view space, usable()
  [[nodiscard]] FaceBox box_of(const std::array<geometry::Vector3, 3>& corners) const {
    unsigned all = ~0U, any = 0;
    for (const geometry::Vector3& corner : corners) {
      const unsigned outside = clip.outside(corner);
      all &= outside;
      any |= outside;
    }
    if ((all & ViewClip::invisible) != 0) return {};
    FaceBox box{size, {0, 0}};
    if ((any & ViewClip::needs_cut) == 0) {
      for (const geometry::Vector3& corner : corners)
        detail::add_point(box, rays.picture_point(corner), 1 / corner[2]);
    } else {
      const ViewClip::Polygon polygon = clip.cut(corners);
      for (std::size_t i = 0; polygon.size >= 3 && i < polygon.size; ++i)
        detail::add_point(box, rays.picture_point(polygon.points[i]), 1 / polygon.points[i][2]);
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      box.low[axis] = std::max(box.low[axis], 0.0);
      box.high[axis] = std::min(box.high[axis], size[axis]);
    }
    return box;
  }
};

}  // namespace tapestry::raster
