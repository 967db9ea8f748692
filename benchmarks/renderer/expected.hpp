#pragma once
#include <numeric>
#include "reference.hpp"
#include "scene.hpp"

namespace tapestry::benchmarks {
/// The face of every pixel's centre.
[[nodiscard]] inline std::vector<double> expected_faces(const Scene& scene, std::size_t size) {
  std::vector<double> faces(size * size);
  ReferenceView(scene.mesh, scene.cameras.front(), size)
      .for_each_row([&](std::size_t row, const ReferenceView::Hit* hits) {
        for (std::size_t i = 0; i < size; ++i) faces[row * size + i] = hits[i].face;
      });
  return faces;
}

/// Share of the samples that show a face in either answer in which the two differ.
[[nodiscard]] inline double share_of_differences(const std::vector<float>& found,
                                                 const std::vector<double>& expected) {
  if (found.size() != expected.size()) throw Error(ErrorKind::mismatch, "an answer of another size");
  double differing = 0, covered = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    covered += found[i] >= 0 || expected[i] >= 0 ? 1 : 0;
    differing += static_cast<double>(found[i]) != expected[i] ? 1 : 0;
  }
  return differing / std::max(covered, 1.0);
}

/// A frame, [size, size, 3]: means over 8 × 8 samples a pixel.
[[nodiscard]] inline std::vector<double> expected_frame(const Scene& scene, std::size_t size) {
  constexpr std::size_t axis = 8;
  constexpr double share = 1.0 / (axis * axis);
  std::vector<double> picture(3 * size * size, 0);
  ReferenceView(scene.mesh, scene.cameras.front(), axis * size)
      .for_each_row([&](std::size_t row, const ReferenceView::Hit* hits) {  // rows of a pixel share a thread
        for (std::size_t i = 0; i < axis * size; ++i) {
          if (hits[i].face < 0) continue;
          std::array<double, 2> uv{0, 0};
          const geometry::Corners& corners = scene.mesh.face_uvs[static_cast<std::size_t>(hits[i].face)];
          for (std::size_t k = 0; k < 3; ++k)
            for (std::size_t a = 0; a < 2; ++a)
              uv[a] += hits[i].barycentric[k] * scene.mesh.uvs[static_cast<std::size_t>(corners[k])][a];
          double* const pixel = picture.data() + 3 * (row / axis * size + i / axis);
          raster::visit_atlas_taps(scene.layout, uv, [&](const raster::Tap& tap) {
            for (std::size_t c = 0; c < 3; ++c)
              pixel[c] += share * tap.weight * static_cast<double>(scene.texels(tap.texel, c));
          });
        }
      });
  return picture;
}

/// Samples a pixel, along an axis, of what gradients are scored against.
inline constexpr std::size_t scoring_samples = 16;

/// ∂⟨weights, picture⟩/∂(red of a face), the picture showing one colour a face.
[[nodiscard]] inline std::vector<double> expected_face_gradient(const Scene& scene, std::size_t size) {
  constexpr std::size_t axis = scoring_samples;
  const Array<double, 3> weights = test::scoring_weights(size);
  std::vector<double> gradient(scene.mesh.faces.size(), 0);
  ReferenceView(scene.mesh, scene.scored_camera, axis * size)
      .for_each_row([&](std::size_t row, const ReferenceView::Hit* hits) {
        for (std::size_t i = 0; i < axis * size; ++i) {
          if (hits[i].face < 0) continue;
          const double weight = weights(row / axis, i / axis, 0) / (axis * axis);
          std::atomic_ref(gradient[static_cast<std::size_t>(hits[i].face)]) += weight;
        }
      });
  return gradient;
}

/// ⟨weights, picture⟩ of a mesh with colours of its positions.
[[nodiscard]] inline double scored_loss(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                        std::size_t size, const Array<double, 2>& colours) {
  constexpr std::size_t axis = scoring_samples;
  const Array<double, 3> weights = test::scoring_weights(size);
  std::vector<double> rows(axis * size, 0);
  ReferenceView(mesh, camera, axis * size).for_each_row([&](std::size_t row, const ReferenceView::Hit* hits) {
    for (std::size_t i = 0; i < axis * size; ++i) {
      if (hits[i].face < 0) continue;
      const geometry::Corners& corners = mesh.faces[static_cast<std::size_t>(hits[i].face)];
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t k = 0; k < 3; ++k)
          rows[row] += weights(row / axis, i / axis, c) * hits[i].barycentric[k] *
                       colours(static_cast<std::size_t>(corners[k]), c);
    }
  });
  return std::accumulate(rows.begin(), rows.end(), 0.0) / (axis * axis);
}

/// Derivatives of scored_loss() along the scored motions: central differences, a quarter of a pixel there and
/// back.
[[nodiscard]] inline std::vector<double> expected_motion_derivatives(const Scene& scene, std::size_t size) {
  constexpr double step = 0.25;
  const Array<double, 2> colours = test::scoring_colours(scene.mesh);
  std::vector<double> derivatives;
  for (const auto& motion : scored_motions(scene, size)) {
    const auto loss_at = [&](double way) {
      geometry::Mesh mesh = scene.mesh;
      for (std::size_t i = 0; i < motion.size(); ++i)
        mesh.positions[i] = geometry::add(mesh.positions[i], geometry::scale(motion[i], way));
      return scored_loss(mesh, scene.scored_camera, size, colours);
    };
    derivatives.push_back((loss_at(step) - loss_at(-step)) / (2 * step));
  }
  return derivatives;
}
}  // namespace tapestry::benchmarks
