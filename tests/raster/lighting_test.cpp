#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/outdoor_light.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
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
  CHECK_THROWS_AS(raster::prepare(mesh, above, dark), DomainError);
}

namespace {
/// A mesh and a rectangle beside it: origin, origin + a, origin + a + b, origin + b.
geometry::Mesh with_rectangle(geometry::Mesh mesh, const Vector3& origin, const Vector3& a,
                              const Vector3& b) {
  const auto first = static_cast<std::int32_t>(mesh.positions.size());
  for (const Vector3& corner : {origin, geometry::add(origin, a), geometry::add(geometry::add(origin, a), b),
                                geometry::add(origin, b)})
    mesh.positions.push_back(corner);
  mesh.faces.push_back({first, first + 1, first + 2});
  mesh.faces.push_back({first, first + 2, first + 3});
  return mesh;
}
Vector3 middle_of(const geometry::Mesh& mesh, std::size_t face) {
  Vector3 point{};
  for (const auto corner : mesh.faces[face])
    point = geometry::add(point, geometry::scale(mesh.positions[static_cast<std::size_t>(corner)], 1.0 / 3));
  return point;
}
constexpr std::array<double, 3> in_the_middle{1.0 / 3, 1.0 / 3, 1.0 / 3};
}  // namespace

TEST_CASE("sky_transfer is the irradiance of each harmonic, integrated over the sphere", "[raster][light]") {
  const Vector3 normal = geometry::normalised({0.3, -0.5, 0.7});
  raster::Harmonics integral{};
  const std::size_t count = 200000;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 direction = raster::spiral_direction(i, count);
    const double cosine = std::max(0.0, geometry::dot(normal, direction));
    const auto harmonics = raster::spherical_harmonics(direction);
    for (std::size_t k = 0; k < 9; ++k)
      integral[k] +=
          harmonics[k] * cosine * 4 / static_cast<double>(count);  // 4π/count of the sphere, over π
  }
  const auto transfer = raster::sky_transfer(normal);
  for (std::size_t k = 0; k < 9; ++k) CHECK(transfer[k] == Approx(integral[k]).margin(1e-5));
}

TEST_CASE("a uniform sky lights a sphere and a plane evenly, half a sky by (1 + cos) / 2",
          "[raster][light]") {
  const auto sphere = geometry::icosphere(2);
  raster::OutdoorLight outdoor;
  outdoor.sun = 0;
  outdoor.sky = raster::uniform_sky(0.75);
  const auto even = raster::prepare(sphere, above, outdoor);
  outdoor.sky = {std::sqrt(std::numbers::pi), 0, std::sqrt(3 * std::numbers::pi) / 2, 0, 0, 0, 0, 0, 0};
  const auto half = raster::prepare(sphere, above, outdoor);  // ∫ Y over the upper half: radiance 1 there
  for (std::size_t face = 0; face < sphere.faces.size(); ++face) {
    CHECK(even.at(face, in_the_middle) == Approx(0.75).epsilon(1e-14));
    CHECK(half.at(face, in_the_middle) ==
          Approx((1 + half.normal(face, in_the_middle)[2]) / 2).margin(1e-14));
  }
}

TEST_CASE("a wall takes from the ground the sky that its form factor says", "[raster][light][repeated]") {
  const double reach = 2, height = 1;  // the wall over x = -2, |y| ≤ 2
  const auto ground = geometry::plane(16, 16, reach);
  const auto mesh = with_rectangle(ground, {-reach, -reach, 0}, {0, 2 * reach, 0}, {0, 0, height});
  const auto occlusion = raster::ambient_occlusion(mesh, 1024, 512);
  // dA to a perpendicular rectangle from its corner: (atan(b/x) - x/s · atan(b/s)) / 2π, s² = x² + height²
  const auto hidden = [&](double x, double b) {
    const double s = std::hypot(x, height);
    return (std::atan(b / x) - x / s * std::atan(b / s)) / (2 * std::numbers::pi);
  };
  double error = 0, far_error = 0;
  for (std::size_t face = 0; face < ground.faces.size(); ++face) {
    const Vector3 at = middle_of(mesh, face);
    const double expected = 1 - hidden(at[0] + reach, reach - at[1]) - hidden(at[0] + reach, reach + at[1]);
    error = std::max(error, std::abs(occlusion.at(face, 0, in_the_middle) - expected));
    if (at[0] + reach > 0.25)
      far_error = std::max(far_error, std::abs(occlusion.at(face, 0, in_the_middle) - expected));
    CHECK(occlusion.at(face, 1, in_the_middle) == 1);  // nothing is below
  }
  CHECK(error <= 0.03);
  CHECK(far_error <= 0.008);
}

