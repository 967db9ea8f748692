#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/vertex_gradient.hpp>
#include <tapestry/raster/visibility.hpp>
#include <vector>

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
/// \param samples_per_axis    pieces of the outline are at most its inverse long, in pixels
/// \param edges               mesh_edges() of the mesh, when they are kept from view to view; null: found now
/// \throws ShapeError unless there is an entry a position and edges are the mesh's; otherwise as silhouette()
template <std::floating_point T>
void silhouette_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera,
                        const Array<T, 2>& silhouette_adjoint,
                        std::vector<geometry::Vector3>& positions_adjoint, std::size_t samples_per_axis = 4,
                        const std::shared_ptr<const MeshEdges>& edges = nullptr);

}  // namespace tapestry::raster
