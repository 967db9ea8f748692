#pragma once
#include <tapestry/geometry/pose.hpp>
#include <tapestry/raster/detail/vertex_gradient.hpp>

namespace tapestry::raster {
/// Share of each pixel that shows a mesh, [H, W] in [0, 1], as texture_operator() counts it: without a
/// texture, a light or a colour.
/// \throws as visibility()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> silhouette(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                     std::size_t height, std::size_t width,
                                     std::size_t samples_per_axis = 4) {
  return cast<T>(coverage_of(visibility(mesh, camera, height, width, samples_per_axis)));
}

/// Adds ∂L/∂positions, L being a function of the silhouette, to positions_adjoint, in units of L per unit of
/// the world: the derivative of the exact areas, which is the integral along the outline. Edges inside the
/// outline cost little. Sums are in double and the same for any number of threads.
///
/// \param silhouette_adjoint  ∂L/∂silhouette, [H, W]
/// \param positions_adjoint   one entry a position of the mesh
/// \param samples_per_axis    pieces of the outline are at most 1/samples_per_axis pixels long
/// \param edges               mesh_edges() of the mesh, when they are kept from view to view; null: found now
/// \throws ShapeError unless there is an entry a position and edges are the mesh's; otherwise as silhouette()
template <std::floating_point T>
void silhouette_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera,
                        const Array<T, 2>& silhouette_adjoint,
                        std::vector<geometry::Vector3>& positions_adjoint, std::size_t samples_per_axis = 4,
                        const std::shared_ptr<const MeshEdges>& edges = nullptr);

namespace detail {
/// Records a drawn coverage on the tape.
/// \param camera  as in geometry::posed()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> record_coverage(std::shared_ptr<const geometry::Mesh> mesh,
                                                  const geometry::Camera& camera, const geometry::Pose& at,
                                                  Array<T, 2> coverage, const ArrayVariable<T, 2>& positions,
                                                  const ArrayVariable<T, 1>& pose,
                                                  std::size_t samples_per_axis,
                                                  std::shared_ptr<const MeshEdges> edges);
}  // namespace detail

/// silhouette() on the active tape, differentiable by positions and pose; its pullback is
/// silhouette_adjoint(). Nothing is drawn but the outline. Passive inputs record nothing.
///
/// \param mesh       copied: it may change or end once this returns
/// \param positions  [V, 3], instead of the mesh's own; of extent 0: the mesh's own
/// \param pose       [6], w (radians) and t (units of the world): the mesh is seen at exp(w)·x + t, see
///                   geometry::posed(); of extent 0: no pose
/// \param edges      mesh_edges() of the mesh, when they are kept from view to view
/// \returns          [H, W] in [0, 1]
/// \throws ShapeError if an input does not fit; DomainError if the pose is not finite; otherwise as
///         visibility()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> silhouette(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                             std::size_t height, std::size_t width,
                                             const ArrayVariable<T, 2>& positions,
                                             const ArrayVariable<T, 1>& pose = {},
                                             std::size_t samples_per_axis = 4,
                                             std::shared_ptr<const MeshEdges> edges = nullptr);
}  // namespace tapestry::raster
