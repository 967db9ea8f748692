#include <tapestry/raster/silhouette_variable.hpp>

#include <cmath>
#include <numbers>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/geometry/carla_pose.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/render_variable.hpp>

#include "../support/brute_force_render.hpp"
#include "../support/catch.hpp"
#include "../support/gradient_scoring.hpp"

namespace raster = tapestry::raster;
namespace geometry = tapestry::geometry;
using geometry::Mesh;
using geometry::Vector3;
using tapestry::Array;
using tapestry::ArrayVariable;

namespace {

constexpr std::size_t size = 48;
constexpr double distance = 1.5;

Mesh sedan() {
  return geometry::normalise_mesh(
      tapestry::io::read_obj(TAPESTRY_SOURCE "/examples/assets/car_sedan.obj").mesh);
}

geometry::Camera camera() {
  return geometry::orbit_camera(std::numbers::pi / 4, std::numbers::pi / 9, distance, {0, 0, 0},
                                std::numbers::pi / 3);
}

Array<double, 1> some_pose() { return {0.1, -0.05, 0.2, 0.02, 0.05, -0.03}; }

/// Derivatives beside those expected: the length of their difference over that of the latter.
struct Score {
  double error_squared = 0, expected_squared = 0;
  void add(double found, double expected) {
    error_squared += (found - expected) * (found - expected);
    expected_squared += expected * expected;
  }
  [[nodiscard]] double error() const { return std::sqrt(error_squared / expected_squared); }
};

/// ⟨weights, picture over a background⟩ of a supersampled picture of colours at positions; white and black
/// make it a silhouette.
double loss(const Mesh& mesh, const Array<double, 1>& pose, const Array<double, 2>& colours,
            const std::array<double, 3>& background) {
  const auto seen_by = geometry::posed(camera(), {{pose(0), pose(1), pose(2)}, {pose(3), pose(4), pose(5)}});
  const auto weights = tapestry::test::scoring_weights(size);
  const auto image = tapestry::test::brute_force_render(
      mesh, seen_by, size, size, 16, [&](std::size_t face, const std::array<double, 3>& b) {
        std::array<double, 3> colour{};
        for (std::size_t k = 0; k < 3; ++k)
          for (std::size_t c = 0; c < 3; ++c)
            colour[c] += b[k] * (colours(static_cast<std::size_t>(mesh.faces[face][k]), c) - background[c]);
        return colour;
      });
  double sum = 0;
  for (std::size_t i = 0; i < image.size(); ++i) sum += image.data()[i] * weights.data()[i];
  return sum;
}

/// Scores the adjoints of positions and pose against central differences of loss(), a quarter of a pixel
/// there and back.
std::array<Score, 2> score(const Array<double, 2>& positions_adjoint, const Array<double, 1>& pose_adjoint,
                           const Array<double, 2>& colours, const std::array<double, 3>& background) {
  const Mesh mesh = sedan();
  const double pixel = distance * 2 * camera().tan_half_fov_x / static_cast<double>(size), step = 0.25;
  std::array<Score, 2> scores;
  for (std::size_t kind = 0; kind < tapestry::test::scoring_motions; ++kind) {
    const auto motion = tapestry::test::scoring_motion(mesh, camera(), kind, pixel);
    Mesh ahead = mesh, behind = mesh;
    double found = 0;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      ahead.positions[i] = geometry::add(mesh.positions[i], geometry::scale(motion[i], step));
      behind.positions[i] = geometry::subtract(mesh.positions[i], geometry::scale(motion[i], step));
      for (std::size_t k = 0; k < 3; ++k) found += positions_adjoint(i, k) * motion[i][k];
    }
    scores[0].add(found, (loss(ahead, some_pose(), colours, background) -
                          loss(behind, some_pose(), colours, background)) /
                             (2 * step));
  }
  for (std::size_t axis = 0; axis < 6; ++axis) {
    auto ahead = some_pose(), behind = some_pose();
    ahead(axis) += step * pixel;
    behind(axis) -= step * pixel;
    scores[1].add(pose_adjoint(axis),
                  (loss(mesh, ahead, colours, background) - loss(mesh, behind, colours, background)) /
                      (2 * step * pixel));
  }
  return scores;
}

}  // namespace

TEST_CASE("through silhouettes, positions and pose have the gradient of a supersampled picture",
          "[raster][silhouette][gradient]") {
  const Mesh mesh = sedan();
  const auto weights = tapestry::test::scoring_weights(size);
  auto seed = tapestry::zeros<double, 2>({size, size});
  for (std::size_t i = 0; i < weights.size(); ++i) seed.data()[i / 3] += weights.data()[i];
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto positions = tape.input(geometry::position_array<double>(mesh));
  const auto pose = tape.input(some_pose());
  tape.reverse(raster::silhouette(mesh, camera(), size, size, positions, pose), seed);
  const auto white = tapestry::filled<double, 2>({mesh.positions.size(), 3}, 1);
  const auto scores = score(positions.adjoint(), pose.adjoint(), white, {0, 0, 0});
  CHECK(scores[0].error() <= 0.05);
  CHECK(scores[1].error() <= 0.05);
}

TEST_CASE("over a background, positions and pose have the gradient of a supersampled picture",
          "[raster][variable][gradient]") {
  const Mesh mesh = sedan();
  const auto colours = tapestry::test::scoring_colours(mesh);
  const auto weights = tapestry::test::scoring_weights(size);
  const raster::PaintedMesh body{
      mesh, std::vector<std::uint8_t>(mesh.faces.size(), 1), {raster::TextureKind::vertex, 0, 0, 1, 0}};
  const std::array<double, 3> background{0.9, 0.2, 0.5};
  auto behind = tapestry::zeros<double, 2>({size, size});  // −Σ weights · background, what coverage hides
  for (std::size_t i = 0; i < weights.size(); ++i)
    behind.data()[i / 3] -= weights.data()[i] * background[i % 3];
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto positions = tape.input(geometry::position_array<double>(mesh));
  const auto pose = tape.input(some_pose());
  const auto drawn =
      raster::render(body, camera(), size, size, raster::Unlit{},
                     raster::RenderInputs<double>{.texels = colours, .positions = positions, .pose = pose});
  tape.reverse(tapestry::sum(drawn.picture * ArrayVariable<double, 3>(weights)) +
               tapestry::sum(drawn.coverage * ArrayVariable<double, 2>(behind)));
  const auto scores = score(positions.adjoint(), pose.adjoint(), colours, background);
  CHECK(scores[0].error() <= 0.05);
  CHECK(scores[1].error() <= 0.05);
}
