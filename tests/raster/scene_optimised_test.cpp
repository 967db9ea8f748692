#include <tapestry/raster/scene.hpp>

#include <iostream>
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/geometry_picture.hpp>

#include "../support/brute_force_render.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/paths.hpp"
#include "../support/random_array.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;
using geometry::Vector3, raster::PlacedBody;

namespace {
PlacedBody bundled(const std::string& name, const geometry::Pose& pose) {
  PlacedBody placed{{io::read_obj(test::in_sources("examples/assets/" + name)).mesh, {}, test::solid}, pose};
  placed.body.painted.assign(placed.body.mesh.faces.size(), 0);
  return placed;
}

/// A sedan, and a van that stands across its front.
raster::Scene two_cars() {
  return raster::scene_of(
      {bundled("car_sedan.obj", {}), bundled("van.obj", {{0, 0, 0.5 * std::numbers::pi}, {4.5, 0.6, 0}})});
}
}  // namespace

TEST_CASE("two cars that hide each other look as a brute-force renderer draws them", "[raster][scene]") {
  const auto scene = two_cars();
  const std::size_t size = 160;
  std::size_t silhouettes_off = 0, depths_off = 0, both_seen = 0, count = 0;
  for (int view = 0; view < 8; ++view) {
    const double azimuth = view * std::numbers::pi / 4 + 0.3;
    const auto camera = geometry::look_at({14 * std::cos(azimuth), 14 * std::sin(azimuth), 3.0}, {2, 0, 0.7},
                                          {0, 0, 1}, 0.35, 0.35);
    const auto positions = raster::positions_in_view(scene.whole.mesh, camera);
    const auto truth = test::brute_force_render(
        scene.whole.mesh, camera, size, size, 1, [&](std::size_t face, const std::array<double, 3>& b) {
          double depth = 0;
          for (std::size_t k = 0; k < 3; ++k)
            depth += b[k] * positions[static_cast<std::size_t>(scene.whole.mesh.faces[face][k])][2];
          return std::array<double, 3>{face < scene.first_face[1] ? 1.0 : 2.0, depth, 0};
        });
    const auto seen = raster::visibility(scene.whole.mesh, camera, size, size, 1);
    const auto depth =
        raster::geometry_picture<raster::Depth, double>(scene.whole.mesh, camera, size, size, 1);
    std::array<bool, 3> shown{};
    for (std::size_t i = 0; i < seen.face.size(); ++i, ++count) {
      const std::size_t body =
          seen.face[i] < 0 ? 0 : scene.body_of(static_cast<std::size_t>(seen.face[i])) + 1;
      shown[body] = true;
      silhouettes_off += truth.data()[3 * i] == static_cast<double>(body) ? 0U : 1U;
      depths_off += std::abs(truth.data()[3 * i + 1] - depth.data()[i]) <= 1e-3 ? 0U : 1U;
    }
    both_seen += shown[1] && shown[2] ? 1U : 0U;
  }
  std::cout << "two cars, pixels of another car than by brute force " << silhouettes_off
            << ", at another depth " << depths_off << ", of " << count << "\n";
  CHECK(both_seen == 8);
  CHECK(static_cast<double>(silhouettes_off) <= 3e-4 * static_cast<double>(count));
  CHECK(static_cast<double>(depths_off) <= 3e-4 * static_cast<double>(count));
}

TEST_CASE("a scene of one body at no pose has the body's bits", "[raster][scene]") {
  const auto car = test::tiny_car();
  const auto scene = raster::scene_of({{car}});
  CHECK(scene.whole.mesh.positions == car.mesh.positions);
  CHECK(scene.whole.painted == car.painted);
  const auto camera = geometry::look_at({6, 3, 2}, {0, 0, 0.7}, {0, 0, 1}, 0.4, 0.4);
  const auto alone = raster::texture_operator<float>(car, camera, 48, 48, raster::Light{});
  const auto placed = raster::texture_operator<float>(scene.whole, camera, 48, 48, raster::Light{});
  CHECK(alone.pixels == placed.pixels);
  CHECK(alone.texels_of == placed.texels_of);
  CHECK(alone.weights == placed.weights);
  CHECK((alone.constant == placed.constant));
  CHECK((alone.coverage == placed.coverage));
}

