#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/loss/mesh_regularity.hpp>

namespace tapestry::loss {

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
