#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/mesh_regularity.hpp>

namespace tapestry::loss {
namespace detail {
template <std::floating_point T>
geometry::Vector3 row(const Array<T, 2>& positions, std::size_t vertex) {
  const T* const p = positions.data() + 3 * vertex;
  return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

template <std::floating_point T>
void add_to_row(Array<T, 2>& positions_adjoint, std::size_t vertex, const geometry::Vector3& value) {
  for (std::size_t k = 0; k < 3; ++k) positions_adjoint.data()[3 * vertex + k] += static_cast<T>(value[k]);
}

/// Mean of the neighbours minus the position, for every position; 0 without neighbours.
/// \param degree  receives the number of neighbours
template <std::floating_point T>
[[nodiscard]] std::vector<geometry::Vector3> umbrellas(const geometry::MeshTopology& topology,
                                                       const Array<T, 2>& positions,
                                                       std::vector<double>& degree) {
  std::vector<geometry::Vector3> result(topology.vertex_count, geometry::Vector3{0, 0, 0});
  degree.assign(topology.vertex_count, 0);
  for (const auto& [a, b] : topology.edges) {
    const auto step = geometry::subtract(row(positions, b), row(positions, a));
    result[a] = geometry::add(result[a], step);
    result[b] = geometry::subtract(result[b], step);
    ++degree[a];
    ++degree[b];
  }
  for (std::size_t i = 0; i < result.size(); ++i)
    if (degree[i] > 0) result[i] = geometry::scale(result[i], 1 / degree[i]);
  return result;
}

/// Normals of the two faces of a hinge, oriented as if the faces were unfolded side by side, as long as twice
/// their areas, and the cosine between them; 1 where a face has no area.
struct HingeNormals {
  geometry::Vector3 edge, to_c, to_d, first, second;
  double first_length, second_length, cosine;

  template <std::floating_point T>
  HingeNormals(const Array<T, 2>& positions, const geometry::MeshTopology::Hinge& hinge)
      : edge(geometry::subtract(row(positions, hinge.b), row(positions, hinge.a))),
        to_c(geometry::subtract(row(positions, hinge.c), row(positions, hinge.a))),
        to_d(geometry::subtract(row(positions, hinge.d), row(positions, hinge.a))),
        first(geometry::cross(edge, to_c)),
        second(geometry::cross(to_d, edge)),
        first_length(geometry::length(first)),
        second_length(geometry::length(second)),
        cosine(has_area() ? geometry::dot(first, second) / (first_length * second_length) : 1) {}

  [[nodiscard]] bool has_area() const { return first_length > 0 && second_length > 0; }
};
}  // namespace detail

template <std::floating_point T>
T laplacian(const geometry::MeshTopology& topology, const Array<T, 2>& positions) {
  require_shape("laplacian", "positions", positions, {topology.vertex_count, 3});
  std::vector<double> degree;
  double sum = 0;
  for (const auto& delta : detail::umbrellas(topology, positions, degree)) sum += geometry::dot(delta, delta);
  return topology.vertex_count == 0 ? T(0) : static_cast<T>(sum / static_cast<double>(topology.vertex_count));
}

template <std::floating_point T>
void laplacian_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions, T loss_adjoint,
                       Array<T, 2>& positions_adjoint) {
  require_shape("laplacian_adjoint", "positions", positions, {topology.vertex_count, 3});
  require_shape("laplacian_adjoint", "positions_adjoint", positions_adjoint, positions.shape());
  std::vector<double> degree;
  auto deltas = detail::umbrellas(topology, positions, degree);
  const double scale = 2 * static_cast<double>(loss_adjoint) / static_cast<double>(topology.vertex_count);
  for (std::size_t v = 0; v < deltas.size(); ++v)
    if (degree[v] > 0) deltas[v] = geometry::scale(deltas[v], scale / degree[v]);
  for (const auto& [a, b] : topology.edges) {  // for each step b − a
    const auto step_adjoint = geometry::subtract(deltas[a], deltas[b]);
    detail::add_to_row(positions_adjoint, b, step_adjoint);
    detail::add_to_row(positions_adjoint, a, geometry::scale(step_adjoint, -1));
  }
}

template <std::floating_point T>
T edge_length(const geometry::MeshTopology& topology, const Array<T, 2>& positions, double length) {
  require_shape("edge_length", "positions", positions, {topology.vertex_count, 3});
  double sum = 0;
  for (const auto& [a, b] : topology.edges) {
    const double off =
        geometry::length(geometry::subtract(detail::row(positions, b), detail::row(positions, a))) - length;
    sum += off * off;
  }
  return topology.edges.empty() ? T(0) : static_cast<T>(sum / static_cast<double>(topology.edges.size()));
}

template <std::floating_point T>
void edge_length_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions, double length,
                         T loss_adjoint, Array<T, 2>& positions_adjoint) {
  require_shape("edge_length_adjoint", "positions", positions, {topology.vertex_count, 3});
  require_shape("edge_length_adjoint", "positions_adjoint", positions_adjoint, positions.shape());
  const double scale = 2 * static_cast<double>(loss_adjoint) / static_cast<double>(topology.edges.size());
  for (const auto& [a, b] : topology.edges) {
    const auto step = geometry::subtract(detail::row(positions, b), detail::row(positions, a));
    const double size = geometry::length(step);
    if (!(size > 0)) continue;
    const auto step_adjoint = geometry::scale(step, scale * (size - length) / size);
    detail::add_to_row(positions_adjoint, b, step_adjoint);
    detail::add_to_row(positions_adjoint, a, geometry::scale(step_adjoint, -1));
  }
}

