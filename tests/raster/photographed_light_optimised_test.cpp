#include <tapestry/geometry/shapes.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;
using raster::EnvironmentMap;

namespace {

std::shared_ptr<const EnvironmentMap> even(const std::array<double, 3>& radiance) {
  return std::make_shared<const EnvironmentMap>(
      EnvironmentMap{4, 8, std::vector<std::array<double, 3>>(32, radiance)});
}

EnvironmentMap numbered() {
  EnvironmentMap map{6, 10, {}};
  for (std::size_t texel = 0; texel < 60; ++texel)
    map.texels.push_back({static_cast<double>(texel), 0, static_cast<double>(texel % 10)});
  return map;
}

const geometry::Camera camera = geometry::look_at({6, 3, 2}, {0, 0, 0.7}, {0, 0, 1}, 0.4, 0.4);
constexpr std::size_t side = 32;

}  // namespace

TEST_CASE("an environment map has its texels at their directions", "[raster][photographed_light]") {
  const auto map = numbered();
  for (std::size_t texel = 0; texel < map.texels.size(); ++texel)
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(std::abs(map.at(map.direction(texel))[c] - map.texels[texel][c]) <= 1e-12 * 60);
}

TEST_CASE("lookups of an environment map close around z and stay in it at the poles",
          "[raster][photographed_light]") {
  const auto map = numbered();
  const auto directions = test::random_array<double>({200, 3}, 3, -1);
  for (std::size_t i = 0; i < 200; ++i) {
    const auto direction =
        geometry::normalised(geometry::Vector3{directions(i, 0), directions(i, 1), directions(i, 2)});
    double sum = 0;
    for (const auto& [texel, weight] : map.taps(direction)) {
      CHECK(texel < 60);
      CHECK(weight >= 0);
      sum += weight;
    }
    CHECK(std::abs(sum - 1) <= 1e-15 * 4);
  }
  const double step = 1e-9;  // across y = 0 at +x, between the last and the first column
  CHECK(std::abs(map.at({std::sqrt(1 - step * step), step, 0})[2] -
                 map.at({std::sqrt(1 - step * step), -step, 0})[2]) <= 1e-6);
  CHECK(std::abs(map.at({1, 0, 0})[2] - 4.5) <= 1e-12);
  CHECK(std::isfinite(map.at({0, 0, 1})[0]));
  CHECK(std::isfinite(map.at({0, 0, -1})[0]));
}

TEST_CASE("a photographed light without a coat has the bits of its sun and sky",
          "[raster][photographed_light]") {
  const auto car = test::tiny_car();
  raster::PhotographedLight light;
  light.direction = {1, 1, 2};
  const auto matt = raster::texture_operator<float>(car, camera, side, side,
                                                    static_cast<const raster::OutdoorLight&>(light));
  const auto same = raster::texture_operator<float>(car, camera, side, side, light);
  CHECK(matt.weights == same.weights);
  CHECK((matt.constant == same.constant));
}

TEST_CASE("even surroundings are seen by Fresnel's share, and dim the paint by it",
          "[raster][photographed_light]") {
  raster::PaintedMesh ground{geometry::plane(1, 1, 10), {}, test::solid};
  ground.painted = test::every_face(ground.mesh);
  raster::PhotographedLight light;
  light.sun = 0;
  light.sky = raster::uniform_sky(0.5);
  light.surroundings = even({1, 2, 3});
  const auto above = geometry::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 0.01, 0.01);  // normal incidence
  const auto picture = raster::texture_operator<double>(ground, above, 1, 1, light, 1);
  const double fresnel = 0.04;
  REQUIRE(picture.weights.size() == 1);
  CHECK(std::abs(picture.weights[0] - (1 - fresnel) * 0.5) <= 1e-6);
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(std::abs(picture.constant(0, 0, c) - fresnel * static_cast<double>(c + 1)) <= 1e-6);
}

