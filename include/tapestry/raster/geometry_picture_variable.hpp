#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/geometry/rotation.hpp>
#include <tapestry/raster/geometry_picture.hpp>
#include <tapestry/raster/render_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster {

/// geometry_picture() on the active tape, differentiable by positions and pose; its pullback is
/// geometry_picture_adjoint(). Positions and normals are those in the world after the mesh has taken its
/// pose. Passive inputs record nothing.
///
/// \tparam Output    Depth, SurfacePosition or Normal
/// \param mesh       copied: it may change or go once this returns
/// \param positions  [V, 3], instead of the mesh's own; of extent 0: the mesh's own
/// \param pose       [6], w (radians) and t (units of the world): the mesh stands at exp(w)·x + t; of extent
///                   0: as it is
/// \param edges      mesh_edges() of the mesh, when they are kept from view to view
/// \returns          [H, W] of a depth, else [H, W, 3]
/// \throws ShapeError if an input does not fit; DomainError if the pose is not finite; otherwise as
///         visibility()
template <GeometryOutput Output, std::floating_point T>
[[nodiscard]] ArrayVariable<T, geometry_rank<Output>> geometry_picture(
    const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height, std::size_t width,
    const ArrayVariable<T, 2>& positions, const ArrayVariable<T, 1>& pose = {},
    std::size_t samples_per_axis = 4, std::shared_ptr<const MeshEdges> edges = nullptr) {
  const auto at = detail::pose_of("geometry_picture", pose);
  const auto turned = geometry::exponential_map(at.rotation);
  auto body = std::make_shared<geometry::Mesh>();
  body->positions = mesh.positions;
  body->faces = mesh.faces;
  if (detail::is_given(positions)) geometry::set_positions("geometry_picture", *body, positions.value());
  auto shape = body;
  if (detail::is_given(pose)) {
    shape = std::make_shared<geometry::Mesh>(*body);
    for (auto& position : shape->positions)
      position = geometry::add(geometry::multiply(turned, position), at.translation);
  }
  auto picture = geometry_picture<Output, T>(*shape, camera, height, width, samples_per_axis);
  auto pullback = [body, shape, camera, at, turned, samples_per_axis, edges = std::move(edges)](
                      const Array<T, geometry_rank<Output>>& adjoint, Array<T, 2>* positions_adjoint,
                      Array<T, 1>* pose_adjoint) {
    std::vector<geometry::Vector3> moving(body->positions.size(), geometry::Vector3{0, 0, 0});
    geometry_picture_adjoint<Output>(*shape, camera, adjoint, moving, samples_per_axis, edges);
    for (auto& part : moving) part = geometry::multiply_transposed(turned, part);
    if (positions_adjoint != nullptr) detail::add_positions(moving, *positions_adjoint);
    if (pose_adjoint != nullptr) detail::add_pose(at, *body, moving, *pose_adjoint);
  };
  return record_array(std::move(picture), std::move(pullback), positions, pose);
}

}  // namespace tapestry::raster