TEST_CASE("painted bodies share an atlas; another body keeps its own colours", "[raster][scene]") {
  const auto car = test::tiny_car();
  auto plain = car;
  plain.painted.assign(car.painted.size(), 0);
  const auto camera = geometry::look_at({0, 0, 30}, {0, 0, 0}, {0, 1, 0}, 0.4, 0.4);
  const Vector3 left{-4, 0, 0}, right{4, 0, 0};
  const auto scene = raster::scene_of({{car, {{}, left}}, {car, {{}, right}}, {plain, {{}, {0, 5, 0}}}});
  const auto picture = raster::texture_operator<float>(scene.whole, camera, 64, 64, raster::Unlit{}, 1);
  const auto texels = test::random_array<float>({car.layout.texel_count(car.mesh), 3}, 7);
  const auto render = raster::render(picture, texels);
  const auto seen = raster::visibility(scene.whole.mesh, camera, 64, 64, 1);
  std::array<std::array<double, 3>, 3> sums{};
  for (std::size_t i = 0; i < seen.face.size(); ++i) {
    if (seen.face[i] < 0) continue;
    const std::size_t body = scene.body_of(static_cast<std::size_t>(seen.face[i]));
    for (std::size_t c = 0; c < 3; ++c) {
      sums[body][c] += static_cast<double>(render.data()[3 * i + c]);
      if (body == 2) {
        const bool is_floor =
            geometry::material_colour(scene.whole.mesh, static_cast<std::size_t>(seen.face[i])) ==
            std::array<float, 3>{0.1F, 0.1F, 0.1F};
        CHECK(render.data()[3 * i + c] == (is_floor ? 0.1F : std::array{0.3F, 0.5F, 0.7F}[c]));
      }
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    CHECK(sums[0][c] > 1);
    CHECK(std::abs(sums[0][c] - sums[1][c]) <=
          0.05 * sums[0][c]);  // the same texels, mirrored in perspective
  }
}

TEST_CASE("a car shades the ground and its neighbour", "[raster][scene][light]") {
  auto car = test::tiny_car();
  car.painted.assign(car.painted.size(), 0);
  raster::PaintedMesh ground{geometry::plane(24, 24, 12), {}, car.layout};
  ground.painted.assign(ground.mesh.faces.size(), 0);
  const auto scene = raster::scene_of({{ground}, {car}});
  const auto sun = geometry::normalised(Vector3{1, 0, 1});
  const raster::ParallelView view(scene.whole.mesh, sun, 1024);
  const auto share = [&](double x, double y) {  // of the ground
    for (std::size_t face = 0; face < scene.first_face[1]; ++face) {
      std::array<Vector3, 3> corner;
      for (std::size_t k = 0; k < 3; ++k)
        corner[k] = scene.whole.mesh.positions[static_cast<std::size_t>(scene.whole.mesh.faces[face][k])];
      const auto side = [&](std::size_t k) {
        const auto edge = geometry::subtract(corner[(k + 1) % 3], corner[k]);
        return edge[0] * (y - corner[k][1]) - edge[1] * (x - corner[k][0]);
      };
      if (std::min({side(0), side(1), side(2)}) >= 0) return view.visible_share(face, {x, y, 0});
    }
    return -1.0;
  };
  CHECK(share(0, 0) == 0);     // below the car
  CHECK(share(-3.2, 0) == 0);  // the roof, 1.4 high, ends at x = −2: its shadow reaches −3.4
  CHECK(share(-3.6, 0) == 1);
  CHECK(share(2.2, 0) == 1);     // towards the sun
  CHECK(share(-3.2, 1.2) == 1);  // beside the car, which is 0.9 wide to each side
  const auto open = raster::ambient_occlusion(scene.whole.mesh, 256, 256);
  const auto alone = raster::ambient_occlusion(ground.mesh, 256, 256);
  const auto least = [&](const raster::AmbientOcclusion& occlusion) {
    double darkest = 1;
    for (std::size_t face = 0; face < scene.first_face[1]; ++face)
      darkest = std::min(darkest, occlusion.at(face, 0, {1.0 / 3, 1.0 / 3, 1.0 / 3}));
    return darkest;
  };
  CHECK(least(alone) > 0.99);
  CHECK(least(open) < 0.2);  // contact shadow
}

TEST_CASE("ground keeps its light but where a car hides the sun or the sky", "[raster][scene][light][long]") {
  const auto car = test::tiny_car();  // x to ±2, y to ±0.9, z from 0.1 to 1.4
  const raster::GroundShade shade(car.mesh);
  const auto above = geometry::look_at({0, 0, 20}, {0, 0, 0}, {0, 1, 0}, 0.6, 0.6);
  const std::size_t size = 200;
  const auto at = [&](const Array<float, 2>& kept, double x, double y) {
    const auto view = geometry::view_from_world(above, {x, y, 0});
    const auto pixel = [&](double tangent, double half) {
      return static_cast<std::size_t>((tangent / half + 1) / 2 * static_cast<double>(size));
    };
    return static_cast<double>(
        kept(pixel(view[1] / view[2], above.tan_half_fov_y), pixel(view[0] / view[2], above.tan_half_fov_x)));
  };
  raster::OutdoorLight light;
  light.sun = 0;
  light.sky = raster::uniform_sky(1);
  const auto sky = shade(light, above, size, size);
  CHECK(at(sky, 0, 0) < 0.2);  // below the car
  CHECK(at(sky, 5.5, 5.5) > 0.97);
  // A wall of height h, seen at its foot, hides half of the sky; at distance d from a long one,
  // 1 − A = ½ (1 − cos atan(h / d)), a cosine-weighted dihedral. The car's flank is 4.4 times as long as d.
  const double d = 0.9, expected = 1 - 0.5 * (1 - std::cos(std::atan(1.4 / d)));
  CHECK(std::abs(at(sky, 0, 0.9 + d) - expected) <= 0.05);

  light.sun = 3;
  light.sky = raster::uniform_sky(0.5);
  light.direction = {1, 0, 1};
  const auto sunny = shade(light, above, size, size);
  const double lit = 3 * std::sqrt(0.5) + 0.5;
  CHECK(at(sunny, -3.0, 0) <= 0.5 / lit + 0.01);  // the sun's shadow: at most the sky is left
  CHECK(at(sunny, -3.0, 0) >= 0.25 / lit);
  CHECK(at(sunny, 4.5, 0) > 0.98);
  const auto from_below = geometry::look_at({0, 0, -20}, {0, 0, 0}, {0, 1, 0}, 0.6, 0.6);
  for (const float kept : shade(light, from_below, 16, 16)) CHECK(kept == 1);
  light.sun = 0;
  light.sky = {};
  for (const float kept : shade(light, above, 16, 16)) CHECK(kept == 1);  // no light to lose
  CHECK_THROWS_AS(raster::GroundShade(geometry::Mesh{}), DomainError);
  CHECK_THROWS_AS(raster::GroundShade(car.mesh, {0, 3, 1}), DomainError);
}

TEST_CASE("a pose's gradient through a neighbour agrees with central differences",
          "[raster][scene][gradient]") {
  auto car = test::tiny_car();
  car.painted.assign(car.painted.size(), 0);
  const auto camera = geometry::look_at({0.1, 0.2, 9}, {0, 0, 0}, {0, 1, 0}, 0.3, 0.3);
  const geometry::Pose pose{{0.1, -0.2, 0.3}, {0.1, 0.05, 1.5}};
  const std::size_t size = 16;
  const auto depth = [&](const geometry::Pose& at) {  // of the upper car's roof, off its edges
    const auto scene = raster::scene_of({{car}, {car, at}});
    const auto picture =
        raster::geometry_picture<raster::Depth, double>(scene.whole.mesh, camera, size, size, 4);
    double sum = 0;
    for (std::size_t y = 7; y < 9; ++y)
      for (std::size_t x = 7; x < 9; ++x) sum += picture(y, x);
    return sum;
  };
  const auto scene = raster::scene_of({{car}, {car, pose}});
  auto adjoint = tapestry::zeros<double, 2>({size, size});
  for (std::size_t y = 7; y < 9; ++y)
    for (std::size_t x = 7; x < 9; ++x) adjoint(y, x) = 1;
  std::vector<Vector3> positions_adjoint(scene.whole.mesh.positions.size(), Vector3{0, 0, 0});
  raster::geometry_picture_adjoint<raster::Depth>(scene.whole.mesh, camera, adjoint, positions_adjoint, 4);
  const auto own = scene.positions_of(1, positions_adjoint);
  geometry::Pose gradient;
  geometry::placed_adjoint(pose, car.mesh.positions, {own.begin(), own.end()}, gradient);
  const double step = test::central_difference_step<double>();
  auto at = pose;
  for (std::size_t k = 0; k < 6; ++k) {
    const double expected =
        test::slope_by(k < 3 ? at.rotation[k] : at.translation[k - 3], step, [&] { return depth(at); });
    CHECK(std::abs((k < 3 ? gradient.rotation[k] : gradient.translation[k - 3]) - expected) <= 1e-6);
  }
  CHECK(std::abs(gradient.translation[2]) > 1);
}

TEST_CASE("a scene without bodies or with textures that do not fit each other is refused",
          "[raster][scene][bad_input]") {
  const auto car = test::tiny_car();
  CHECK_THROWS_AS(raster::scene_of({}), DomainError);
  auto other = car;
  other.space = image::ColourSpace::linear;
  CHECK_THROWS_WITH(raster::scene_of({{car}, {other}}), "scene_of: bodies in different colour spaces");
  other = test::tiny_car(16);
  CHECK_THROWS_WITH(raster::scene_of({{car}, {other}}),
                    "scene_of: painted bodies with textures of different layouts");
  other.painted.assign(other.painted.size(), 0);
  CHECK_NOTHROW(raster::scene_of({{car}, {other}}));
  CHECK(raster::scene_of({{other}, {car}}).whole.layout.height == car.layout.height);
  other.painted.push_back(0);
  CHECK_THROWS_AS(raster::scene_of({{car}, {other}}), ShapeError);
}
