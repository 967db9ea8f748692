#pragma once
#include <array>
#include <cmath>
#include <numbers>
#include <tapestry/geometry/bounds.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/carla_pose.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {

Camera carla_camera(const CarlaPose& pose, const CarlaOptions& options) {
  constexpr double rad_per_deg = std::numbers::pi / 180;
  const double pitch = pose.camera_rotation_deg[0] * rad_per_deg;
  const double yaw = pose.camera_rotation_deg[1] * rad_per_deg;
  const double vehicle_yaw = pose.vehicle_rotation_deg[1] * rad_per_deg;
  const auto mesh_from_carla = [c = std::cos(vehicle_yaw), s = std::sin(vehicle_yaw)](const Vector3& a) {
    return Vector3{a[0] * c + a[1] * s, -(a[1] * c - a[0] * s), a[2]};
  };
  const Vector3 offset_m = subtract(pose.camera_translation, {0, 0, options.z_shift_m});
  const Vector3 forward{std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw), std::sin(pitch)};
  const Vector3 up{-std::sin(pitch) * std::cos(yaw), -std::sin(pitch) * std::sin(yaw), std::cos(pitch)};
  Camera camera = look_along(mesh_from_carla(scale(offset_m, options.scale)), mesh_from_carla(forward),
                             mesh_from_carla(up));
  camera.tan_half_fov_x = camera.tan_half_fov_y = detail::tan_half("carla_camera", options.fov_rad);
  camera.near = options.near;
  camera.far = options.far;
  return camera;
}

Mesh normalise_mesh(Mesh mesh) {
  const Bounds bounds = bounds_of(mesh.positions);
  const Vector3 extent = subtract(bounds.high, bounds.low);
  const double longest = 2 * bounds.half_length();
  if (!(longest > 0)) return mesh;
  for (Vector3& position : mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      position[axis] = (position[axis] - bounds.low[axis]) / longest * 2 - extent[axis] / longest;
    }
  }
  return mesh;
}

}  // namespace tapestry::geometry
