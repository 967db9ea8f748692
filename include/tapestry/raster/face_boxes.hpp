#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/pixel_rays.hpp>
#include <tapestry/raster/view_clip.hpp>
#include <vector>

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

/// A position as a picture shows it.
struct PicturePlace {
  std::array<double, 2> point;
  double inverse_depth;
  unsigned outside;  ///< see ViewClip::outside()
  bool is_usable;
};

inline std::vector<PicturePlace> picture_places(const std::vector<geometry::Vector3>& positions_view,
                                                const PixelRays& rays, const ViewClip& clip) {
  std::vector<PicturePlace> places(positions_view.size());
  constexpr std::size_t block = 4096;
  parallel_for(block_count(places.size(), block), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, places.size(), block);
    for (std::size_t i = begin; i < end; ++i) {
      const geometry::Vector3& view = positions_view[i];
      places[i] = {rays.picture_point(view), 1 / view[2], clip.outside(view), usable(view)};
    }
  });
  return places;
}

inline void add_point(FaceBox& box, const std::array<double, 2>& point, double inverse_depth) {
  for (std::size_t axis = 0; axis < 2; ++axis) {
    box.low[axis] = std::min(box.low[axis], point[axis]);
    box.high[axis] = std::max(box.high[axis], point[axis]);
  }
  box.inverse_depth_min = std::min(box.inverse_depth_min, inverse_depth * (1 - 1e-9));
  box.inverse_depth_max = std::max(box.inverse_depth_max, inverse_depth * (1 + 1e-9));
}

}  // namespace detail

/// The box of each face between near and far, cut to the picture; empty for those that are not in it or have
/// a corner that is not finite.
[[nodiscard]] inline std::vector<FaceBox> face_boxes(const geometry::Mesh& mesh,
                                                     const std::vector<geometry::Vector3>& positions_view,
                                                     const geometry::Camera& camera, std::size_t height,
                                                     std::size_t width) {
  const PixelRays rays(camera, height, width);
  const ViewClip clip(camera, height, width);
  const auto places = detail::picture_places(positions_view, rays, clip);
  const std::array<double, 2> size{static_cast<double>(width), static_cast<double>(height)};
  std::vector<FaceBox> boxes(mesh.faces.size());
  constexpr std::size_t block = 4096;
  parallel_for(block_count(boxes.size(), block), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, boxes.size(), block);
    for (std::size_t face = begin; face < end; ++face) {
      std::array<geometry::Vector3, 3> corners;
      unsigned all = ~0U, any = 0;
      bool is_usable = true;
      FaceBox box{size, {0, 0}};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto corner = static_cast<std::size_t>(mesh.faces[face][k]);
        const detail::PicturePlace& place = places[corner];
        corners[k] = positions_view[corner];
        all &= place.outside;
        any |= place.outside;
        is_usable = is_usable && place.is_usable;
        detail::add_point(box, place.point, place.inverse_depth);
      }
      if (!is_usable || (all & ViewClip::invisible) != 0) continue;
      if ((any & ViewClip::needs_cut) != 0) {
        const ViewClip::Polygon polygon = clip.cut(corners);
        box = {size, {0, 0}};
        for (std::size_t i = 0; polygon.size >= 3 && i < polygon.size; ++i)
          detail::add_point(box, rays.picture_point(polygon.points[i]), 1 / polygon.points[i][2]);
      }
      for (std::size_t axis = 0; axis < 2; ++axis) {
        box.low[axis] = std::max(box.low[axis], 0.0);
        box.high[axis] = std::min(box.high[axis], size[axis]);
      }
      boxes[face] = box;
    }
  });
  return boxes;
}

}  // namespace tapestry::raster
