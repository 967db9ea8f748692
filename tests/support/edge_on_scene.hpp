#pragma once
#include <tapestry/raster/geometry_picture.hpp>
#include "column_picture.hpp"
#include "gradient_scoring.hpp"
#include "paint.hpp"

namespace tapestry::test {
/// Adds a closed box of 8 positions.
inline void add_box(geometry::Mesh& mesh, const geometry::Vector3& low, const geometry::Vector3& high) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (int i = 0; i < 8; ++i)
    mesh.positions.push_back(
        {(i & 1) != 0 ? high[0] : low[0], (i & 2) != 0 ? high[1] : low[1], (i & 4) != 0 ? high[2] : low[2]});
  const geometry::Corners faces[] = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                                     {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  for (const geometry::Corners& face : faces)
    mesh.faces.push_back({face[0] + first, face[1] + first, face[2] + first});
}

/// A box whose bottom lies at z = 0.
[[nodiscard]] inline geometry::Mesh edge_on_box() {
  geometry::Mesh mesh;
  add_box(mesh, {-1, -0.45, 0}, {1, 0.45, 0.7});
  return mesh;
}

/// A frame from z = −0.2 to −0.12 between wheels, a cab over it from −0.1 and a body from −0.08: planes of
/// one normal at several heights, which hide parts of each other.
[[nodiscard]] inline geometry::Mesh edge_on_truck() {
  geometry::Mesh mesh;
  add_box(mesh, {-1, -0.3, -0.2}, {1, 0.3, -0.12});
  add_box(mesh, {0.55, -0.35, -0.1}, {1, 0.35, 0.45});
  add_box(mesh, {-1, -0.38, -0.08}, {0.5, 0.38, 0.55});
  for (const double x : {-0.7, -0.4, 0.75}) {
    add_box(mesh, {x - 0.13, 0.31, -0.4}, {x + 0.13, 0.38, -0.14});
    add_box(mesh, {x - 0.13, -0.38, -0.4}, {x + 0.13, -0.31, -0.14});
  }
  return mesh;
}

/// A mesh with z upwards, seen along the horizon from a distance of 3, half-angle 30°, with a colour at every
/// position, or its position itself. Motions along z keep the columns of all positions, so that a
/// ColumnPicture is smooth in them.
class EdgeOnScene {
 public:
  enum class Shown { colours, positions };

  EdgeOnScene(geometry::Mesh mesh, std::size_t size, Shown shown = Shown::colours)
      : mesh_(std::move(mesh)),
        shown_(shown),
        colours_(scoring_colours(mesh_)),
        weights_(scoring_weights(size)) {}

  [[nodiscard]] static geometry::Camera camera_at(double height, double azimuth_rad) {
    return geometry::look_at({3 * std::cos(azimuth_rad), 3 * std::sin(azimuth_rad), height}, {0, 0, height},
                             {0, 0, 1}, std::numbers::pi / 3);
  }

  template <std::floating_point T>
  [[nodiscard]] std::vector<geometry::Vector3> gradient(const geometry::Camera& camera,
                                                        std::size_t samples) const {
    const raster::PaintedMesh body{mesh_, every_face(mesh_), vertex};
    const auto texels = cast<T>(colours_);
    const raster::Unlit unlit;
    std::vector<geometry::Vector3> sum(mesh_.positions.size(), geometry::Vector3{0, 0, 0});
    if (shown_ == Shown::positions) {
      raster::geometry_picture_adjoint<raster::SurfacePosition>(mesh_, camera, cast<T>(weights_), sum,
                                                                samples);
      return sum;
    }
    raster::vertex_adjoint(raster::Surface<T, raster::Unlit>{body, texels, unlit}, camera, cast<T>(weights_),
                           sum, raster::BoundaryIntegral{samples});
    return sum;
  }

  /// Errors of the derivatives along six vertical motions, relative to central differences of a ColumnPicture
  /// with so many lines a pixel, for 1, 2, 4 and 8 samples an axis. The first motion raises the lowest tenth.
  [[nodiscard]] std::array<double, 4> errors(double height, double azimuth_rad, std::size_t lines) const {
    const auto camera = camera_at(height, azimuth_rad);
    std::vector<std::vector<double>> motions;
    std::vector<double> expected;
    for (std::uint64_t kind = 0; kind < 6; ++kind) {
      motions.push_back(motion(kind));
      constexpr double h = 1e-6;  // a ten-thousandth of a plane .01 px thick and more
      expected.push_back((loss(camera, motions.back(), h, lines) - loss(camera, motions.back(), -h, lines)) /
                         (2 * h));
    }
    std::array<double, 4> errors{};
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const auto gradient = this->gradient<double>(camera, std::size_t{1} << i);
      double error = 0, size = 0;
      for (std::size_t kind = 0; kind < motions.size(); ++kind) {
        double found = 0;
        for (std::size_t k = 0; k < gradient.size(); ++k) found += gradient[k][2] * motions[kind][k];
        error += (found - expected[kind]) * (found - expected[kind]);
        size += expected[kind] * expected[kind];
      }
      errors[i] = std::sqrt(error / size);
    }
    return errors;
  }

 private:
  [[nodiscard]] std::vector<double> motion(std::uint64_t kind) const {
    Random random(100 + kind);
    std::array<double, 4> wave;
    for (double& value : wave) value = random.uniform(-4, 4);
    double low = mesh_.positions[0][2], high = low;
    for (const geometry::Vector3& p : mesh_.positions) {
      low = std::min(low, p[2]);
      high = std::max(high, p[2]);
    }
    std::vector<double> steps;
    for (const geometry::Vector3& p : mesh_.positions)
      steps.push_back(kind == 0 ? (p[2] <= low + 0.1 * (high - low) ? 1.0 : 0.0)
                                : std::sin(wave[0] * p[0] + wave[1] * p[1] + wave[2] * p[2] + wave[3]));
    return steps;
  }

  [[nodiscard]] double loss(const geometry::Camera& camera, const std::vector<double>& motion, double step,
                            std::size_t lines) const {
    geometry::Mesh moved = mesh_;
    for (std::size_t i = 0; i < motion.size(); ++i) moved.positions[i][2] += step * motion[i];
    Array<double, 2> shown = colours_;
    for (std::size_t i = 0; shown_ == Shown::positions && i < shown.size(); ++i)
      shown.data()[i] = moved.positions[i / 3][i % 3];
    return ColumnPicture(shown, weights_, lines).loss(moved, camera);
  }

  geometry::Mesh mesh_;
  Shown shown_;
  Array<double, 2> colours_;
  Array<double, 3> weights_;
};
}  // namespace tapestry::test