TEST_CASE("faces without paint show the photograph, drawn at once or by the operator",
          "[raster][photographed_light]") {
  const auto car = test::tiny_car();  // its floor is not painted
  auto from_below = geometry::look_at({3, 2, -4}, {0, 0, 0.7}, {0, 0, 1}, 0.5, 0.5);
  raster::PhotographedLight light;
  light.surroundings = even({0.5, 0.6, 0.7});
  const auto numbers = test::random_array<float>({side, side, 3}, 5);
  auto photograph = std::make_shared<Array<float, 3>>(Extents<3>{side, side, 3});
  std::copy(numbers.begin(), numbers.end(), photograph->begin());
  light.photograph = photograph;
  const auto texels = test::random_array<double>({car.layout.texel_count(car.mesh), 3}, 6);
  const auto picture = raster::texture_operator<double>(car, from_below, side, side, light);
  const auto render = raster::render(picture, texels);
  const auto at_once = raster::render_textured(car, from_below, side, side, light, texels);
  std::size_t shown = 0;
  for (std::size_t pixel = 0; pixel < side * side; ++pixel) {
    const bool is_floor = picture.coverage.data()[pixel] == 1 &&
                          !std::binary_search(picture.pixels.begin(), picture.pixels.end(), pixel);
    for (std::size_t c = 0; c < 3; ++c) {
      CHECK(std::abs(render.data()[3 * pixel + c] - at_once.colour.data()[3 * pixel + c]) <= 1e-12);
      if (is_floor)
        CHECK(std::abs(render.data()[3 * pixel + c] -
                       static_cast<double>(photograph->data()[3 * pixel + c])) <= 1e-12);
    }
    shown += is_floor ? 1U : 0U;
  }
  CHECK(shown > 20);
}

TEST_CASE("the picture under a photographed light is affine in its texels",
          "[raster][photographed_light][gradient]") {
  const auto car = test::tiny_car();
  raster::PhotographedLight light;
  light.surroundings = std::make_shared<const EnvironmentMap>(numbered());
  const auto picture = raster::texture_operator<double>(car, camera, side, side, light);
  const auto texels = test::random_array<double>({picture.texel_count, 3}, 7);
  const auto weights = test::random_array<double>({side, side, 3}, 8, -1);
  const auto dark = raster::render(picture, tapestry::zeros<double, 2>({picture.texel_count, 3}));
  auto gradient = tapestry::zeros<double, 2>({picture.texel_count, 3});
  raster::render_adjoint(picture, weights, gradient);
  const double expected = test::dot(weights, raster::render(picture, texels)) - test::dot(weights, dark);
  CHECK(std::abs(test::dot(gradient, texels) - expected) <= 1e-10 * (1 + std::abs(expected)));
}

TEST_CASE("surroundings without texels and points without an eye are refused",
          "[raster][photographed_light][bad_input]") {
  const auto car = test::tiny_car();
  raster::PhotographedLight light;
  light.surroundings = std::make_shared<const EnvironmentMap>();
  CHECK_THROWS_WITH(raster::prepare(car.mesh, camera, light),
                    "photographed light: the surroundings have no texels");
  light.surroundings = std::make_shared<const EnvironmentMap>(EnvironmentMap{4, 8, {{1, 1, 1}}});
  CHECK_THROWS_AS(raster::prepare(car.mesh, camera, light), ShapeError);
  light.surroundings = nullptr;
  light.photograph = std::make_shared<const Array<float, 3>>(Extents<3>{side, side, 3});
  CHECK_NOTHROW(raster::texture_operator<float>(car, camera, side, side, light));
  CHECK_THROWS_WITH(raster::texture_operator<float>(car, camera, 2 * side, side, light),
                    "light: photograph is [32, 32, 3], expected [64, 32, 3]");
  raster::LitPoint point;
  CHECK_THROWS_WITH(raster::coated_light(car.mesh, {point}, {}), "coated_light: a point without an eye");
}
