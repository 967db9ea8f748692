#include <tapestry/raster/painted.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// Two large faces in front of the default camera, one of "body" with u to 1.8, one of "glass" with u to 3.
geometry::Mesh two_materials() {
  auto mesh =
      test::triangle_soup({{{{-1, -1, 2}, {1, -1, 2}, {-1, 1, 2}}}, {{{1, -1, 3}, {1, 1, 3}, {-1, 1, 3}}}});
  mesh.uvs = {{0.1, 0.1}, {1.8, 0.1}, {0.1, 0.9}, {2.1, 0.1}, {3, 0.5}, {2.2, 0.9}};
  mesh.materials = {{}, {}};
  mesh.materials[0].name = "body";
  mesh.materials[1].name = "glass";
  mesh.face_materials = {0, 1};
  return mesh;
}
}  // namespace

TEST_CASE("painted() covers the faces of a material by an atlas of square texels", "[raster][painted]") {
  const auto car = raster::painted(two_materials(), {.material = "body"});
  CHECK(car.painted == std::vector<std::uint8_t>{1, 0});
  CHECK(car.layout.kind == raster::TextureKind::atlas);
  CHECK(car.layout.height == 64);
  CHECK(car.layout.width == 128);  // u up to 2
  CHECK(car.layout.u_extent == 2);
  CHECK(car.space == image::ColourSpace::linear);
  CHECK(car.pyramid == nullptr);
  const auto whole = raster::painted(two_materials(), {.rows = 10});
  CHECK(whole.painted == std::vector<std::uint8_t>{1, 1});
  CHECK(whole.layout.u_extent == 3);  // whose last texel is at u = 3
  CHECK(whole.layout.width == 30);
}

TEST_CASE("painted() keeps texels in other ways, and makes a filtered atlas' pyramid", "[raster][painted]") {
  const auto vertex = raster::painted(two_materials(), {.kind = raster::TextureKind::vertex});
  CHECK(vertex.layout.texel_count(vertex.mesh) == 6);
  const auto cube = raster::painted(two_materials(), {.kind = raster::TextureKind::cube, .rows = 3});
  CHECK(cube.layout.texel_count(cube.mesh) == 2 * 27);
  const auto filtered = raster::painted(
      two_materials(), {.material = "body", .rows = 8, .filter = raster::TextureFilter::trilinear});
  REQUIRE(filtered.pyramid != nullptr);
  CHECK(raster::stored_texel_count(filtered.layout, filtered.mesh) >
        filtered.layout.texel_count(filtered.mesh));
}

TEST_CASE("painted() refuses an unknown material by the names there are", "[raster][painted][bad_input]") {
  CHECK_THROWS_WITH(raster::painted(two_materials(), {.material = "bonnet"}),
                    "faces_by_material: the mesh has no material 'bonnet'; it has 'body', 'glass'");
  CHECK_THROWS_AS(raster::painted(geometry::Mesh{}, {.material = "body"}), Error);
}

TEST_CASE("painted() refuses an atlas without end", "[raster][painted][bad_input]") {
  auto mesh = two_materials();
  for (const double u : {65.0, 1e30, std::numeric_limits<double>::infinity()}) {
    mesh.uvs[0][0] = u;
    CHECK_THROWS_AS(raster::painted(mesh), DomainError);
    CHECK(raster::painted(mesh, {.material = "glass"}).layout.u_extent == 3);
  }
  mesh.uvs[0][0] = 65;
  CHECK_THROWS_WITH(raster::painted(mesh),
                    "painted: u of the painted faces goes up to 65.000000, expected at most 64");
  CHECK_THROWS_AS(raster::painted(two_materials(), {.rows = 0, .filter = raster::TextureFilter::trilinear}),
                  Error);
}

TEST_CASE("painted() takes u that a file has rounded up for a whole number", "[raster][painted]") {
  auto mesh = two_materials();
  mesh.uvs[1][0] = 2.000001;
  CHECK(raster::painted(mesh, {.material = "body"}).layout.u_extent == 2);
}

TEST_CASE("painted() of a mesh with NaN or without uvs has an atlas one unit wide", "[raster][painted]") {
  auto mesh = two_materials();
  for (auto& uv : mesh.uvs) uv[0] = std::numeric_limits<double>::quiet_NaN();
  CHECK(raster::painted(mesh).layout.u_extent == 1);
  mesh.face_uvs.clear();
  CHECK(raster::painted(mesh).layout.u_extent == 1);
}

TEMPLATE_TEST_CASE("picture_and_gradient() agrees with render() and central differences",
                   "[raster][painted][gradient]", float, double) {
  using T = TestType;
  const auto car = raster::painted(two_materials(), {.material = "body", .rows = 6});
  const auto view = raster::texture_operator<T>(car, geometry::Camera{}, 12, 14, raster::Light{});
  const auto texels = random_array<T>({car.layout.texel_count(car.mesh), 3}, 1, 0.1, 0.9);
  const auto loss = [](const ArrayVariable<T, 3>& picture) {
    return Variable<T>(sum(picture * picture) / T(20));
  };
  const auto found = raster::picture_and_gradient(view, texels, loss);
  CHECK((found.picture == raster::render(view, texels)));
  const auto value = [&](const Array<T, 2>& x) { return raster::picture_and_gradient(view, x, loss).loss; };
  CHECK(found.loss == value(texels));
  CHECK(found.loss == Approx(test::dot(found.picture, found.picture) / T(20)));
  const auto direction = test::random_direction<T>({texels.shape(0), 3}, 2);
  CHECK(std::abs(test::dot(found.gradient, direction) - test::central_difference(value, texels, direction)) <=
        test::central_difference_tolerance(found.loss));
  CHECK_THROWS_AS(raster::picture_and_gradient(view, random_array<T>({5, 3}, 3), loss), ShapeError);
}
