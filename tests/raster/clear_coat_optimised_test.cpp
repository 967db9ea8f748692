#include <tapestry/raster/clear_coat.hpp>

#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;
using geometry::Camera, geometry::Vector3;

namespace {
constexpr double pi = std::numbers::pi;
const Vector3 up{0, 0, 1};

Vector3 at_angle(double polar, double turn) {
  return {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
}

double reflection(const Vector3& to_eye, const Vector3& towards, double alpha, double f0) {
  return raster::ggx_reflection(up, to_eye, towards, to_eye[2], alpha, f0).value;
}

/// ∫ f over 0 to a quarter turn.
template <class Function>
double integral(Function f) {
  const int count = 100000;
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += f((i + 0.5) * pi / 2 / count);
  return sum * pi / 2 / count;
}

/// Share of the light from straight above that a mirror of f0 = 1 sends back anywhere.
double energy_at_normal_incidence(double alpha) {
  return integral([&](double polar) {
    return 2 * std::sin(polar) * reflection(up, at_angle(polar, 0.3), alpha, 1);  // π·f·cos, over the sphere
  });
}

raster::PaintedMesh some_body(const raster::TextureLayout& layout) {
  raster::PaintedMesh body{test::random_triangles(30, 7, 0.9), {}, layout};
  body.painted = test::every_face(body.mesh);
  for (std::size_t face = 0; face < body.painted.size(); face += 4) body.painted[face] = 0;
  return body;
}
}  // namespace

TEST_CASE("the facets of a GGX surface project to its area", "[raster][clear_coat]") {
  for (const double alpha : {0.02, 0.3, 1.0}) {
    const double area = integral([&](double polar) {
      const double sine = std::sin(polar), cosine = std::cos(polar);
      return 2 * pi * sine * cosine * raster::ggx_density(alpha, cosine, sine * sine);
    });
    CHECK(area == Approx(1).epsilon(1e-6));
  }
}

TEST_CASE("a GGX mirror sends back what falls on it at normal incidence, less what rough facets hide",
          "[raster][clear_coat]") {
  CHECK(energy_at_normal_incidence(0.02) == Approx(1).epsilon(1e-3));
  CHECK(energy_at_normal_incidence(1) == Approx(1 - std::log(2)).epsilon(1e-6));  // ∫ u/(1 + u) over 0 to 1
  double before = 1;
  for (const double alpha : {0.1, 0.2, 0.4, 0.8}) {
    const double energy = energy_at_normal_incidence(alpha);
    CHECK(energy < before);
    before = energy;
  }
}

TEST_CASE("GGX reflection is the same with light and eye exchanged", "[raster][clear_coat]") {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const Vector3 a = at_angle(random.uniform(0, 1.5), random.uniform(-3, 3));
    const Vector3 b = at_angle(random.uniform(0, 1.5), random.uniform(-3, 3));
    const double alpha = random.uniform(0.01, 1);
    CHECK(reflection(a, b, alpha, 0.04) / b[2] ==
          Approx(reflection(b, a, alpha, 0.04) / a[2]).epsilon(1e-12));
  }
}

TEST_CASE("where the sun is mirrored a coat shows the middle of its lobe", "[raster][clear_coat]") {
  for (const double alpha : {1e-4, 0.01, 0.25, 1.0}) {
    for (const double polar : {0.0, 0.5, 1.3}) {
      const double c = std::cos(polar), a = alpha * alpha;
      const double expected =
          raster::schlick_fresnel(0.04, c) / (4 * a * std::sqrt(c * c * (1 - a) + a));  // D = 1/(π·α²)
      CHECK(reflection(at_angle(polar, 1), at_angle(polar, 1 + pi), alpha, 0.04) ==
            Approx(expected).epsilon(1e-6));
    }
  }
  CHECK(raster::schlick_fresnel(0.04, 1) == 0.04);
  CHECK(raster::schlick_fresnel(0.04, 0) == 1);
}

TEST_CASE("GGX reflection has the derivatives of central differences", "[raster][clear_coat][gradient]") {
  Random random(5);
  const double step = test::central_difference_step<double>();
  for (int i = 0; i < 100; ++i) {
    const Vector3 eye = at_angle(random.uniform(0, 1.4), random.uniform(-3, 3));
    const Vector3 light = at_angle(random.uniform(0, 1.4), random.uniform(-3, 3));
    const double alpha = random.uniform(0.1, 1);
    const auto found = raster::ggx_reflection(up, eye, light, eye[2], alpha, 0.04);
    const double by_alpha =
        (reflection(eye, light, alpha + step, 0.04) - reflection(eye, light, alpha - step, 0.04)) /
        (2 * step);
    CHECK(std::abs(found.by_alpha - by_alpha) <= 1e-6 * (1 + std::abs(by_alpha)));
    Vector3 way = geometry::cross(light, at_angle(random.uniform(0, 3), random.uniform(-3, 3)));
    way = geometry::normalised(way);  // along the sphere
    const auto turned = [&](double by) {
      return reflection(eye, geometry::normalised(geometry::add(light, geometry::scale(way, by))), alpha,
                        0.04);
    };
    const double by_way = (turned(step) - turned(-step)) / (2 * step);
    CHECK(std::abs(geometry::dot(found.by_towards, way) - by_way) <= 1e-6 * (1 + std::abs(by_way)));
  }
}

