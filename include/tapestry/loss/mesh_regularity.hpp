#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/geometry/mesh.hpp>

/// Terms that keep a mesh well shaped while its positions are fitted. Values are summed in double, in the
/// order of the topology; adjoints are added up in the positions' own type.
namespace tapestry::loss {
namespace detail {
template <std::floating_point T>
[[nodiscard]] geometry::Vector3 row(const Array<T, 2>& positions, std::size_t vertex);
}  // namespace detail

/// Mean over positions of the squared distance to the middle of their neighbours (uniform weights), in
/// squared units of the world: L = 1/V · Σ_v |1/d_v · Σ_u x_u − x_v|². Smooths a mesh, and shrinks a closed
/// one. Source of the umbrella vector: Sorkine et al., "Laplacian Surface Editing" (SGP 2004), eq. 1.
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
/// L = 1/E · Σ (|x_b − x_a| − length)². An edge of length 0 has no gradient.
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

template <std::floating_point T>
void laplacian(const geometry::MeshTopology&&, const ArrayVariable<T, 2>&) = delete;  // it would be gone

/// laplacian() on the active tape; its pullback is laplacian_adjoint(). Passive positions record nothing.
/// \param topology  must outlive the tape's last reverse(), unchanged
template <std::floating_point T>
[[nodiscard]] Variable<T> laplacian(const geometry::MeshTopology& topology,
                                    const ArrayVariable<T, 2>& positions);

template <std::floating_point T>
void edge_length(const geometry::MeshTopology&&, const ArrayVariable<T, 2>&,
                 double = 0) = delete;  // it would be gone

/// edge_length() on the active tape; its pullback is edge_length_adjoint(). Passive positions record nothing.
/// \param topology  must outlive the tape's last reverse(), unchanged
template <std::floating_point T>
[[nodiscard]] Variable<T> edge_length(const geometry::MeshTopology& topology,
                                      const ArrayVariable<T, 2>& positions, double length = 0);

template <std::floating_point T>
void normal_consistency(const geometry::MeshTopology&&,
                        const ArrayVariable<T, 2>&) = delete;  // it would be gone

/// normal_consistency() on the active tape; its pullback is normal_consistency_adjoint(). Passive positions
/// record nothing.
/// \param topology  must outlive the tape's last reverse(), unchanged
template <std::floating_point T>
[[nodiscard]] Variable<T> normal_consistency(const geometry::MeshTopology& topology,
                                             const ArrayVariable<T, 2>& positions);
}  // namespace tapestry::loss
