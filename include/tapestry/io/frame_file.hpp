#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/io/npz_file.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

/// One photographed or rendered view with what is known about it.
///
/// A frame file is an .npz with the members of the CARLA set of Wang et al. (DAS, FCA): `img` uint8 [H, W, 3]
/// stored as BGR, `veh_trans` and `cam_trans` float64 [2, 3] (row 0 metres, row 1 pitch, yaw, roll in
/// degrees; CARLA's axes; the camera's translation is its offset from the vehicle along world axes). Frames
/// of our own add `camera_matrix` float64 [3, 4] (view_from_world, rotation and translation) with
/// `camera_fov` float64 [2] (tangents of half the field of view), and may add `light` float64 [8], `mask`
/// uint8 [H, W] and `label` float64 [5].
struct Frame {
  std::string path;
  Array<std::uint8_t, 3> image;  ///< RGB, [H, W, 3]
  std::array<double, 3> vehicle_translation{};
  std::array<double, 3> vehicle_rotation_deg{};  ///< pitch, yaw, roll
  std::array<double, 3> camera_translation{};
  std::array<double, 3> camera_rotation_deg{};  ///< pitch, yaw, roll
  bool has_camera = false;                      ///< then `camera` replaces the CARLA poses
  geometry::Camera camera;
  bool has_light = false;
  std::array<double, 8> light{};  ///< ambient, directional, direction towards the light x y z, colour r g b
  bool has_mask = false;
  Array<std::uint8_t, 2> mask;  ///< [H, W], 255 on the vehicle
  bool has_label = false;
  std::array<double, 5> label{};      ///< class, cx, cy, w, h; the box in shares of the picture
  std::vector<std::string> warnings;  ///< oddities of the poses; never a reason to refuse
};

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

/// Degrees between the direction of pitch and yaw (CARLA) and the direction from the camera to the vehicle.
inline double degrees_off_target(const Frame& frame, double radians_per_unit) {
  const double pitch = frame.camera_rotation_deg[0] * radians_per_unit;
  const double yaw = frame.camera_rotation_deg[1] * radians_per_unit;
  const auto& offset = frame.camera_translation;
  const double along =
      std::cos(pitch) * (std::cos(yaw) * offset[0] + std::sin(yaw) * offset[1]) + std::sin(pitch) * offset[2];
  const double distance = std::hypot(offset[0], offset[1], offset[2]);
  return std::acos(std::clamp(-along / distance, -1.0, 1.0)) * 180 / 3.14159265358979323846;
}

inline void check_poses(Frame& frame) {
  const auto& offset = frame.camera_translation;
  const double distance = std::hypot(offset[0], offset[1], offset[2]);
  if (!(distance > 1e-6)) {
    throw FileError(ErrorKind::mismatch, {.path = frame.path,
                                          .what = "camera lies in the vehicle's origin",
                                          .expected = "cam_trans row 0 as an offset in metres",
                                          .found = "distance 0"});
  }
  const auto text = [](double value) { return std::to_string(value); };
  if (distance < 2.5)
    frame.warnings.push_back("camera is " + text(distance) + " m from the vehicle's origin, maybe inside it");
  if (std::abs(std::abs(frame.camera_rotation_deg[0]) - 90) < 0.5)
    frame.warnings.push_back("camera looks straight up or down, its yaw is poorly defined");
  constexpr double per_degree = 3.14159265358979323846 / 180;
  const double off = degrees_off_target(frame, per_degree);
  if (off > 25) {
    const bool radians = degrees_off_target(frame, 1) < 5;
    frame.warnings.push_back("camera looks " + text(off) + " degrees past the vehicle" +
                             (radians ? "; its angles look like radians where degrees are expected" : ""));
  }
}

