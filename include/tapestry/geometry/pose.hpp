#pragma once
#include <cassert>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/detail/rotation.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::geometry {
/// Position and orientation of an object in the world: x ↦ exp(w)·x + t.
struct Pose {
  Vector3 rotation{0, 0, 0};     ///< w, axis times angle in radians, see exponential_map()
  Vector3 translation{0, 0, 0};  ///< t, units of the world
};

/// The camera that sees an object as `camera` sees it after the object has taken a pose:
///  x_view = R·(exp(w)·x + t) + t₀, with R and t₀ of `camera`.
[[nodiscard]] inline Camera posed(Camera camera, const Pose& pose) {
  const Matrix3 turned = exponential_map(pose.rotation);
  camera.translation = add(multiply(camera.rotation, pose.translation), camera.translation);
  for (Vector3& row : camera.rotation) row = multiply_transposed(turned, row);
  return camera;
}

/// Adds the derivative with respect to the pose of a loss that depends on it through the points
/// x_view of posed().
///
/// \param positions          x
/// \param positions_adjoint  derivatives with respect to x, all else fixed; one entry a position
inline void posed_adjoint(const Pose& pose, const std::vector<Vector3>& positions,
                          const std::vector<Vector3>& positions_adjoint, Pose& pose_adjoint) {
  Matrix3 outer{};  // Σ g·xᵀ
  Vector3 sum{};
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const Vector3& g = positions_adjoint[i];
    if (g == Vector3{0, 0, 0}) continue;  // also of positions that are not finite
    sum = add(sum, g);
    for (std::size_t k = 0; k < 3; ++k) outer[k] = add(outer[k], scale(positions[i], g[k]));
  }
  const Matrix3 turned = exponential_map(pose.rotation);
  pose_adjoint.translation = add(pose_adjoint.translation, multiply(turned, sum));  // exp(w)⁻ᵀ = exp(w)
  Matrix3 rotation_adjoint{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      rotation_adjoint[i] = add(rotation_adjoint[i], scale(outer[k], turned[i][k]));
  exponential_map_adjoint(pose.rotation, rotation_adjoint, pose_adjoint.rotation);
}

/// The mesh at a pose: positions x ↦ exp(w)·x + t, normals n ↦ exp(w)·n; the same bits at the pose {}.
[[nodiscard]] inline Mesh placed(Mesh mesh, const Pose& pose) {
  if (pose.rotation == Vector3{0, 0, 0} && pose.translation == Vector3{0, 0, 0}) return mesh;
  const Matrix3 turned = exponential_map(pose.rotation);
  for (Vector3& position : mesh.positions) position = add(multiply(turned, position), pose.translation);
  for (Vector3& normal : mesh.normals) normal = multiply(turned, normal);
  return mesh;
}

/// Adds the derivative with respect to the pose of a loss that depends on it through the positions of
/// placed().
///
/// \param positions       x, before the mesh is placed
/// \param placed_adjoint  derivatives with respect to the placed positions, one entry a position
inline void placed_adjoint(const Pose& pose, const std::vector<Vector3>& positions,
                           const std::vector<Vector3>& placed_adjoint, Pose& pose_adjoint) {
  assert(placed_adjoint.size() == positions.size());
  const Matrix3 turned = exponential_map(pose.rotation);
  std::vector<Vector3> positions_adjoint(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i)
    positions_adjoint[i] = multiply_transposed(turned, placed_adjoint[i]);
  posed_adjoint(pose, positions, positions_adjoint, pose_adjoint);
}

/// Conversion from metres of the simulator to units of a normalised car. The defaults reproduce the published
/// masks; 0.41 is about 2 / 4.86 m, the normalised car's length over the real one's.
struct CarlaOptions {
  double scale = 0.41;                    ///< units of the mesh per metre
  double z_shift_m = 0.2;                 ///< height added to the vehicle's origin
  double fov_rad = std::numbers::pi / 2;  ///< full field of view, horizontal and vertical
  double near = 0.1;                      ///< units of the mesh
  double far = 100;                       ///< units of the mesh
};

/// Poses of a CARLA frame's vehicle and camera: x forward, y right, z up (left-handed).
struct CarlaPose {
  Vector3 vehicle_translation{};   ///< metres
  Vector3 vehicle_rotation_deg{};  ///< pitch, yaw, roll
  Vector3 camera_translation{};    ///< metres from the vehicle, along the axes of the world
  Vector3 camera_rotation_deg{};   ///< pitch, yaw, roll
  bool operator==(const CarlaPose&) const = default;
};

/// The camera that shows a normalised mesh (see normalise_mesh()) as a CARLA frame shows the vehicle.
///
/// With the camera's pitch p and yaw y, the vehicle's yaw ψ, scale s and shift h,
///   eye     = Q·s·(camera offset − (0, 0, h)),
///   forward = Q·(cos p · cos y, cos p · sin y, sin p),
///   up      = Q·(−sin p · cos y, −sin p · sin y, cos p),
/// Q turning about z by −ψ. All three then have their y negated, which takes them to the right-handed
/// axes of the mesh (x forward, y left, z up); this is the one flip between simulator and mesh.
/// Roll, and the vehicle's position, pitch and roll, have no effect, as in the published program.
/// Source: Wang et al., Dual Attention Suppression Attack (CVPR 2021), the camera of its data loader.
///
/// \throws DomainError if a number is not finite
[[nodiscard]] Camera carla_camera(const CarlaPose& pose, const CarlaOptions& options = {});

/// The mesh moved and scaled uniformly so that its box is centred at the origin and its longest axis
/// spans [−1, 1]. Vertices that are not finite do not count towards the box. Source: Neural Mesh
/// Renderer, load_obj: subtract the minimum, divide by the largest coordinate, times 2, minus half of
/// the maximum of each axis.
[[nodiscard]] Mesh normalise_mesh(Mesh mesh);
}  // namespace tapestry::geometry
