#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/geometry/position_array.hpp>
#include <vector>

namespace tapestry::raster::detail {

template <class T, std::size_t Rank>
[[nodiscard]] bool is_given(const ArrayVariable<T, Rank>& input) {
  return input.shape()[0] != 0;
}

template <std::floating_point T>
[[nodiscard]] geometry::Pose pose_of(const char* operation, const ArrayVariable<T, 1>& pose) {
  if (!is_given(pose)) return {};
  require_shape(operation, "pose", pose.value(), {6});
  const T* const p = pose.value().data();
  const auto vector = [](const T* at) {
    return geometry::Vector3{static_cast<double>(at[0]), static_cast<double>(at[1]),
                             static_cast<double>(at[2])};
  };
  const geometry::Pose result{vector(p), vector(p + 3)};
  if (!geometry::is_finite(result.rotation) || !geometry::is_finite(result.translation))
    throw DomainError(std::string(operation) + ": the pose must be finite");
  return result;
}

/// Adds derivatives by positions to an adjoint [V, 3].
template <std::floating_point T>
void add_positions(const std::vector<geometry::Vector3>& gradient, Array<T, 2>& positions_adjoint) {
  for (std::size_t i = 0; i < positions_adjoint.size(); ++i)
    positions_adjoint.data()[i] += static_cast<T>(gradient[i / 3][i % 3]);
}

/// Adds the derivative by the pose to an adjoint [6]; `moving` as in geometry::posed_adjoint().
template <std::floating_point T>
void add_pose(const geometry::Pose& pose, const geometry::Mesh& mesh,
              const std::vector<geometry::Vector3>& moving, Array<T, 1>& pose_adjoint) {
  geometry::Pose gradient;
  geometry::posed_adjoint(pose, mesh.positions, moving, gradient);
  for (std::size_t k = 0; k < 3; ++k) {
    pose_adjoint(k) += static_cast<T>(gradient.rotation[k]);
    pose_adjoint(k + 3) += static_cast<T>(gradient.translation[k]);
  }
}

}  // namespace tapestry::raster::detail
