#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <numbers>
#include <span>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/npy.hpp>
#include <utility>
#include <vector>

namespace tapestry::io::detail {

template <std::size_t N>
void require_finite(const std::array<double, N>& values, const std::string& path, const char* member) {
  for (const double value : values) {
    if (!std::isfinite(value)) {
      throw FileError(ErrorKind::mismatch,
                      {.path = path, .what = std::string(member) + " holds a value that is not finite"});
    }
  }
}

/// The numbers of a member with exactly this shape.
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

/// Angle in degrees between the view direction by pitch and yaw (CARLA) and the direction from the camera to
/// the vehicle.
inline double degrees_off_target(const geometry::CarlaPose& pose, double radians_per_unit) {
  const double pitch = pose.camera_rotation_deg[0] * radians_per_unit;
  const double yaw = pose.camera_rotation_deg[1] * radians_per_unit;
  const auto& offset = pose.camera_translation;
  const double along =
      std::cos(pitch) * (std::cos(yaw) * offset[0] + std::sin(yaw) * offset[1]) + std::sin(pitch) * offset[2];
  const double distance = std::hypot(offset[0], offset[1], offset[2]);
  return std::acos(std::clamp(-along / distance, -1.0, 1.0)) * 180 / std::numbers::pi;
}

inline void check_pose(const geometry::CarlaPose& pose, Frame& frame) {
  const auto& offset = pose.camera_translation;
  const double distance = std::hypot(offset[0], offset[1], offset[2]);
  if (!(distance > 1e-6)) {
    throw FileError(ErrorKind::mismatch, {.path = frame.name,
                                          .what = "camera lies in the vehicle's origin",
                                          .expected = "cam_trans row 0 as an offset in metres",
                                          .found = "distance 0"});
  }
  const auto text = [](double value) { return std::to_string(value); };
  if (distance < 2.5)
    frame.warnings.push_back("camera is " + text(distance) + " m from the vehicle's origin, maybe inside it");
  if (std::abs(std::abs(pose.camera_rotation_deg[0]) - 90) < 0.5)
    frame.warnings.push_back("camera looks straight up or down, its yaw is poorly defined");
  constexpr double per_degree = std::numbers::pi / 180;
  const double off = degrees_off_target(pose, per_degree);
  if (off > 25) {
    const bool radians = degrees_off_target(pose, 1) < 5;
    frame.warnings.push_back("camera looks " + text(off) + " degrees past the vehicle" +
                             (radians ? "; its angles look like radians where degrees are expected" : ""));
  }
}

inline geometry::CarlaPose read_pose(const NpzFile& file) {
  const auto vehicle = numbers<6>(file, "veh_trans", {2, 3});
  const auto camera = numbers<6>(file, "cam_trans", {2, 3});
  return {{vehicle[0], vehicle[1], vehicle[2]},
          {vehicle[3], vehicle[4], vehicle[5]},
          {camera[0], camera[1], camera[2]},
          {camera[3], camera[4], camera[5]}};
}

inline geometry::Camera read_camera(const NpzFile& file) {
  const auto matrix = numbers<12>(file, "camera_matrix", {3, 4});
  const auto fov = numbers<2>(file, "camera_fov", {2});
  const auto fail = [&](const char* what, const char* expected) {
    throw FileError(ErrorKind::mismatch, {.path = file.path(), .what = what, .expected = expected});
  };
  if (!(fov[0] > 0 && fov[1] > 0)) fail("member 'camera_fov' is no field of view", "two positive tangents");
  geometry::Camera camera;
  auto& rotation = camera.rotation;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) rotation[row][column] = matrix[4 * row + column];
    camera.translation[row] = matrix[4 * row + 3];
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = 0; b < 3; ++b) {
      double product = 0;
      for (std::size_t k = 0; k < 3; ++k) product += rotation[a][k] * rotation[b][k];
      if (!(std::abs(product - (a == b ? 1 : 0)) <= 1e-6))
        fail("member 'camera_matrix' holds no rotation", "orthonormal rows");
    }
  }
  camera.tan_half_fov_x = fov[0];
  camera.tan_half_fov_y = fov[1];
  camera.far = 1e9;  // the file has no unit of length
  return camera;
}

/// ambient, directional, direction towards the light x y z, colour r g b
inline raster::Light read_light(const NpzFile& file) {
  const auto light = numbers<8>(file, "light", {8});
  return {light[0], light[1], {light[2], light[3], light[4]}, {light[5], light[6], light[7]}};
}

inline Array<std::uint8_t, 2> read_mask(const NpzFile& file, std::size_t height, std::size_t width) {
  auto mask = file.array<std::uint8_t, 2>("mask");
  const std::array<std::size_t, 2> picture{height, width};
  if (mask.shape() != picture) {
    throw FileError(ErrorKind::mismatch, {.path = file.path(),
                                          .what = "member 'mask' has another size than the picture",
                                          .expected = shape_text(picture),
                                          .found = shape_text(file.get("mask").shape)});
  }
  return mask;
}