TEST_CASE("nothing is hidden outside a sphere, and all of the sky inside", "[raster][light]") {
  const auto sphere = geometry::icosphere(3);
  const auto occlusion = raster::ambient_occlusion(sphere, 64, 128);
  double outside = 0, inside = 0;
  for (std::size_t face = 0; face < sphere.faces.size(); ++face) {
    outside = std::max(outside, 1 - occlusion.at(face, 0, in_the_middle));
    inside = std::max(inside, occlusion.at(face, 1, in_the_middle));
  }
  CHECK(outside <= 1e-6);
  CHECK(inside <= 0.04);  // through the rim's texels
}

TEST_CASE("the shadow of a plate lies where its projection lies", "[raster][light]") {
  const std::size_t cells = 96;
  const auto ground = geometry::plane(cells, cells, 3);
  const auto mesh = with_rectangle(ground, {-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0});
  raster::OutdoorLight outdoor;
  outdoor.direction = {1, 0, 1};  // so that the plate is shown one to the side
  outdoor.sky = {};
  outdoor.sun = 1;
  outdoor.shadow = std::make_shared<const raster::ParallelView>(mesh, outdoor.direction, 512);
  const auto prepared = raster::prepare(mesh, above, outdoor);
  double dark = 0;
  for (std::size_t face = 0; face < ground.faces.size(); ++face) {
    const Vector3 at = middle_of(mesh, face);
    const double share = prepared.at(face, in_the_middle) / std::sqrt(0.5);
    const double beside = std::max(std::abs(at[0] + 1), std::abs(at[1])) - 0.5;  // of the shadow's edge
    if (std::abs(beside) > 0.03) CHECK(share == Approx(beside < 0 ? 0 : 1).margin(1e-12));
    dark += (1 - share) * 36 / static_cast<double>(ground.faces.size());
  }
  CHECK(dark == Approx(1).margin(0.04));  // the edges' cells
}

TEST_CASE("neither a plane nor a sphere shadows itself, however low the sun", "[raster][light]") {
  for (const auto& mesh : {geometry::plane(20, 20), geometry::icosphere(4)})
    for (const double low : {0.5, 0.05, 0.002}) {
      const Vector3 towards = geometry::normalised({1, 0.3, low});
      const raster::ParallelView view(mesh, towards, 100);
      double hidden = 0;
      for (std::size_t face = 0; face < mesh.faces.size(); ++face)
        if (geometry::dot(raster::face_normal(mesh, mesh.faces[face]), towards) > 0)
          hidden = std::max(hidden, 1 - view.visible_share(face, middle_of(mesh, face)));
      CHECK(hidden == 0);
    }
}

TEST_CASE("odd meshes cast no shadow, and unsound lights are refused", "[raster][light][bad_input]") {
  CHECK_NOTHROW(raster::ParallelView({}, {0, 0, 1}, 8));
  auto mesh = roof();
  mesh.positions.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 9});
  mesh.faces.push_back({0, 1, 4});
  mesh.faces.push_back({0, 0, 0});
  const raster::ParallelView view(mesh, {0, 0, 2}, 64);
  for (std::size_t face = 0; face < 4; ++face) CHECK(view.visible_share(face, middle_of(mesh, 0)) == 1);
  CHECK(raster::ambient_occlusion(mesh, 16, 32).open.size() == 4);
  for (const double size : {1e-30, 1e30}) {  // the plate's shadow is the same at any size
    auto scaled = with_rectangle(geometry::plane(1, 1, 3), {-0.5, -0.5, 1}, {1, 0, 0}, {0, 1, 0});
    for (auto& position : scaled.positions) position = geometry::scale(position, size);
    const raster::ParallelView straight(scaled, {0, 0, 1}, 64);
    CHECK(straight.visible_share(0, {0, 0, 0}) == 0);
    CHECK(straight.visible_share(0, {2 * size, 2 * size, 0}) == 1);
  }
  CHECK_THROWS_AS(raster::ParallelView(mesh, {0, 0, 0}, 64), DomainError);
  CHECK_THROWS_AS(raster::ParallelView(mesh, {0, 0, 1}, 0), DomainError);
  CHECK_THROWS_AS(raster::ambient_occlusion(mesh, 0), DomainError);
  raster::OutdoorLight outdoor;
  outdoor.sky[3] = std::numeric_limits<double>::infinity();
  CHECK_THROWS_AS(raster::prepare(roof(), above, outdoor), DomainError);
  outdoor.sky[3] = 0;
  outdoor.occlusion = std::make_shared<const raster::AmbientOcclusion>();
  CHECK_THROWS_AS(raster::prepare(roof(), above, outdoor), DomainError);
  outdoor.occlusion = nullptr;
  outdoor.shadow = std::make_shared<const raster::ParallelView>(mesh, Vector3{0, 0, 1}, 8);
  CHECK_THROWS_AS(raster::prepare(roof(), above, outdoor), DomainError);
}