inline void read_poses(const NpzFile& file, Frame& frame) {
  const auto vehicle = numbers<6>(file, "veh_trans", {2, 3});
  const auto camera = numbers<6>(file, "cam_trans", {2, 3});
  for (std::size_t i = 0; i < 3; ++i) {
    frame.vehicle_translation[i] = vehicle[i];
    frame.vehicle_rotation_deg[i] = vehicle[i + 3];
    frame.camera_translation[i] = camera[i];
    frame.camera_rotation_deg[i] = camera[i + 3];
  }
}

inline void read_camera(const NpzFile& file, Frame& frame) {
  const auto matrix = numbers<12>(file, "camera_matrix", {3, 4});
  const auto fov = numbers<2>(file, "camera_fov", {2});
  const auto fail = [&](const char* what, const char* expected) {
    throw FileError(ErrorKind::mismatch, {.path = frame.path, .what = what, .expected = expected});
  };
  if (!(fov[0] > 0 && fov[1] > 0)) fail("member 'camera_fov' is no field of view", "two positive tangents");
  auto& rotation = frame.camera.rotation;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) rotation[row][column] = matrix[4 * row + column];
    frame.camera.translation[row] = matrix[4 * row + 3];
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      double product = 0;
      for (std::size_t k = 0; k < 3; ++k) product += rotation[a][k] * rotation[b][k];
      if (!(std::abs(product - (a == b ? 1 : 0)) <= 1e-6))
        fail("member 'camera_matrix' holds no rotation", "orthonormal rows");
    }
  }
  frame.camera.tan_half_fov_x = fov[0];
  frame.camera.tan_half_fov_y = fov[1];
  frame.has_camera = true;
}

inline void read_extras(const NpzFile& file, Frame& frame) {
  if ((frame.has_light = file.has("light"))) frame.light = numbers<8>(file, "light", {8});
  if ((frame.has_mask = file.has("mask"))) {
    frame.mask = file.array<std::uint8_t, 2>("mask");
    const std::array<std::size_t, 2> picture{frame.image.shape(0), frame.image.shape(1)};
    if (frame.mask.shape() != picture) {
      throw FileError(ErrorKind::mismatch, {.path = frame.path,
                                            .what = "member 'mask' has another size than the picture",
                                            .expected = shape_text(picture),
                                            .found = shape_text(file.get("mask").shape)});
    }
  }
  if ((frame.has_label = file.has("label"))) {
    const auto& label = frame.label = numbers<5>(file, "label", {5});
    const auto inside = [](double share) { return share >= 0 && share <= 1; };
    if (!(label[0] >= 0 && label[0] == std::floor(label[0]) && inside(label[1]) && inside(label[2]) &&
          label[3] > 0 && label[4] > 0 && inside(label[3]) && inside(label[4]))) {
      throw FileError(ErrorKind::mismatch, {.path = frame.path,
                                            .what = "member 'label' is no box of the picture",
                                            .expected = "class, cx, cy, w, h in shares of the picture"});
    }
  }
}

/// The same picture with the first and the last channel exchanged.
inline Array<std::uint8_t, 3> channels_reversed(Array<std::uint8_t, 3> image) {
  for (std::size_t i = 0; i + 2 < image.size(); i += 3) std::swap(image.data()[i], image.data()[i + 2]);
  return image;
}
}  // namespace detail

/// Reads and validates a frame file. The poses may be missing from a file that has a camera matrix.
///
/// \throws FileError: malformed (damaged file); mismatch (a member is missing, has another shape or type, or
/// holds
///         what cannot be: values not finite, a camera in the vehicle's origin, an empty picture); limit
[[nodiscard]] inline Frame read_frame(const std::string& path) {
  const NpzFile file = NpzFile::read(path);
  Frame frame;
  frame.path = path;
  const NpyArray& picture = file.get("img");
  if (picture.type != DType::u1 || picture.shape.size() != 3 || picture.shape[2] != 3 ||
      picture.size() == 0) {
    throw FileError(ErrorKind::mismatch,
                    {.path = path,
                     .what = "member 'img' is no colour picture",
                     .expected = "u1 (height, width, 3)",
                     .found = std::string(type_name(picture.type)) + " " + shape_text(picture.shape)});
  }
  frame.image = detail::channels_reversed(picture.array<std::uint8_t, 3>());
  if (file.has("camera_matrix") || file.has("camera_fov")) detail::read_camera(file, frame);
  if (!frame.has_camera || file.has("veh_trans") || file.has("cam_trans")) detail::read_poses(file, frame);
  if (!frame.has_camera) detail::check_poses(frame);
  detail::read_extras(file, frame);
  return frame;
}