TEST_CASE("under even light white paint stays white below a clear coat", "[raster][clear_coat]") {
  const auto ball = geometry::icosphere(2);
  const auto camera = geometry::look_at({-3, 1, 2}, {0, 0, 0}, {0, 0, 1}, 1);
  raster::ClearCoat<raster::SmoothLight> lamp{{{0.75, 0, {0, 0, 1}, {1, 1, 1}}}, 0.8, 0.3};
  raster::ClearCoat<raster::OutdoorLight> sky{
      {0, {0, 0, 1}, {1, 1, 1}, raster::uniform_sky(0.75), {}, {}}, 1, 0.5};
  const auto under_lamp = prepare(ball, camera, lamp);
  const auto under_sky = prepare(ball, camera, sky);
  const std::array<double, 3> b{0.2, 0.3, 0.5};
  for (std::size_t face = 0; face < ball.faces.size(); ++face) {
    CHECK(under_lamp.at(face, b) + under_lamp.reflected(face, b)[1] == Approx(0.75).epsilon(1e-13));
    CHECK(under_sky.at(face, b) + under_sky.reflected(face, b)[1] == Approx(0.75).epsilon(1e-13));
  }
}

TEST_CASE("a clear coat mirrors the sky where it is, less sharply when rough", "[raster][clear_coat]") {
  // A floor seen at 45 degrees mirrors the sky at 45 degrees beyond it: radiance 1 + x there.
  const auto floor = test::triangle_soup({{Vector3{-9, -9, 0}, Vector3{9, -9, 0}, Vector3{0, 9, 0}}});
  const auto camera = geometry::look_at({-2, 0, 2}, {0, 0, 0}, {0, 0, 1}, 1);
  raster::ClearCoat<raster::OutdoorLight> light;
  light.sun = 0;
  light.sky = raster::uniform_sky(1);
  light.sky[3] = 1 / std::sqrt(3 / (4 * pi));
  const std::array<double, 3> middle{0.25, 0.25, 0.5};  // the origin
  const double fresnel = raster::schlick_fresnel(raster::clear_coat_f0, std::sqrt(0.5));
  for (const double roughness : {0.01, 0.7}) {
    light.roughness = roughness;
    const double damped = std::exp(-std::pow(roughness, 4));
    CHECK(prepare(floor, camera, light).reflected(0, middle)[0] ==
          Approx(fresnel * (1 + damped * std::sqrt(0.5))).epsilon(1e-12));
  }
}

TEST_CASE("a coat is an addition to the linear map of the texture, and none at strength 0",
          "[raster][clear_coat]") {
  for (const auto& layout : {test::atlas, test::anisotropic, test::cube}) {
    const auto body = some_body(layout);
    const auto x = random_array<double>({raster::stored_texel_count(layout, body.mesh), 3}, 4);
    const auto y = random_array<double>({20, 25, 3}, 5);
    raster::ClearCoat<raster::SmoothLight> light{{warm}, 0.7, 0.3};
    const auto coated = raster::texture_operator<double>(body, Camera{}, 20, 25, light);
    const auto picture = raster::render(coated, x);
    CHECK(test::dot(coated.constant, y) > 1);
    const auto at_once = raster::render_textured(body, Camera{}, 20, 25, light, x).colour;
    for (std::size_t i = 0; i < picture.size(); ++i)
      CHECK(at_once.data()[i] == Approx(picture.data()[i]).epsilon(1e-12).margin(1e-12));
    auto back = tapestry::zeros<double, 2>(x.shape());
    raster::render_adjoint(coated, y, back);
    const Array<double, 3> ahead = picture - coated.constant;
    CHECK(test::dot(back, x) == Approx(test::dot(ahead, y)).epsilon(1e-12));
    light.coat = 0;
    CHECK((raster::render_textured(body, Camera{}, 20, 25, light, x).colour ==
           raster::render_textured(body, Camera{}, 20, 25, raster::SmoothLight{warm}, x).colour));
  }
}

TEST_CASE("a coat shows nothing of a sun below the surface, and stays finite at grazing angles",
          "[raster][clear_coat]") {
  const auto below = raster::ggx_reflection(up, {0, 0, 1}, {0.6, 0, -0.8}, 1, 0.1, 0.04);
  CHECK(below.value == 0);
  CHECK(below.by_towards == Vector3{0, 0, 0});
  for (const double alpha : {1e-4, 1.0}) {
    const auto grazing = raster::ggx_reflection(up, {1, 0, 0}, at_angle(1.57, pi), 0.001, alpha, 0.04);
    CHECK(std::isfinite(grazing.value));
    CHECK(std::isfinite(grazing.by_alpha));
    CHECK(geometry::is_finite(grazing.by_towards));
  }
  const auto body = some_body(test::solid);
  const raster::ClearCoat<raster::Light> mirror{warm, 1, 0.01};
  const auto picture = raster::texture_operator<float>(body, Camera{}, 20, 25, mirror);
  for (const float value : picture.constant) CHECK(std::isfinite(value));
}

TEST_CASE("a coat or a roughness outside its range is refused", "[raster][clear_coat][bad_input]") {
  const geometry::Mesh mesh;
  for (const auto& [coat, roughness] :
       {std::pair{1.1, 0.5}, {-0.1, 0.5}, {1.0, 0.0}, {1.0, 1.1}, {std::nan(""), 0.5}, {1.0, std::nan("")}})
    CHECK_THROWS_AS(prepare(mesh, Camera{}, raster::ClearCoat<raster::Light>{warm, coat, roughness}),
                    DomainError);
  CHECK_THROWS_WITH(prepare(mesh, Camera{}, raster::ClearCoat<raster::Light>{warm, 1, 0}),
                    "clear coat: roughness is 0.000000, expected 0.010000 to 1");
}
