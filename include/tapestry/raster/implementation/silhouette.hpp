#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/silhouette.hpp>
#include <tapestry/raster/vertex_gradient.hpp>
#include <tapestry/raster/visibility.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// What a silhouette shows: every face alike, so that only the mesh's outline counts.
struct OneColour {
  using Colour = std::array<double, 1>;
  [[nodiscard]] static constexpr Colour at(std::int32_t, const std::array<double, 3>&) { return {1}; }
  [[nodiscard]] static constexpr bool is_continuous() { return true; }
  [[nodiscard]] static constexpr bool agrees(const HalfEdge&, const HalfEdge&) { return true; }
};

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
void silhouette_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera,
                        const Array<T, 2>& silhouette_adjoint,
                        std::vector<geometry::Vector3>& positions_adjoint, std::size_t samples_per_axis,
                        const std::shared_ptr<const MeshEdges>& edges) {
  detail::require_view("silhouette_adjoint", camera, silhouette_adjoint.shape(0), silhouette_adjoint.shape(1),
                       samples_per_axis);
  require_corners("silhouette_adjoint", mesh);
  detail::require_positions_adjoint("silhouette_adjoint", mesh, positions_adjoint);
  // Where faces cut through each other, they show the same.
  detail::add_boundaries(mesh, camera, positions_in_view(mesh, camera), detail::OneColour{},
                         silhouette_adjoint, samples_per_axis,
                         *detail::edges_of("silhouette_adjoint", mesh, edges), {}, false, positions_adjoint);
}

template decltype(silhouette_adjoint<float>) silhouette_adjoint<float>;
template decltype(silhouette_adjoint<double>) silhouette_adjoint<double>;

}  // namespace tapestry::raster
