#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/io/npz_file.hpp>
#include <vector>

namespace tapestry::io {

namespace detail {
template <std::size_t N>
void require_finite(const std::array<double, N>& values, const std::string& path, const char* member) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      throw FileError(ErrorKind::mismatch,
                      {.path = path, .what = std::string(member) + " holds a value that is not finite"});
    }
  }
}

/// The numbers of a member of exactly this shape.
template <std::size_t N>
std::array<double, N> numbers(const NpzFile& file, const char* member,
                              const std::vector<std::size_t>& shape) {
  const NpyArray& array = file.get(member);
  if (array.shape != shape) {
    throw FileError(ErrorKind::mismatch, {.path = file.path(),
                                          .what = "member '" + std::string(member) + "' has another shape",
                                          .expected = shape_text(shape),
                                          .found = shape_text(array.shape)});
  }
  const auto values = array.as<double>();
  std::array<double, N> result{};
  std::copy(values.begin(), values.end(), result.begin());
  require_finite(result, file.path(), member);
  return result;
}

Array<std::uint8_t, 2> read_mask(const NpzFile& file, std::size_t height, std::size_t width);

}  // namespace detail

/// Reads and validates a frame file: an .npz with the members of the CARLA set of Wang et al. (DAS, FCA),
/// `img` uint8 [H, W, 3] stored as BGR, `veh_trans` and `cam_trans` float64 [2, 3] (row 0 metres, row 1
/// pitch, yaw, roll in degrees; the camera's translation is its offset from the vehicle along world axes).
/// Frames of our own add `camera_matrix` float64 [3, 4] (view_from_world, rotation and translation) with
/// `camera_fov` float64 [2] (tangents of half the field of view), need no poses then, and may add `light`
/// float64 [8], `mask` uint8 [H, W] and `label` float64 [5].
///
/// \throws FileError: malformed (damaged file); mismatch (a member is missing, has another shape or type, or
///         holds what cannot be: values not finite, a camera in the vehicle's origin, an empty picture);
///         limit
[[nodiscard]] Frame read_frame(const std::string& path);

/// Writes a frame so that read_frame() gives it back; deflated, the whole file or nothing.
/// \throws ShapeError unless the picture is [H, W, 3] and the mask, if any, [H, W]; FileError (write)
void write_frame(const std::string& path, const Frame& frame);

}  // namespace tapestry::io
