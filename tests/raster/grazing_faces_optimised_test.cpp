#include <tapestry/io/obj_file.hpp>

#include "../support/catch.hpp"
#include "../support/edge_on_scene.hpp"
#include "../support/paths.hpp"

namespace geometry = tapestry::geometry;
using tapestry::test::EdgeOnScene;

namespace {
void check_views(const geometry::Mesh& mesh, const std::vector<double>& heights, std::size_t lines) {
  const EdgeOnScene scene(mesh, 256);
  for (const double height : heights)
    for (const double azimuth : {std::numbers::pi / 2, std::numbers::pi / 2 + 0.3}) {
      CAPTURE(height, azimuth);
      for (const double error : scene.errors(height, azimuth, lines)) CHECK(error <= 0.03);
    }
}
}  // namespace

// Sampled alone, the errors of the box were .15 to .82, of the truck up to .96, of the van up to 1.08.
TEST_CASE("a box's bottom nearly edge-on moves as the exact picture does at 256 pixels",
          "[raster][vertex_gradient][gradient][hard_case][long][repeated]") {
  check_views(tapestry::test::edge_on_box(), {-0.001, -0.005, -0.02, -0.05, -0.1, -0.2}, 16);
}

TEST_CASE("a truck's floors nearly edge-on move as the exact picture does",
          "[raster][vertex_gradient][gradient][hard_case][long]") {
  check_views(tapestry::test::edge_on_truck(), {-0.205, -0.123, -0.118, -0.105, -0.083, -0.06}, 16);
}

TEST_CASE("the bundled van, seen from the height of its floor, moves as the exact picture does",
          "[raster][vertex_gradient][gradient][hard_case][long]") {
  auto mesh = tapestry::io::read_obj(tapestry::test::in_sources("examples/assets/van.obj")).mesh;
  geometry::Vector3 low = mesh.positions[0], high = low;
  for (const auto& p : mesh.positions)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  for (auto& p : mesh.positions)  // to a length of 2 about the origin; its floor at z = −0.3238
    for (std::size_t axis = 0; axis < 3; ++axis)
      p[axis] = (p[axis] - (low[axis] + high[axis]) / 2) * 2 / (high[0] - low[0]);
  check_views(mesh, {-0.3248, -0.3298, -0.3358}, 8);
}
