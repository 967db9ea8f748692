#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/geometry/mesh_topology.hpp>
#include <tapestry/geometry/transform.hpp>

/// What keeps a mesh well shaped while its positions are fitted: values are summed in double, in the order of
/// the topology; adjoints are added up in the positions' own type.
namespace tapestry::loss {
namespace detail {

template <std::floating_point T>
[[nodiscard]] geometry::Vector3 row(const Array<T, 2>& positions, std::size_t vertex);

}  // namespace detail

/// Mean over positions of the squared distance to the middle of their neighbours (uniform weights), in
/// squared units of the world: L = 1/V · Σ_v |1/d_v · Σ_u x_u − x_v|². Smooths, and shrinks what is closed.
/// Source of the umbrella vector: Sorkine et al., "Laplacian Surface Editing" (SGP 2004), eq. 1.
///
/// \param positions  x, [V, 3]
/// \throws ShapeError unless there are as many as the topology has
template <std::floating_point T>
[[nodiscard]] T laplacian(const geometry::MeshTopology& topology, const Array<T, 2>& positions);

/// Adds loss_adjoint · ∂L/∂x to positions_adjoint, [V, 3].
template <std::floating_point T>
void laplacian_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions, T loss_adjoint,
                       Array<T, 2>& positions_adjoint);

/// Mean over edges of the squared difference between their length and `length`, units of the world:
/// L = 1/E · Σ (|x_b − x_a| − length)². An edge of no length pulls nowhere.
///
/// \param positions  x, [V, 3]
/// \throws ShapeError unless there are as many as the topology has
template <std::floating_point T>
[[nodiscard]] T edge_length(const geometry::MeshTopology& topology, const Array<T, 2>& positions,
                            double length = 0);

/// Adds loss_adjoint · ∂L/∂x to positions_adjoint, [V, 3].
template <std::floating_point T>
void edge_length_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions, double length,
                         T loss_adjoint, Array<T, 2>& positions_adjoint);

/// Mean over pairs of faces with a common edge of 1 − cos of the angle between them: 0 where the mesh is
/// flat, 2 where it is folded onto itself. Faces without area count as flat; the winding does not matter.
///
/// \param positions  x, [V, 3]
/// \throws ShapeError unless there are as many as the topology has
template <std::floating_point T>
[[nodiscard]] T normal_consistency(const geometry::MeshTopology& topology, const Array<T, 2>& positions);

/// Adds loss_adjoint · ∂L/∂x to positions_adjoint, [V, 3].
template <std::floating_point T>
void normal_consistency_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions,
                                T loss_adjoint, Array<T, 2>& positions_adjoint);

}  // namespace tapestry::loss
