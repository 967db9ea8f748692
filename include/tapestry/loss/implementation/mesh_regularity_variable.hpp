#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/mesh_regularity.hpp>
#include <tapestry/loss/mesh_regularity_variable.hpp>

namespace tapestry::loss {

template <std::floating_point T>
Variable<T> laplacian(const geometry::MeshTopology& topology, const ArrayVariable<T, 2>& positions) {
  return record_scalar(
      laplacian(topology, positions.value()),
      [&topology, at = positions.shared_value()](T adjoint, Array<T, 2>* positions_adjoint) {
        laplacian_adjoint(topology, *at, adjoint, *positions_adjoint);
      },
      positions);
}

template <std::floating_point T>
Variable<T> edge_length(const geometry::MeshTopology& topology, const ArrayVariable<T, 2>& positions,
                        double length) {
  return record_scalar(
      edge_length(topology, positions.value(), length),
      [&topology, length, at = positions.shared_value()](T adjoint, Array<T, 2>* positions_adjoint) {
        edge_length_adjoint(topology, *at, length, adjoint, *positions_adjoint);
      },
      positions);
}

template <std::floating_point T>
Variable<T> normal_consistency(const geometry::MeshTopology& topology, const ArrayVariable<T, 2>& positions) {
  return record_scalar(
      normal_consistency(topology, positions.value()),
      [&topology, at = positions.shared_value()](T adjoint, Array<T, 2>* positions_adjoint) {
        normal_consistency_adjoint(topology, *at, adjoint, *positions_adjoint);
      },
      positions);
}

template Variable<float> laplacian<float>(const geometry::MeshTopology& topology,
                                          const ArrayVariable<float, 2>& positions);
template Variable<double> laplacian<double>(const geometry::MeshTopology& topology,
                                            const ArrayVariable<double, 2>& positions);
template Variable<float> edge_length<float>(const geometry::MeshTopology& topology,
                                            const ArrayVariable<float, 2>& positions, double length);
template Variable<double> edge_length<double>(const geometry::MeshTopology& topology,
                                              const ArrayVariable<double, 2>& positions, double length);
template Variable<float> normal_consistency<float>(const geometry::MeshTopology& topology,
                                                   const ArrayVariable<float, 2>& positions);
template Variable<double> normal_consistency<double>(const geometry::MeshTopology& topology,
                                                     const ArrayVariable<double, 2>& positions);

}  // namespace tapestry::loss