template <std::floating_point T>
T normal_consistency(const geometry::MeshTopology& topology, const Array<T, 2>& positions) {
  require_shape("normal_consistency", "positions", positions, {topology.vertex_count, 3});
  double sum = 0;
  for (const auto& hinge : topology.hinges) sum += 1 - detail::HingeNormals(positions, hinge).cosine;
  return topology.hinges.empty() ? T(0) : static_cast<T>(sum / static_cast<double>(topology.hinges.size()));
}

template <std::floating_point T>
void normal_consistency_adjoint(const geometry::MeshTopology& topology, const Array<T, 2>& positions,
                                T loss_adjoint, Array<T, 2>& positions_adjoint) {
  require_shape("normal_consistency_adjoint", "positions", positions, {topology.vertex_count, 3});
  require_shape("normal_consistency_adjoint", "positions_adjoint", positions_adjoint, positions.shape());
  const double scale = -static_cast<double>(loss_adjoint) / static_cast<double>(topology.hinges.size());
  for (const auto& hinge : topology.hinges) {
    const detail::HingeNormals at(positions, hinge);
    if (!at.has_area()) continue;
    // ∂cos/∂N = (n' − cos · n)/|N|, n and n' being the unit normals.
    const auto by_normal = [&](const geometry::Vector3& own, double length, const geometry::Vector3& other,
                               double other_length) {
      return geometry::scale(geometry::subtract(geometry::scale(other, 1 / other_length),
                                                geometry::scale(own, at.cosine / length)),
                             scale / length);
    };
    const auto first = by_normal(at.first, at.first_length, at.second, at.second_length);
    const auto second = by_normal(at.second, at.second_length, at.first, at.first_length);
    const auto to_c = geometry::cross(first, at.edge), to_d = geometry::cross(at.edge, second);
    const auto edge = geometry::add(geometry::cross(at.to_c, first), geometry::cross(second, at.to_d));
    detail::add_to_row(positions_adjoint, hinge.b, edge);
    detail::add_to_row(positions_adjoint, hinge.c, to_c);
    detail::add_to_row(positions_adjoint, hinge.d, to_d);
    detail::add_to_row(positions_adjoint, hinge.a,
                       geometry::scale(geometry::add(edge, geometry::add(to_c, to_d)), -1));
  }
}

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
}  // namespace tapestry::loss
