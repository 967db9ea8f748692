#pragma once
#include <tapestry/geometry/pose.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include "../../examples/scenes/car.hpp"
#include "../../tests/support/gradient_scoring.hpp"

namespace tapestry::benchmarks {
/// The scene that every renderer draws: a car of length 2 around the origin, seen from a distance at
/// elevation 20° and three azimuths with a field of view of 60°, its paint an atlas under white light.
/// Gradients are scored in one more view, azimuth 45° of Neural Mesh Renderer's camera, for which figures of
/// other renderers are known.
struct Scene {
  geometry::Mesh mesh;
  double distance;
  std::vector<geometry::Camera> cameras;
  geometry::Camera scored_camera;
  raster::TextureLayout layout{raster::TextureKind::atlas, 1024, 1024, 2, 0};
  Array<float, 2> texels;  ///< [1024², 3], in [0, 1]
};

/// Smooth noise of a few octaves, so that lookups between texels mean something.
[[nodiscard]] inline Array<float, 2> painted_texels(const raster::TextureLayout& layout) {
  Array<float, 2> texels(Extents<2>{layout.height * layout.width, 3});
  Random random(1);
  std::array<double, 12> phase{};
  for (double& value : phase) value = random.uniform(0, 2 * std::numbers::pi);
  for (std::size_t i = 0; i < texels.shape(0); ++i) {
    const double row = static_cast<double>(i / layout.width), column = static_cast<double>(i % layout.width);
    for (std::size_t c = 0; c < 3; ++c) {
      const double* const shift = phase.data() + 4 * c;
      const double coarse = std::sin(row / 40 + shift[0]) * std::sin(column / 35 + shift[1]);
      const double fine = std::sin(row / 4 + shift[2]) * std::sin(column / 5 + shift[3]);
      texels(i, c) = static_cast<float>(0.5 + 0.3 * coarse + 0.2 * fine);
    }
  }
  return texels;
}

/// The mesh of a file, or a procedural car of about as many faces as the real one where the path is empty.
/// Corners without uv, which the real car does not have, get the first one.
[[nodiscard]] inline geometry::Mesh load_car(const std::string& path) {
  geometry::Mesh mesh;
  if (path.empty()) {
    scenes::CarOptions options;
    options.spacing = 0.031;
    mesh = scenes::make_car(options);
  } else {
    mesh = io::read_obj(path).mesh;
  }
  if (mesh.uvs.empty()) mesh.uvs.push_back({0, 0});
  mesh.face_uvs.resize(mesh.faces.size(), {-1, -1, -1});
  for (geometry::Corners& corners : mesh.face_uvs)
    for (std::int32_t& uv : corners) uv = std::max(uv, 0);
  return geometry::normalise_mesh(std::move(mesh));
}

[[nodiscard]] inline Scene make_scene(const std::string& mesh_path, double distance) {
  Scene scene;
  scene.mesh = load_car(mesh_path);
  scene.distance = distance;
  constexpr double rad_per_deg = std::numbers::pi / 180;
  scene.scored_camera =
      geometry::neural_mesh_renderer_camera(45 * rad_per_deg, 20 * rad_per_deg, distance, 30 * rad_per_deg);
  for (const double azimuth : {45.0, 165.0, 285.0}) {
    scene.cameras.push_back(geometry::orbit_camera(azimuth * rad_per_deg, 20 * rad_per_deg, distance,
                                                   {0, 0, 0}, 60 * rad_per_deg));
  }
  scene.texels = painted_texels(scene.layout);
  return scene;
}

/// The motions that gradients of positions are scored along, in the view scored_camera of that size.
[[nodiscard]] inline std::vector<std::vector<geometry::Vector3>> scored_motions(const Scene& scene,
                                                                                std::size_t size) {
  const double pixel = scene.distance * 2 * scene.scored_camera.tan_half_fov_x / static_cast<double>(size);
  std::vector<std::vector<geometry::Vector3>> motions;
  for (std::size_t kind = 0; kind < test::scoring_motions; ++kind)
    motions.push_back(test::scoring_motion(scene.mesh, scene.scored_camera, kind, pixel));
  return motions;
}
}  // namespace tapestry::benchmarks
