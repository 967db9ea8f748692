#include <cmath>
#include <numbers>
#include <tapestry/raster/lighting.hpp>
#include <type_traits>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
namespace geometry = tapestry::geometry;
using geometry::Vector3;

namespace {
const raster::Light light{0.25, 0.5, {0, 0, 3}, {1, 0.5, 0.25}};
const auto above = geometry::look_at({-1, 0, 6}, {0, 0, 0}, {0, 0, 1}, 1);

/// A roof: two faces that share the ridge from (0, −1, 1) to (0, 1, 1) and fall to both sides.
geometry::Mesh roof() {
  geometry::Mesh mesh;
  mesh.positions = {{0, -1, 1}, {0, 1, 1}, {-1, 0, 0}, {1, 0, 0}};
  mesh.faces = {{0, 1, 2}, {1, 0, 3}};
  return mesh;
}
}  // namespace

TEST_CASE("smooth light at a ridge is that of the mean normal", "[raster][light]") {
  const auto mesh = roof();
  const auto prepared = raster::prepare(mesh, above, raster::SmoothLight{light});
  const auto flat = raster::prepare(mesh, above, light);
  for (const std::size_t face : {std::size_t{0}, std::size_t{1}}) {
    CHECK(flat.at(face, {1, 0, 0}) == Approx(0.25 + 0.5 * std::sqrt(0.5)));
    CHECK(prepared.at(face, {0.5, 0.5, 0}) == Approx(0.75));                  // on the ridge the normal is up
    CHECK(prepared.at(face, {0, 0, 1}) == Approx(flat.at(face, {0, 0, 1})));  // one face only
  }
  CHECK(prepared.light_colour == light.colour);
}

TEST_CASE("the mesh's own normals win, and turn to the side that is seen", "[raster][light]") {
  auto mesh = roof();
  mesh.normals = {{0, 0, 1}};
  mesh.face_normals = {{0, 0, 0}, {-1, -1, -1}};
  const auto seen = raster::prepare(mesh, above, raster::SmoothLight{light});
  CHECK(seen.at(0, {0, 0, 1}) == Approx(0.75));
  CHECK(seen.at(1, {0, 0, 1}) < 0.7);
  const auto below = geometry::look_at({-0.1, 0, -4}, {0, 0, 0}, {0, 0, 1}, 1);
  CHECK(raster::prepare(mesh, below, raster::SmoothLight{light}).at(0, {0, 0, 1}) == 0.25);
}

TEST_CASE("smooth light over a sphere follows the true normal", "[raster][light]") {
  geometry::Mesh mesh;  // rings of a sphere of radius 1
  const int rings = 24, around = 48;
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const double polar = std::numbers::pi * i / rings, turn = 2 * std::numbers::pi * j / around;
      mesh.positions.push_back(
          {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)});
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < around; ++j) {
      const int right = (j + 1) % around;
      const std::int32_t a = i * around + j, b = i * around + right;
      mesh.faces.push_back({a, a + around, b});
      mesh.faces.push_back({b, a + around, b + around});
    }
  }
  const auto camera = geometry::look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, 1);
  const auto smooth = raster::prepare(mesh, camera, raster::SmoothLight{light});
  double error = 0;
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    Vector3 point{};
    for (const auto corner : mesh.faces[face])
      point =
          geometry::add(point, geometry::scale(mesh.positions[static_cast<std::size_t>(corner)], 1.0 / 3));
    if (point[2] < 0.3) continue;  // the side that is seen
    const double expected = 0.25 + 0.5 * geometry::normalised(point)[2];
    error = std::max(error, std::abs(smooth.at(face, {1.0 / 3, 1.0 / 3, 1.0 / 3}) - expected));
  }
  CHECK(error <= 0.01);  // faces span 7.5°
}

TEST_CASE("no light takes no memory, bad light is refused", "[raster][light]") {
  const auto mesh = roof();
  CHECK(raster::prepare(mesh, above, raster::Unlit{}).at(0, {1, 0, 0}) == 1);
  CHECK(std::is_trivially_copyable_v<raster::PreparedUnlit>);
  raster::SmoothLight dark{light};
  dark.direction = {0, 0, 0};
  CHECK_THROWS_AS(raster::prepare(mesh, above, dark), tapestry::DomainError);
}
