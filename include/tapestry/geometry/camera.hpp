#pragma once
#include <array>

namespace tapestry::geometry {

/// A pinhole camera without a resolution: pictures of any size share it.
///
/// View space has x to the right, y down and z forward (right-handed), in the units of the world.
/// A point p of the world has the view coordinates q = R·p + t and the picture coordinates
///   column = (1 + q.x / (q.z · tan_half_fov_x)) / 2 · width,
///   row    = (1 + q.y / (q.z · tan_half_fov_y)) / 2 · height;
/// pixel (row i, column j) covers [j, j+1) × [i, i+1), its centre is at +½.
struct Camera {
  std::array<std::array<double, 3>, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< R, view_from_world
  std::array<double, 3> translation{0, 0, 0};                                        ///< t, view_from_world
  double tan_half_fov_x = 1;
  double tan_half_fov_y = 1;
  double near = 0.1;  ///< nearer surfaces are clipped; world units
  double far = 1000;  ///< farther surfaces are not drawn; world units
};

}  // namespace tapestry::geometry
