#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

// Score of gradients of pictures: the loss ⟨weights, picture⟩ of a mesh with a colour at every position,
// which moves in eight ways.
namespace tapestry::test {
/// Weights of a picture's values that change slowly over it, [size, size, 3].
[[nodiscard]] inline Array<double, 3> scoring_weights(std::size_t size) {
  Array<double, 3> weights(Extents<3>{size, size, 3});
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double row = static_cast<double>(i / (3 * size)) / static_cast<double>(size);
    const double column = static_cast<double>(i / 3 % size) / static_cast<double>(size);
    const auto c = static_cast<double>(i % 3);
    weights.data()[i] = std::sin(6 * row + c) * std::cos(5 * column + 2 * c) + 0.3;
  }
  return weights;
}

/// A colour for every position, smooth in the world, [V, 3] in [0, 1]; for meshes of about unit size.
[[nodiscard]] inline Array<double, 2> scoring_colours(const geometry::Mesh& mesh) {
  Array<double, 2> colours(Extents<2>{mesh.positions.size(), 3});
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const auto& p = mesh.positions[i];
    for (std::size_t c = 0; c < 3; ++c)
      colours(i, c) = 0.5 + 0.4 * std::sin(3 * p[c] + 2 * p[(c + 1) % 3] + static_cast<double>(c));
  }
  return colours;
}

inline constexpr std::size_t scoring_motions = 8;

/// x, y, scale, or one of five motions that bend the mesh.
/// \param kind   below scoring_motions
/// \param pixel  length of the motion in the world, about a pixel
[[nodiscard]] inline std::vector<geometry::Vector3> scoring_motion(const geometry::Mesh& mesh,
                                                                   const geometry::Camera& camera,
                                                                   std::size_t kind, double pixel) {
  Random random(100 + kind);
  std::array<std::array<double, 4>, 3> wave{};
  for (auto& row : wave)
    for (double& value : row) value = random.uniform(-4, 4);
  std::vector<geometry::Vector3> motion;
  for (const geometry::Vector3& p : mesh.positions) {
    geometry::Vector3 step = kind < 2 ? camera.rotation[kind] : p;
    for (std::size_t c = 0; kind > 2 && c < 3; ++c)
      step[c] = std::sin(wave[c][0] * p[0] + wave[c][1] * p[1] + wave[c][2] * p[2] + wave[c][3]);
    motion.push_back(geometry::scale(step, pixel));
  }
  return motion;
}
}  // namespace tapestry::test
