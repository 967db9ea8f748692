#include <tapestry/geometry/point_columns.hpp>
#include <tapestry/raster/silhouette.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/vertex_gradient_scene.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Vector3;

namespace {
Array<double, 2> pixel_weights() { return test::random_array<double>({side, side}, 4, -1); }

std::vector<Vector3> gradient_of(const geometry::Mesh& mesh, const Array<double, 2>& weights) {
  std::vector<Vector3> gradient(mesh.positions.size(), Vector3{0, 0, 0});
  raster::silhouette_adjoint(mesh, Camera{}, weights, gradient);
  return gradient;
}
}  // namespace

TEST_CASE("a half plane that moves covers more by its edge's length", "[raster][silhouette]") {
  // Its edge stands at column 9.3; a unit of the world spans 8 pixels there.
  const double x = 9.3 / 8 - 1;
  const auto mesh = test::triangle_soup({{Vector3{x, -30, 1}, Vector3{x, 30, 1}, Vector3{-60, 0, 1}}});
  const auto coverage = raster::silhouette<double>(mesh, Camera{}, side, side);
  for (std::size_t column = 0; column < side; ++column)
    CHECK(coverage(5, column) == (column < 9 ? 1 : column == 9 ? 0.25 : 0));  // one column of samples of four
  auto weights = tapestry::zeros<double, 2>({side, side});
  for (std::size_t row = 0; row < side; ++row) weights(row, 9) = static_cast<double>(row);  // Σ = 120
  const auto gradient = gradient_of(mesh, weights);
  CHECK(along(gradient, std::vector<Vector3>(3, {1, 0, 0})) == Approx(8 * 120).epsilon(1e-12));
  CHECK(std::abs(along(gradient, std::vector<Vector3>(3, {0, 1, 0}))) <= 1e-9);
}

TEST_CASE("a silhouette's gradient is that of a picture of one white paint", "[raster][silhouette]") {
  const auto weights = pixel_weights();
  for (const bool is_box : {true, false}) {
    test::Scene<> scene{is_box ? box(true) : test::random_triangles(40, 3, 0.9)};
    scene.texels = tapestry::filled<double, 2>({1, 3}, 1);
    auto in_red = test::everywhere(0);
    for (std::size_t i = 0; i < weights.size(); ++i) in_red.data()[3 * i] = weights.data()[i];
    const auto expected = scene.gradient(in_red), found = gradient_of(scene.mesh, weights);
    double size = 0, error = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      size = std::max(size, geometry::length(expected[i]));
      error = std::max(error, geometry::length(geometry::subtract(found[i], expected[i])));
    }
    CHECK(size > 1);
    CHECK(error <= 1e-9 * size);
  }
}

TEST_CASE("a silhouette on the tape depends on positions and pose", "[raster][silhouette][variable]") {
  const geometry::Mesh mesh = box(true);
  const auto weights = pixel_weights();
  ActiveTape<double> tape;
  const auto positions = tape.input(geometry::position_array<double>(mesh));
  const auto pose = tape.input(tapestry::zeros<double, 1>({6}));
  const std::size_t before = tape.record_count();
  const auto coverage = raster::silhouette(mesh, Camera{}, side, side, positions, pose);
  CHECK(tape.record_count() == before + 1);
  CHECK((coverage.value() == raster::silhouette<double>(mesh, Camera{}, side, side)));
  CHECK((raster::silhouette(mesh, Camera{}, side, side, {}, pose).value() == coverage.value()));
  tape.reverse(coverage, weights);
  const auto gradient = gradient_of(mesh, weights);
  Vector3 shift{};  // moves all positions at once, as the pose's translation does
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    shift = geometry::add(shift, gradient[i]);
    for (std::size_t k = 0; k < 3; ++k) CHECK(positions.adjoint()(i, k) == gradient[i][k]);
  }
  for (std::size_t k = 0; k < 3; ++k) CHECK(pose.adjoint()(k + 3) == Approx(shift[k]).epsilon(1e-12));
}

TEST_CASE("silhouettes refuse what does not fit", "[raster][silhouette][bad_input]") {
  std::vector<Vector3> gradient(7);
  CHECK_THROWS_WITH(raster::silhouette_adjoint(box(true), Camera{}, pixel_weights(), gradient),
                    "silhouette_adjoint: positions_adjoint is [7], expected [8], one entry a position");
  CHECK_THROWS_WITH(raster::silhouette(box(true), Camera{}, side, side,
                                       ArrayVariable<double, 2>(tapestry::zeros<double, 2>({7, 3}))),
                    "silhouette: positions is [7, 3], expected [8, 3]");
}
