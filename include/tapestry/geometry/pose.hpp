#pragma once
#include <cstddef>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/rotation.hpp>
#include <vector>

namespace tapestry::geometry {

/// Where a thing stands in the world: x ↦ exp(w)·x + t.
struct Pose {
  Vector3 rotation{0, 0, 0};     ///< w, axis times angle in radians, see exponential_map()
  Vector3 translation{0, 0, 0};  ///< t, units of the world
};

/// The camera that sees a thing where it is as `camera` sees it after it has taken a pose:
///   x_view = R·(exp(w)·x + t) + t₀, R and t₀ being those of `camera`.
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

}  // namespace tapestry::geometry
