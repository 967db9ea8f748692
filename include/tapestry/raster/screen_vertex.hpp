#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/raster/view_clip.hpp>

namespace tapestry::raster {

inline constexpr std::int32_t subpixel_bits = 8;
inline constexpr std::int32_t subpixel_steps = 1 << subpixel_bits;

/// A position on the grid of samples. Everything but `outside` means something only where no plane of
/// ViewClip::needs_cut is crossed.
struct alignas(16) ScreenVertex {
  std::int32_t x;         ///< 1/256 of a sample's width, rounded to nearest
  std::int32_t y;         ///< 1/256 of a sample's height
  std::uint32_t outside;  ///< see ViewClip::outside(), or `unusable`
  float inverse_depth;    ///< 1/z
};

/// Bit of ScreenVertex::outside, alone: a coordinate is not finite, or beyond 1e100.
inline constexpr std::uint32_t unusable = 0x1000;

/// Everything that takes positions of the world to a grid of samples.
struct Projection {
  std::array<std::array<double, 3>, 3> rotation;  ///< view_from_world
  std::array<double, 3> translation;
  double near, far;
  std::array<double, 2> picture;  ///< x/z and y/z of the picture's edges
  std::array<double, 2> guard;    ///< likewise of the guard band
  std::array<double, 2> samples;  ///< per unit of x/z, y/z
  std::array<double, 2> centre;   ///< sample coordinate of x/z = 0, y/z = 0

  Projection(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : rotation(camera.rotation), translation(camera.translation), near(camera.near), far(camera.far) {
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
      const auto count = static_cast<double>(axis == 0 ? sample_columns : sample_rows);
      picture[axis] = axis == 0 ? camera.tan_half_fov_x : camera.tan_half_fov_y;
      guard[axis] = picture[axis] * (2 * ViewClip::guard_samples / count - 1);
      samples[axis] = count / (2 * picture[axis]);
      centre[axis] = count / 2;
    }
  }
};

/// The rays (rx, ry, 1) through the samples of a grid, {x, y}.
struct RayGrid {
  std::array<double, 2> step;   ///< from a sample to the next
  std::array<double, 2> first;  ///< of the first sample's centre

  RayGrid(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : step{2 * camera.tan_half_fov_x / static_cast<double>(sample_columns),
             2 * camera.tan_half_fov_y / static_cast<double>(sample_rows)},
        first{step[0] / 2 - camera.tan_half_fov_x, step[1] / 2 - camera.tan_half_fov_y} {}
};

}  // namespace tapestry::raster
