#include <tapestry/raster/silhouette.hpp>

#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/geometry_picture.hpp>
#include <tapestry/raster/render_variable.hpp>

#include "../support/active_tape.hpp"
#include "../support/brute_force_render.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/gradient_scoring.hpp"
#include "../support/paths.hpp"

using namespace tapestry;
using geometry::Mesh, geometry::Vector3;

namespace {
constexpr std::size_t size = 48;
constexpr double distance = 1.5;

Mesh sedan() {
  return geometry::normalise_mesh(io::read_obj(test::in_sources("examples/assets/car_sedan.obj")).mesh);
}

geometry::Camera camera() {
  return geometry::orbit_camera(std::numbers::pi / 4, std::numbers::pi / 9, distance, {0, 0, 0},
                                std::numbers::pi / 3);
}

Array<double, 1> some_pose() { return {0.1, -0.05, 0.2, 0.02, 0.05, -0.03}; }

/// Derivatives and the expected ones: the length of their difference, divided by that of the expected.
struct Score {
  double error_squared = 0, expected_squared = 0;
  void add(double found, double expected) {
    error_squared += (found - expected) * (found - expected);
    expected_squared += expected * expected;
  }
  [[nodiscard]] double error() const { return std::sqrt(error_squared / expected_squared); }
};

Mesh posed(Mesh mesh, const Array<double, 1>& pose) {
  const auto turned = geometry::exponential_map(Vector3{pose(0), pose(1), pose(2)});
  for (auto& position : mesh.positions)
    position = geometry::add(geometry::multiply(turned, position), {pose(3), pose(4), pose(5)});
  return mesh;
}

/// ⟨weights, picture⟩ of a supersampled picture of values_of(mesh, face, barycentric) of the mesh in a pose.
template <class ValuesOf>
double weighted(const Mesh& at_rest, const Array<double, 1>& pose, ValuesOf values_of) {
  const Mesh mesh = posed(at_rest, pose);
  const auto weights = test::scoring_weights(size);
  const auto image =
      test::brute_force_render(mesh, camera(), size, size, 16,
                               [&](std::size_t face, const auto& b) { return values_of(mesh, face, b); });
  return test::dot(image, weights);
}

/// Colours at positions over a background; white and black make it a silhouette.
auto painted(const Array<double, 2>& colours, const std::array<double, 3>& background) {
  return [&colours, background](const Mesh& mesh, std::size_t face, const std::array<double, 3>& b) {
    std::array<double, 3> colour{};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c)
        colour[c] += b[k] * (colours(static_cast<std::size_t>(mesh.faces[face][k]), c) - background[c]);
    return colour;
  };
}

/// Scores the adjoints of positions and pose against central differences of weighted(), a quarter of a pixel
/// there and back.
template <class ValuesOf>
std::array<Score, 2> score(const Array<double, 2>& positions_adjoint, const Array<double, 1>& pose_adjoint,
                           ValuesOf values_of) {
  const Mesh mesh = sedan();
  const double pixel = distance * 2 * camera().tan_half_fov_x / static_cast<double>(size), step = 0.25;
  std::array<Score, 2> scores;
  for (std::size_t kind = 0; kind < test::scoring_motions; ++kind) {
    const auto motion = test::scoring_motion(mesh, camera(), kind, pixel);
    Mesh ahead = mesh, behind = mesh;
    double found = 0;
    for (std::size_t i = 0; i < motion.size(); ++i) {
      ahead.positions[i] = geometry::add(mesh.positions[i], geometry::scale(motion[i], step));
      behind.positions[i] = geometry::subtract(mesh.positions[i], geometry::scale(motion[i], step));
      for (std::size_t k = 0; k < 3; ++k) found += positions_adjoint(i, k) * motion[i][k];
    }
    scores[0].add(
        found,
        (weighted(ahead, some_pose(), values_of) - weighted(behind, some_pose(), values_of)) / (2 * step));
  }
  for (std::size_t axis = 0; axis < 6; ++axis) {
    auto ahead = some_pose(), behind = some_pose();
    ahead(axis) += step * pixel;
    behind(axis) -= step * pixel;
    scores[1].add(pose_adjoint(axis), (weighted(mesh, ahead, values_of) - weighted(mesh, behind, values_of)) /
                                          (2 * step * pixel));
  }
  return scores;
}
}  // namespace

TEST_CASE("through silhouettes, positions and pose have the gradient of a supersampled picture",
          "[raster][silhouette][gradient][long]") {
  const Mesh mesh = sedan();
  const auto weights = test::scoring_weights(size);
  auto seed = tapestry::zeros<double, 2>({size, size});
  for (std::size_t i = 0; i < weights.size(); ++i) seed.data()[i / 3] += weights.data()[i];
  test::ActiveTape<double> tape;
  const auto positions = tape.input(geometry::position_array<double>(mesh));
  const auto pose = tape.input(some_pose());
  tape.reverse(raster::silhouette(mesh, camera(), size, size, positions, pose), seed);
  const auto white = tapestry::filled<double, 2>({mesh.positions.size(), 3}, 1);
  const auto scores = score(positions.adjoint(), pose.adjoint(), painted(white, {0, 0, 0}));
  CHECK(scores[0].error() <= 0.05);
  CHECK(scores[1].error() <= 0.05);
}

