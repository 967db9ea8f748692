#include <tapestry/geometry/shapes.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;
namespace {
raster::NeutralCoat coat(double exponent, double radiance) {
  return {exponent, raster::uniform_sky(radiance), 0};
}

const geometry::Camera camera = geometry::look_at({6, 3, 2}, {0, 0, 0.7}, {0, 0, 1}, 0.4, 0.4);
constexpr std::size_t side = 32;
}  // namespace

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

TEST_CASE("a coat mirrors by its share at every angle, and dims the paint by it",
          "[raster][photographed_light]") {
  raster::PaintedMesh ground{geometry::plane(1, 1, 10), {}, test::solid};
  ground.painted = test::every_face(ground.mesh);
  raster::PhotographedLight light;
  light.sun = 0;
  light.colour = {0.5, 1, 2};
  light.sky = raster::uniform_sky(0.5);
  const double exponent = GENERATE(0.5, 1.0, 5.0), angle = GENERATE(0.0, std::numbers::pi / 3);
  light.coat = coat(exponent, 3);
  const auto eye =
      geometry::look_at({5 * std::sin(angle), 0, 5 * std::cos(angle)}, {0, 0, 0}, {0, 1, 0}, 1e-3, 1e-3);
  const auto picture = raster::texture_operator<double>(ground, eye, 1, 1, light, 1);
  const double fresnel = 0.04 + 0.96 * std::pow(1 - std::cos(angle), exponent);
  REQUIRE(picture.weights.size() == 1);
  CHECK(std::abs(picture.weights[0] - (1 - fresnel) * 0.5) <= 1e-6);
  for (std::size_t c = 0; c < 3; ++c)
    CHECK(std::abs(picture.constant(0, 0, c) - fresnel * 3 * light.colour[c]) <= 1e-6 * 6);
}

TEST_CASE("a sun behind the eye glints by f0 / (4 alpha^2)", "[raster][photographed_light]") {
  raster::PaintedMesh ground{geometry::plane(1, 1, 10), {}, test::solid};
  ground.painted = test::every_face(ground.mesh);
  raster::PhotographedLight light;
  light.coat = raster::NeutralCoat{5, {}, 2, {}};
  const auto above = geometry::look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1e-3, 1e-3);
  const auto picture = raster::texture_operator<double>(ground, above, 1, 1, light, 1);
  CHECK(std::abs(picture.constant(0, 0, 1) - 2 * 0.04 / (4 * raster::glint_alpha * raster::glint_alpha)) <=
        1e-6);
}

TEST_CASE("bands of the surroundings show by the height of the mirrored direction",
          "[raster][photographed_light]") {
  CHECK(raster::height_bands(-1) == raster::HeightBands{0, 0, 0, 0});
  CHECK(raster::height_bands(0) == raster::HeightBands{0, 0, 0, 0});
  CHECK(raster::height_bands(0.125) == raster::HeightBands{0.5, 0, 0, 0});
  CHECK(raster::height_bands(0.5) == raster::HeightBands{0, 1, 0, 0});
  CHECK(raster::height_bands(0.8125) == raster::HeightBands{0, 0, 0.75, 0.25});
  CHECK(raster::height_bands(1) == raster::HeightBands{0, 0, 0, 1});
  raster::PaintedMesh ground{geometry::plane(1, 1, 10), {}, test::solid, image::ColourSpace::linear};
  ground.painted = test::every_face(ground.mesh);
  raster::PhotographedLight light;
  light.coat = coat(5, 1);
  light.coat->bands = {0, 0.5, 0.25, 2};
  const auto share_at = [&](const geometry::Vector3& eye) {  // of what an even coat of radiance 1 mirrors
    const auto from_eye = geometry::look_at(eye, {0, 0, 0}, {0, 1, 0}, 1e-3, 1e-3);
    const double lit = raster::texture_operator<double>(ground, from_eye, 1, 1, light, 1).constant(0, 0, 1);
    auto even = light;
    even.coat->bands = {};
    return lit / raster::texture_operator<double>(ground, from_eye, 1, 1, even, 1).constant(0, 0, 1);
  };
  CHECK(std::abs(share_at({0, 0, 5}) - 3) <= 1e-4);    // 1 + 2
  CHECK(std::abs(share_at({4, 0, 3}) - 1.4) <= 1e-3);  // height 0.6: 1 + 0.6 * 0.5 + 0.4 * 0.25
}

TEST_CASE("faces without paint show the photograph, drawn at once or by the operator",
          "[raster][photographed_light]") {
  const auto car = test::tiny_car();  // its floor is not painted
  auto from_below = geometry::look_at({3, 2, -4}, {0, 0, 0.7}, {0, 0, 1}, 0.5, 0.5);
  raster::PhotographedLight light;
  light.coat = coat(1, 0.6);
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
  light.coat = coat(2, 0.7);
  light.coat->surroundings[2] = 0.3;
  light.coat->glint = 1;
  const auto picture = raster::texture_operator<double>(car, camera, side, side, light);
  const auto texels = test::random_array<double>({picture.texel_count, 3}, 7);
  const auto weights = test::random_array<double>({side, side, 3}, 8, -1);
  const auto dark = raster::render(picture, tapestry::zeros<double, 2>({picture.texel_count, 3}));
  auto gradient = tapestry::zeros<double, 2>({picture.texel_count, 3});
  raster::render_adjoint(picture, weights, gradient);
  const double expected = test::dot(weights, raster::render(picture, texels)) - test::dot(weights, dark);
  CHECK(std::abs(test::dot(gradient, texels) - expected) <= 1e-10 * (1 + std::abs(expected)));
}

TEST_CASE("photographs of another size and points without an eye are refused",
          "[raster][photographed_light][bad_input]") {
  const auto car = test::tiny_car();
  raster::PhotographedLight light;
  light.photograph = std::make_shared<const Array<float, 3>>(Extents<3>{side, side, 3});
  CHECK_NOTHROW(raster::texture_operator<float>(car, camera, side, side, light));
  CHECK_THROWS_WITH(raster::texture_operator<float>(car, camera, 2 * side, side, light),
                    "light: photograph is [32, 32, 3], expected [64, 32, 3]");
  raster::LitPoint point;
  point.to_eye = {0, 0, 0};
  CHECK_THROWS_WITH(raster::estimated_light(car.mesh, {point}), "estimated_light: a point without an eye");
}
