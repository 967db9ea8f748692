#pragma once
#include <tapestry/geometry/camera.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {

/// Steps in an atlas for a step of a column and of a row in the picture, in texels, rows downwards: {columns,
/// rows} for the first, then for the second. A pixel's circle becomes an ellipse there, its footprint.
using AtlasSteps = std::array<double, 4>;

/// Map from the points of a face to their places in an atlas, and to the footprint of a pixel there.
///
/// With c_k = q_{k+1} × q_{k+2}, C = Σ c_k, D = q₀·c₀ and the depth z = Σ b_k z_k of a point,
///   ∂b_k/∂column = z · 2·tan_half_fov_x/width · (c_k − b_k·C)_x / D,
/// and for rows the same with y. All zero for a face that is seen edge-on.
class FaceInAtlas {
 public:
  /// \param corners_view  q₀, q₁, q₂
  /// \param corner_uvs    uvs of these corners
  FaceInAtlas(const std::array<geometry::Vector3, 3>& corners_view,
              const std::array<std::array<double, 2>, 3>& corner_uvs, const TextureLayout& layout,
              const geometry::Camera& camera, double height, double width)
      : size_{static_cast<double>(layout.width), static_cast<double>(layout.height)} {
    std::array<geometry::Vector3, 3> c{};
    geometry::Vector3 total{};
    for (std::size_t k = 0; k < 3; ++k) {
      c[k] = geometry::cross(corners_view[(k + 1) % 3], corners_view[(k + 2) % 3]);
      total = geometry::add(total, c[k]);
      depth_[k] = corners_view[k][2];
      place_[k] = {corner_uvs[k][0] / layout.u_extent, 1 - corner_uvs[k][1]};
    }
    const double inverse = 1 / geometry::dot(corners_view[0], c[0]);
    if (!std::isfinite(inverse)) return;
    const std::array<double, 2> pixel{2 * camera.tan_half_fov_x / width * inverse,
                                      2 * camera.tan_half_fov_y / height * inverse};
    for (std::size_t way = 0; way < 2; ++way) {
      turn_[way] = pixel[way] * total[way];
      for (std::size_t axis = 0; axis < 2; ++axis)  // relative to a corner: the sums of c_k leave it out
        steps_[2 * way + axis] = pixel[way] * size_[axis] *
                                 ((place_[1][axis] - place_[0][axis]) * c[1][way] +
                                  (place_[2][axis] - place_[0][axis]) * c[2][way]);
    }
  }

  /// {column, row} of a point, in units of the atlas, row 0 on top.
  /// \param b  its barycentric coordinates
  [[nodiscard]] std::array<double, 2> place(const std::array<double, 3>& b) const {
    std::array<double, 2> sum{0, 0};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 2; ++axis) sum[axis] += b[k] * place_[k][axis];
    return sum;
  }

  /// \param b      a point's barycentric coordinates
  /// \param scale  of the pixel
  [[nodiscard]] AtlasSteps steps(const std::array<double, 3>& b, double scale = 1) const {
    const double z = (b[0] * depth_[0] + b[1] * depth_[1] + b[2] * depth_[2]) * scale;
    AtlasSteps steps{};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double away = size_[axis] * (b[1] * (place_[1][axis] - place_[0][axis]) +
                                         b[2] * (place_[2][axis] - place_[0][axis]));
      for (std::size_t way = 0; way < 2; ++way)
        steps[2 * way + axis] = z * (steps_[2 * way + axis] - away * turn_[way]);
    }
    return steps;
  }

 private:
  std::array<double, 2> size_;
  std::array<std::array<double, 2>, 3> place_{};
  std::array<double, 3> depth_{};
  AtlasSteps steps_{0, 0, 0, 0};      ///< at the first corner, to a depth of 1
  std::array<double, 2> turn_{0, 0};  ///< change of the steps over the face
};

}  // namespace tapestry::raster