/// Writes a frame so that read_frame() gives it back; deflated, the whole file or nothing.
/// \throws ShapeError unless the picture is [H, W, 3] and the mask, if any, [H, W]; FileError (write)
inline void write_frame(const std::string& path, const Frame& frame) {
  const auto& extents = frame.image.shape();
  if (extents[2] != 3 || frame.image.size() == 0) throw ShapeError("write_frame: image is not [H, W, 3]");
  if (frame.has_mask && (frame.mask.shape(0) != extents[0] || frame.mask.shape(1) != extents[1]))
    throw ShapeError("write_frame: mask has another size than the image");
  NpzWriter writer;
  writer.add("img", detail::channels_reversed(frame.image));
  const auto add_numbers = [&](const char* name, std::vector<std::size_t> shape,
                               const std::vector<double>& numbers) {
    writer.add(name, std::span<const std::size_t>(shape), std::span<const double>(numbers));
  };
  const auto add_pose = [&](const char* name, const std::array<double, 3>& t,
                            const std::array<double, 3>& r) {
    add_numbers(name, {2, 3}, {t[0], t[1], t[2], r[0], r[1], r[2]});
  };
  add_pose("veh_trans", frame.vehicle_translation, frame.vehicle_rotation_deg);
  add_pose("cam_trans", frame.camera_translation, frame.camera_rotation_deg);
  if (frame.has_camera) {
    std::vector<double> matrix;
    for (std::size_t row = 0; row < 3; ++row) {
      matrix.insert(matrix.end(), frame.camera.rotation[row].begin(), frame.camera.rotation[row].end());
      matrix.push_back(frame.camera.translation[row]);
    }
    add_numbers("camera_matrix", {3, 4}, matrix);
    add_numbers("camera_fov", {2}, {frame.camera.tan_half_fov_x, frame.camera.tan_half_fov_y});
  }
  if (frame.has_light) add_numbers("light", {8}, {frame.light.begin(), frame.light.end()});
  if (frame.has_mask) writer.add("mask", frame.mask);
  if (frame.has_label) add_numbers("label", {5}, {frame.label.begin(), frame.label.end()});
  writer.write(path, true);
}

namespace detail {
/// What sorts file names with numbers by value: each number with zeros before it, to at least 20 digits.
inline std::string numeric_order_key(const std::string& path) {
  std::string key;
  const std::string stem = std::filesystem::path(path).stem().string();
  for (std::size_t i = 0; i < stem.size();) {
    std::size_t end = i;
    while (end < stem.size() && stem[end] >= '0' && stem[end] <= '9') ++end;
    if (end > i) key += std::string(20 - std::min<std::size_t>(20, end - i), '0');
    end = std::max(end, i + 1);
    key += stem.substr(i, end - i);
    i = end;
  }
  return key;
}
}  // namespace detail

/// The .npz files of a folder in order of their names, numbers by value: data2 before data10.
/// \throws FileError: malformed (not a readable folder), mismatch (no .npz file in it)
[[nodiscard]] inline std::vector<std::string> frame_paths(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().extension() == ".npz") paths.push_back(entry->path().string());
  if (error) {
    throw FileError(ErrorKind::malformed,
                    {.path = folder, .what = "cannot list the folder: " + error.message()});
  }
  if (paths.empty()) throw FileError(ErrorKind::mismatch, {.path = folder, .what = "holds no frame (*.npz)"});
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::pair(detail::numeric_order_key(a), a) < std::pair(detail::numeric_order_key(b), b);
  });
  return paths;
}

}  // namespace tapestry::io