/// class, cx, cy, w, h; the box in shares of the picture
inline Label read_label(const NpzFile& file, std::size_t height, std::size_t width) {
  const auto label = numbers<5>(file, "label", {5});
  const auto inside = [](double share) { return share >= 0 && share <= 1; };
  if (!(label[0] >= 0 && label[0] <= 65535 && label[0] == std::floor(label[0]) && inside(label[1]) &&
        inside(label[2]) && label[3] > 0 && label[4] > 0 && inside(label[3]) && inside(label[4]))) {
    throw FileError(ErrorKind::mismatch, {.path = file.path(),
                                          .what = "member 'label' is no box of the picture",
                                          .expected = "class, cx, cy, w, h in shares of the picture"});
  }
  const auto rows = static_cast<double>(height), columns = static_cast<double>(width);
  return {static_cast<std::size_t>(label[0]),
          {label[1] * columns, label[2] * rows, label[3] * columns, label[4] * rows}};
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

Frame read_frame(const std::string& path) {
  const NpzFile file = NpzFile::read(path);
  Frame frame;
  frame.name = path;
  const NpyArray& picture = file.get("img");
  if (picture.type != DType::u1 || picture.shape.size() != 3 || picture.shape[2] != 3 ||
      picture.size() == 0) {
    throw FileError(ErrorKind::mismatch,
                    {.path = path,
                     .what = "member 'img' is no colour picture",
                     .expected = "u1 (height, width, 3)",
                     .found = std::string(type_name(picture.type)) + " " + shape_text(picture.shape)});
  }
  frame.image = image::swap_red_blue(picture.array<std::uint8_t, 3>());
  const std::size_t height = frame.image.shape(0), width = frame.image.shape(1);
  if (file.has("camera_matrix") || file.has("camera_fov")) frame.camera = detail::read_camera(file);
  if (!frame.camera || file.has("veh_trans") || file.has("cam_trans")) frame.pose = detail::read_pose(file);
  if (!frame.camera) detail::check_pose(*frame.pose, frame);
  if (file.has("light")) frame.light = detail::read_light(file);
  if (file.has("mask")) frame.mask = detail::read_mask(file, height, width);
  if (file.has("label")) frame.label = detail::read_label(file, height, width);
  return frame;
}

Array<std::uint8_t, 3> read_picture(const std::string& path, std::vector<std::string>* warnings) {
  return path.ends_with(".npz") ? read_frame(path).image : read_image(path, warnings);
}

void write_frame(const std::string& path, const Frame& frame) {
  const auto& extents = frame.image.shape();
  if (extents[2] != 3 || frame.image.size() == 0) throw ShapeError("write_frame: image is not [H, W, 3]");
  if (frame.mask) require_shape("write_frame", "mask", *frame.mask, {extents[0], extents[1]});
  NpzWriter writer;
  writer.add("img", image::swap_red_blue(frame.image));
  const auto add_numbers = [&](const char* name, std::vector<std::size_t> shape,
                               const std::vector<double>& numbers) {
    writer.add(name, std::span<const std::size_t>(shape), std::span<const double>(numbers));
  };
  const auto add_pose = [&](const char* name, const geometry::Vector3& t, const geometry::Vector3& r) {
    add_numbers(name, {2, 3}, {t[0], t[1], t[2], r[0], r[1], r[2]});
  };
  const geometry::CarlaPose pose = frame.pose.value_or(geometry::CarlaPose{});
  add_pose("veh_trans", pose.vehicle_translation, pose.vehicle_rotation_deg);
  add_pose("cam_trans", pose.camera_translation, pose.camera_rotation_deg);
  if (frame.camera) {
    std::vector<double> matrix;
    for (std::size_t row = 0; row < 3; ++row) {
      matrix.insert(matrix.end(), frame.camera->rotation[row].begin(), frame.camera->rotation[row].end());
      matrix.push_back(frame.camera->translation[row]);
    }
    add_numbers("camera_matrix", {3, 4}, matrix);
    add_numbers("camera_fov", {2}, {frame.camera->tan_half_fov_x, frame.camera->tan_half_fov_y});
  }
  if (frame.light) {
    const auto& [ambient, directional, direction, colour] = *frame.light;
    add_numbers(
        "light", {8},
        {ambient, directional, direction[0], direction[1], direction[2], colour[0], colour[1], colour[2]});
  }
  if (frame.mask) writer.add("mask", *frame.mask);
  if (frame.label) {
    const auto height = static_cast<double>(extents[0]), width = static_cast<double>(extents[1]);
    const auto& [class_index, box] = *frame.label;
    add_numbers(
        "label", {5},
        {static_cast<double>(class_index), box.cx / width, box.cy / height, box.w / width, box.h / height});
  }
  writer.write(path, true);
}

}  // namespace tapestry::io

namespace tapestry::io::detail {

/// Key that sorts file names with numbers by value: each number with zeros before it, to at least 20 digits.
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

}  // namespace tapestry::io::detail

namespace tapestry::io {

std::vector<std::string> frame_paths(const std::string& folder) {
  auto paths =
      listed_paths(folder, [](const std::filesystem::path& path) { return path.extension() == ".npz"; });
  if (paths.empty()) throw FileError(ErrorKind::mismatch, {.path = folder, .what = "holds no frame (*.npz)"});
  std::sort(paths.begin(), paths.end(), [](const std::string& a, const std::string& b) {
    return std::pair(detail::numeric_order_key(a), a) < std::pair(detail::numeric_order_key(b), b);
  });
  return paths;
}

}  // namespace tapestry::io
