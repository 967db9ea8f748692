#include <tapestry/raster/detail/light_adjoint.hpp>

#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera;

namespace {
raster::PaintedMesh some_body(const raster::TextureLayout& layout, std::size_t count = 30) {
  raster::PaintedMesh body{test::random_triangles(count, 7, 0.9), {}, layout};
  body.painted = test::every_face(body.mesh);
  for (std::size_t face = 0; face < body.painted.size(); face += 4) body.painted[face] = 0;
  return body;
}

/// ∂⟨weights, picture⟩/∂light beside central differences, along random directions.
template <class Model>
void check(const raster::PaintedMesh& body, const Array<double, 1>& light, const Model& model = {}) {
  const auto texels = random_array<double>({raster::stored_texel_count(body.layout, body.mesh), 3}, 2);
  const auto weights = random_array<double>({20, 25, 3}, 3, -1);
  const auto loss = [&](const Array<double, 1>& at) {
    const auto picture =
        raster::render_textured(body, Camera{}, 20, 25, raster::with_parameters(model, at), texels);
    return test::dot(weights, picture.colour);
  };
  auto gradient = tapestry::zeros<double, 1>(light.shape());
  for (int half = 0; half < 2; ++half)  // the adjoint adds
    raster::light_adjoint(body, Camera{}, raster::with_parameters(model, light), texels,
                          Array<double, 3>(weights / 2), gradient);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const auto direction = test::random_direction<double>({light.size()}, seed);
    const double expected = test::central_difference(loss, light, direction);
    CHECK(std::abs(test::dot(gradient, direction) - expected) <= 1e-6 * (1 + std::abs(expected)));
  }
}
}  // namespace

TEST_CASE("light_adjoint agrees with central differences for every texture, flat and smooth",
          "[raster][light][gradient]") {
  const auto light = raster::light_parameters<double>(warm);
  for (const auto& layout :
       {test::atlas, test::trilinear, test::anisotropic, test::cube, test::vertex, test::solid}) {
    check<raster::Light>(some_body(layout), light);
    check<raster::SmoothLight>(some_body(layout), light);
  }
  auto without_direction = light;
  without_direction(1) = 0;  // where the direction does not matter, but its strength does
  check<raster::Light>(some_body(test::solid), without_direction);
}

TEST_CASE("light_adjoint of sun and sky agrees with central differences, in shadow and under occlusion",
          "[raster][light][gradient]") {
  raster::OutdoorLight light{0.7, {0.2, -0.4, -1}, {1, 0.8, 0.6}, raster::uniform_sky(0.4), {}, {}};
  for (std::size_t i = 1; i < 9; ++i) light.sky[i] = 0.05 * static_cast<double>(i);
  for (const auto& layout : {test::atlas, test::anisotropic, test::cube})
    check(some_body(layout), raster::light_parameters<double>(light), light);
  const auto body = some_body(test::vertex);
  light.occlusion =
      std::make_shared<const raster::AmbientOcclusion>(raster::ambient_occlusion(body.mesh, 16, 64));
  light.shadow = std::make_shared<const raster::ParallelView>(body.mesh, light.direction, 64);
  check(body, raster::light_parameters<double>(light), light);
}

TEST_CASE("light_adjoint of a clear coat agrees with central differences, in shadow and under occlusion",
          "[raster][light][gradient]") {
  const auto parameters = [](const auto& light) { return raster::light_parameters<double>(light); };
  const raster::ClearCoat<raster::Light> flat{warm, 0.8, 0.6};
  const raster::ClearCoat<raster::SmoothLight> smooth{{warm}, 0.8, 0.6};
  for (const auto& layout : {test::atlas, test::anisotropic, test::cube}) {
    check(some_body(layout), parameters(flat), flat);
    check(some_body(layout), parameters(smooth), smooth);
  }
  const auto body = some_body(test::vertex);
  raster::ClearCoat<raster::OutdoorLight> outdoor;
  outdoor.coat = 0.8;
  outdoor.roughness = 0.6;
  outdoor.direction = {0.2, -0.4, -1};
  for (std::size_t i = 1; i < 9; ++i) outdoor.sky[i] = 0.05 * static_cast<double>(i);
  check(body, parameters(outdoor), outdoor);
  outdoor.occlusion =
      std::make_shared<const raster::AmbientOcclusion>(raster::ambient_occlusion(body.mesh, 16, 64));
  outdoor.shadow = std::make_shared<const raster::ParallelView>(body.mesh, outdoor.direction, 64);
  check(body, parameters(outdoor), outdoor);
}

