#pragma once
#include <tapestry/core/finite.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/io/json.hpp>
#include <tapestry/io/npy.hpp>

namespace tapestry::io::detail {
inline constexpr const char* frame_format = "tapestry frame 1";

/// A list of numbers, or of equally long lists of them, as an array.
inline NpyArray array_of(const nlohmann::json& value, const std::string& path, const std::string& name) {
  const auto fail = [&] { throw file_mismatch({path, "", "member '" + name + "' is no list of numbers"}); };
  NpyArray array{path + ":" + name, {value.size()}, DType::f8, {}};
  const auto append = [&](const nlohmann::json& list) {
    for (const auto& number : list) {
      if (!number.is_number()) fail();
      const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(double)>>(number.get<double>());
      array.bytes.insert(array.bytes.end(), bytes.begin(), bytes.end());
    }
  };
  if (!value.is_array() || value.empty()) fail();
  if (!value[0].is_array()) {
    append(value);
  } else {
    array.shape.push_back(value[0].size());
    for (const auto& row : value) {
      if (!row.is_array() || row.size() != array.shape[1]) fail();
      append(row);
    }
  }
  return array;
}

/// The members of a frame in a JSON file, like those of an .npz.
/// \throws FileError: malformed (no JSON, or not of a frame), mismatch (an unknown member)
inline NpzFile read_json_members(const std::string& path) {
  const auto json = read_json(read_text_file(path, std::uint64_t(1) << 20U), path).value;
  if (!json.is_object() || json.value("format", nlohmann::json()) != frame_format)
    throw malformed_file(
        {path, "", "is not the JSON of a frame", std::string("a member format, \"") + frame_format + "\""});
  NpzFile members(path);
  constexpr std::array known{"camera_fov", "camera_matrix", "cam_trans", "label", "light", "veh_trans"};
  for (const auto& [name, value] : json.items()) {
    if (name == "format") continue;
    if (std::ranges::find(known, name) == known.end())
      throw file_mismatch({path, "", "unknown member '" + printable(name) + "'",
                           "camera_matrix and camera_fov, or veh_trans and cam_trans; light and label"});
    members.add(name, array_of(value, path, name));
  }
  return members;
}

/// The numbers of a member with exactly this shape.
template <std::size_t N>
std::array<double, N> numbers(const NpzFile& file, const char* member,
                              const std::vector<std::size_t>& shape) {
  const NpyArray& array = file.get(member);
  if (array.shape != shape)
    throw file_mismatch({file.path(), "", "member '" + std::string(member) + "' has another shape",
                         shape_text(shape), shape_text(array.shape)});
  const auto values = array.as<double>();
  std::array<double, N> result{};
  std::copy(values.begin(), values.end(), result.begin());
  if (!std::ranges::all_of(result, [](double value) { return std::isfinite(value); }))
    throw file_mismatch({file.path(), "", std::string(member) + " holds a value that is not finite"});
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
  const double distance = hypot(offset[0], offset[1], offset[2]);
  return std::acos(std::clamp(-along / distance, -1.0, 1.0)) * 180 / std::numbers::pi;
}

inline void check_pose(const geometry::CarlaPose& pose, Frame& frame) {
  const auto& offset = pose.camera_translation;
  const double distance = hypot(offset[0], offset[1], offset[2]);
  if (!(distance > 1e-6))
    throw file_mismatch({frame.name, "", "camera lies in the vehicle's origin",
                         "cam_trans row 0 as an offset in metres", "distance 0"});
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
    throw file_mismatch({file.path(), "", what, expected});
  };
  if (!(fov[0] > 0 && fov[1] > 0)) fail("member 'camera_fov' is no field of view", "two positive tangents");
  geometry::Camera camera;
  auto& rotation = camera.rotation;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) rotation[row][column] = matrix[4 * row + column];
    camera.translation[row] = matrix[4 * row + 3];
  }
  if (!geometry::is_orthonormal(rotation))
    fail("member 'camera_matrix' holds no rotation", "orthonormal rows");
  camera.tan_half_fov_x = fov[0];
  camera.tan_half_fov_y = fov[1];
  camera.far = 1e9;  // the file has no unit of length
  return camera;
}

/// ambient, directional, direction towards the light x y z, colour r g b; products of
/// the others fit in a float.
inline raster::Light read_light(const NpzFile& file) {
  constexpr double most = 1e9;
  const auto light = numbers<8>(file, "light", {8});
  const std::array<double, 3> direction{light[2], light[3], light[4]};
  const auto fail = [&](const char* what, const char* expected) {
    throw file_mismatch({file.path(), "", what, expected});
  };
  if (!(geometry::length(geometry::normalised(direction)) > 0.5))
    fail("member 'light' has no direction", "a vector with a length at its numbers 3 to 5");
  for (const std::size_t i : {0U, 1U, 5U, 6U, 7U})
    if (!(std::abs(light[i]) <= most)) fail("member 'light' is too bright", "numbers of at most 1e9");
  return {light[0], light[1], direction, {light[5], light[6], light[7]}};
}

inline Array<std::uint8_t, 2> read_mask(const NpzFile& file, std::size_t height, std::size_t width) {
  auto mask = file.array<std::uint8_t, 2>("mask");
  const std::array<std::size_t, 2> picture{height, width};
  if (mask.shape() != picture)
    throw file_mismatch({file.path(), "", "member 'mask' has another size than the picture",
                         shape_text(picture), shape_text(file.get("mask").shape)});
  return mask;
}

/// class, cx, cy, w, h; the box in shares of the picture
inline Label read_label(const NpzFile& file, std::size_t height, std::size_t width) {
  const auto label = numbers<5>(file, "label", {5});
  const auto inside = [](double share) { return share >= 0 && share <= 1; };
  if (!(label[0] >= 0 && label[0] <= 65535 && label[0] == std::floor(label[0]) && inside(label[1]) &&
        inside(label[2]) && label[3] > 0 && label[4] > 0 && inside(label[3]) && inside(label[4]))) {
    throw file_mismatch({file.path(), "", "member 'label' is no box of the picture",
                         "class, cx, cy, w, h in shares of the picture"});
  }
  const auto rows = static_cast<double>(height), columns = static_cast<double>(width);
  return {static_cast<std::size_t>(label[0]),
          {label[1] * columns, label[2] * rows, label[3] * columns, label[4] * rows}};
}

/// Everything but picture and mask.
inline void read_members(const NpzFile& file, Frame& frame) {
  if (file.has("camera_matrix") || file.has("camera_fov")) frame.camera = read_camera(file);
  if (!frame.camera || file.has("veh_trans") || file.has("cam_trans")) frame.pose = read_pose(file);
  if (!frame.camera) check_pose(*frame.pose, frame);
  if (file.has("light")) frame.light = read_light(file);
  if (file.has("label")) frame.label = read_label(file, frame.image.shape(0), frame.image.shape(1));
}
}  // namespace tapestry::io::detail
