#pragma once
#include <tapestry/raster/detail/vertex_gradient.hpp>
#include "paint.hpp"
#include "random_array.hpp"
#include "simple_mesh.hpp"

namespace tapestry::test {
inline const raster::TextureLayout small_atlas{raster::TextureKind::atlas, 5, 7, 1, 0};
inline constexpr std::size_t side = 16;  // pixels; at depth 1 a unit of the world spans 8 of them

/// A mesh painted all over, with its texture and light.
template <class Model = raster::Unlit>
struct Scene : raster::PaintedMesh {
  explicit Scene(const geometry::Mesh& shape, const raster::TextureLayout& paint = solid, Model lamp = {})
      : PaintedMesh{shape, every_face(shape), paint},
        light(lamp),
        texels(random_array<double>({paint.texel_count(shape), 3}, 11, 0.1)) {}

  Model light;
  Array<double, 2> texels;

  [[nodiscard]] raster::Surface<double, Model> surface() const { return {*this, texels, light}; }
  template <class Policy = raster::BoundaryIntegral>
  [[nodiscard]] std::vector<geometry::Vector3> gradient(const Array<double, 3>& render_adjoint,
                                                        const Policy& policy = {}) const {
    std::vector<geometry::Vector3> sum(mesh.positions.size(), geometry::Vector3{0, 0, 0});
    raster::vertex_adjoint(surface(), geometry::Camera{}, render_adjoint, sum, policy);
    return sum;
  }
};

inline Array<double, 3> everywhere(double value) { return filled<double, 3>({side, side, 3}, value); }

/// Weights that change slowly over the picture.
inline Array<double, 3> smooth_weights() {
  auto weights = everywhere(0);
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const auto row = static_cast<double>(i / (3 * side)), column = static_cast<double>(i / 3 % side);
    weights.data()[i] = std::sin(0.3 * row + static_cast<double>(i % 3)) * std::cos(0.25 * column) + 0.4;
  }
  return weights;
}

inline double along(const std::vector<geometry::Vector3>& gradient,
                    const std::vector<geometry::Vector3>& direction) {
  double sum = 0;
  for (std::size_t i = 0; i < gradient.size(); ++i) sum += geometry::dot(gradient[i], direction[i]);
  return sum;
}

/// NaN, which no comparison holds for, if any component is not finite.
inline double largest_component(const std::vector<geometry::Vector3>& gradient) {
  double largest = 0;
  for (const geometry::Vector3& value : gradient)
    for (const double component : value) {
      if (!std::isfinite(component)) return std::numeric_limits<double>::quiet_NaN();
      largest = std::max(largest, std::abs(component));
    }
  return largest;
}

inline std::vector<geometry::Vector3> random_motion(std::size_t count, std::uint64_t seed) {
  Random random(seed);
  std::vector<geometry::Vector3> motion(count);
  for (auto& step : motion) step = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  return motion;
}

template <class Model>
Scene<Model> moved(Scene<Model> scene, const std::vector<geometry::Vector3>& motion, double step) {
  for (std::size_t i = 0; i < motion.size(); ++i)
    scene.mesh.positions[i] = geometry::add(scene.mesh.positions[i], geometry::scale(motion[i], step));
  return scene;
}

/// A closed cube seen from outside, its corners shared or each face with its own.
inline geometry::Mesh box(bool is_welded) {
  geometry::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    const double x = (i & 1) != 0 ? 0.7 : -0.6, y = (i & 2) != 0 ? 0.5 : -0.7, z = (i & 4) != 0 ? 0.6 : -0.6;
    mesh.positions.push_back({0.8 * x - 0.6 * z, y + 0.3 * z, 2.2 + 0.6 * x + 0.8 * z});
  }
  mesh.faces = {{0, 1, 3}, {0, 3, 2}, {4, 6, 7}, {4, 7, 5}, {0, 4, 5}, {0, 5, 1},
                {2, 3, 7}, {2, 7, 6}, {0, 2, 6}, {0, 6, 4}, {1, 5, 7}, {1, 7, 3}};
  if (is_welded) return mesh;
  std::vector<std::array<geometry::Vector3, 3>> triangles;
  for (const auto& face : mesh.faces) {
    triangles.push_back({mesh.positions[static_cast<std::size_t>(face[0])],
                         mesh.positions[static_cast<std::size_t>(face[1])],
                         mesh.positions[static_cast<std::size_t>(face[2])]});
  }
  return triangle_soup(triangles);
}
}  // namespace tapestry::test