TEST_CASE("over a background, positions and pose have the gradient of a supersampled picture",
          "[raster][variable][gradient][long]") {
  const Mesh mesh = sedan();
  const auto colours = test::scoring_colours(mesh);
  const auto weights = test::scoring_weights(size);
  const raster::PaintedMesh body{
      mesh, std::vector<std::uint8_t>(mesh.faces.size(), 1), {raster::TextureKind::vertex, 0, 0, 1, 0}};
  const std::array<double, 3> background{0.9, 0.2, 0.5};
  auto behind = tapestry::zeros<double, 2>({size, size});  // −Σ weights · background, what coverage hides
  for (std::size_t i = 0; i < weights.size(); ++i)
    behind.data()[i / 3] -= weights.data()[i] * background[i % 3];
  test::ActiveTape<double> tape;
  const auto positions = tape.input(geometry::position_array<double>(mesh));
  const auto pose = tape.input(some_pose());
  const auto drawn =
      raster::render(body, camera(), size, size, raster::Unlit{},
                     raster::RenderInputs<double>{.texels = colours, .positions = positions, .pose = pose});
  tape.reverse(tapestry::sum(drawn.picture * ArrayVariable<double, 3>(weights)) +
               tapestry::sum(drawn.coverage * ArrayVariable<double, 2>(behind)));
  const auto scores = score(positions.adjoint(), pose.adjoint(), painted(colours, background));
  CHECK(scores[0].error() <= 0.05);
  CHECK(scores[1].error() <= 0.05);
}

TEMPLATE_TEST_CASE("through depth, position and normal, positions and pose have a supersampled gradient",
                   "[raster][geometry_picture][gradient][long]", raster::Depth, raster::SurfacePosition,
                   raster::Normal) {
  const Mesh mesh = sedan();
  constexpr std::size_t rank = raster::geometry_rank<TestType>;
  const auto weights = test::scoring_weights(size);
  const Mesh body = posed(mesh, some_pose());
  const auto picture = raster::geometry_picture<TestType, double>(body, camera(), size, size);
  auto seed = tapestry::zeros<double, rank>(picture.shape());
  for (std::size_t i = 0; i < weights.size(); ++i) seed.data()[rank == 2 ? i / 3 : i] += weights.data()[i];
  std::vector<Vector3> moving(mesh.positions.size(), Vector3{0, 0, 0});
  raster::geometry_picture_adjoint<TestType>(body, camera(), seed, moving);
  // By the chain rule to the mesh at rest; by the pose as central differences of positions, to 1e-9.
  const auto turned = geometry::exponential_map(Vector3{some_pose()(0), some_pose()(1), some_pose()(2)});
  auto positions_adjoint = tapestry::zeros<double, 2>({moving.size(), 3});
  auto pose_adjoint = tapestry::zeros<double, 1>({6});
  for (std::size_t i = 0; i < moving.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      positions_adjoint(i, k) = geometry::multiply_transposed(turned, moving[i])[k];
  for (std::size_t axis = 0; axis < 6; ++axis) {
    auto ahead = some_pose(), behind = some_pose();
    ahead(axis) += 1e-5;
    behind(axis) -= 1e-5;
    const Mesh there = posed(mesh, ahead), back = posed(mesh, behind);
    for (std::size_t i = 0; i < moving.size(); ++i)
      pose_adjoint(axis) +=
          geometry::dot(moving[i], geometry::subtract(there.positions[i], back.positions[i])) / 2e-5;
  }
  const Vector3 eye = geometry::eye_of(camera());
  const auto scores =
      score(positions_adjoint, pose_adjoint,
            [&](const Mesh& at, std::size_t face, const std::array<double, 3>& b) -> std::array<double, 3> {
              if constexpr (std::is_same_v<TestType, raster::Normal>)
                return raster::seen_normal(at, face, eye);
              Vector3 point{};
              for (std::size_t k = 0; k < 3; ++k)
                point = geometry::add(
                    point, geometry::scale(at.positions[static_cast<std::size_t>(at.faces[face][k])], b[k]));
              if constexpr (std::is_same_v<TestType, raster::SurfacePosition>) return point;
              const double depth = geometry::view_from_world(camera(), point)[2];
              return {depth, depth, depth};
            });
  CHECK(scores[0].error() <= 0.05);
  CHECK(scores[1].error() <= 0.05);
}