TEST_CASE("the texture operator stays the adjoint of its picture under sun, sky, shadow and occlusion",
          "[raster][light]") {
  const auto body = some_body(test::atlas);
  raster::OutdoorLight light;
  light.direction = {0.2, -0.4, -1};
  light.occlusion =
      std::make_shared<const raster::AmbientOcclusion>(raster::ambient_occlusion(body.mesh, 16, 64));
  light.shadow = std::make_shared<const raster::ParallelView>(body.mesh, light.direction, 64);
  const auto picture = raster::texture_operator<double>(body, Camera{}, 20, 25, light);
  const auto x = random_array<double>({128, 3}, 4);
  const auto y = random_array<double>({20, 25, 3}, 5);
  auto back = tapestry::zeros<double, 2>({128, 3});
  raster::render_adjoint(picture, y, back);
  const Array<double, 3> ahead = raster::render(picture, x) - picture.constant;
  CHECK(test::dot(back, x) == Approx(test::dot(ahead, y)).epsilon(1e-12));
}

TEST_CASE("the light of a wall that faces it, worked out by hand", "[raster][light]") {
  // A white wall over a picture of one pixel, its normal towards the camera, lit from there at 60°.
  raster::PaintedMesh wall{test::triangle_soup({{{{-9, -9, 2}, {9, -9, 2}, {0, 30, 2}}}}), {1}, test::solid};
  const double half = 0.5, root = std::sqrt(0.75);
  const raster::Light light{0.25, 0.5, {2 * root, 0, -2 * half}, {1, 0.5, 0.25}};
  auto gradient = tapestry::zeros<double, 1>({8});
  raster::light_adjoint(wall, Camera{}, light, tapestry::filled<double, 2>({1, 3}, 1),
                        tapestry::filled<double, 3>({1, 1, 3}, 1), gradient);
  CHECK(gradient(0) == Approx(1.75));                           // Σ light colour
  CHECK(gradient(1) == Approx(1.75 * half));                    // times n·L
  CHECK(gradient(2) == Approx(-1.75 * 0.5 * half * root / 2));  // n = (0, 0, −1), across L, over |direction|
  CHECK(gradient(4) == Approx(-1.75 * 0.5 * (1 - half * half) / 2));
  for (std::size_t c = 5; c < 8; ++c) CHECK(gradient(c) == Approx(0.25 + 0.5 * half));
}

TEST_CASE("light_adjoint has the same bits for any number of threads", "[raster][light]") {
  const auto body = some_body(test::atlas, 200);
  const auto texels = random_array<float>({128, 3}, 2);
  same_by_threads({1, 2, 3}, [&] {
    auto gradient = tapestry::zeros<float, 1>({8});
    raster::light_adjoint(body, Camera{}, raster::SmoothLight{warm}, texels,
                          random_array<float>({200, 150, 3}, 3), gradient);
    return gradient;
  });
}

TEST_CASE("a light of other than eight numbers is refused", "[raster][light][bad_input]") {
  CHECK_THROWS_WITH(raster::light_of(tapestry::zeros<double, 1>({7})),
                    "light_of: parameters is [7], expected [8]");
  CHECK(raster::light_of(raster::light_parameters<double>(warm)).direction == warm.direction);
  CHECK(raster::light_of(raster::light_parameters<double>(warm)).colour == warm.colour);
  auto gradient = tapestry::zeros<double, 1>({3});
  CHECK_THROWS_AS(
      raster::light_adjoint(some_body(test::solid), Camera{}, warm, tapestry::zeros<double, 2>({1, 3}),
                            tapestry::zeros<double, 3>({4, 4, 3}), gradient),
      ShapeError);
}
