#include <tapestry/core/random.hpp>
#include <tapestry/raster/used_texels.hpp>

#include "../support/catch.hpp"
#include "../support/uv_triangles.hpp"

using namespace tapestry;
using test::body_of;

namespace {
/// The texels that many lookups in the triangle take from.
Array<double, 2> sampled(const raster::PaintedMesh& body, int samples) {
  auto used = tapestry::zeros<double, 2>({body.layout.height, body.layout.width});
  for (int i = 0; i <= samples; ++i)
    for (int j = 0; i + j <= samples; ++j) {
      const double a = static_cast<double>(i) / samples, b = static_cast<double>(j) / samples;
      std::array<double, 2> uv{};
      for (std::size_t axis = 0; axis < 2; ++axis)
        uv[axis] =
            a * body.mesh.uvs[0][axis] + b * body.mesh.uvs[1][axis] + (1 - a - b) * body.mesh.uvs[2][axis];
      raster::visit_atlas_taps(body.layout, uv, [&](const raster::Tap& tap) {
        if (tap.weight > 1e-9) used.data()[tap.texel] = 1;
      });
    }
  return used;
}
}  // namespace

TEST_CASE("used_texels equals the texels worked out by hand", "[raster][used_texels]") {
  // u from 2/8 to 4/8, v from 4/8 to 6/8: columns 2 to 4 and rows 2 to 4 in texels, lower left half.
  const auto used = raster::used_texels<double>(body_of({{{{0.25, 0.75}, {0.25, 0.5}, {0.5, 0.5}}}}, 8, 8));
  for (std::size_t row = 0; row < 8; ++row)
    for (std::size_t column = 0; column < 8; ++column) {
      // The centres' neighbourhoods of ±1 overlap [2, 4]² within rows 1 to 4 and columns 1 to 4; the upper
      // right one of them lies beyond the slanted edge x = y: its nearest corner, (column − ½, row + 1½).
      const bool in_square = row >= 1 && row <= 4 && column >= 1 && column <= 4;
      const bool below_edge = static_cast<double>(column) - 0.5 < static_cast<double>(row) + 1.5;
      CHECK(used(row, column) == (in_square && below_edge ? 1.0 : 0.0));
    }
}

TEST_CASE("used_texels are those that lookups within the face take from", "[raster][used_texels]") {
  Random random(3);
  for (int trial = 0; trial < 30; ++trial) {
    std::array<std::array<double, 2>, 3> uv{};
    for (auto& corner : uv) corner = {random.uniform(-0.7, 2.6), random.uniform(-0.4, 1.3)};
    const auto body = body_of({uv}, 6, 9, 2);
    const auto used = raster::used_texels<double>(body);
    const auto looked_up = sampled(body, 400);
    std::size_t more = 0;
    for (std::size_t i = 0; i < used.size(); ++i) {
      CAPTURE(trial, i);
      REQUIRE(used.data()[i] >= looked_up.data()[i]);
      more += used.data()[i] > looked_up.data()[i] ? 1U : 0U;
    }
    CHECK(more <= 1);  // samples may miss a corner of a texel's reach
  }
}

TEST_CASE("used_texels leaves out faces that are not painted", "[raster][used_texels]") {
  auto body = body_of({{{{0, 0}, {1, 0}, {0, 1}}}, {{{0.9, 0.9}, {1, 0.9}, {1, 1}}}}, 16, 16);
  body.painted[0] = 0;
  const auto used = raster::used_texels<float>(body);
  CHECK(used(0, 15) == 1.0F);
  CHECK(used(15, 0) == 0.0F);
  CHECK(used(8, 8) == 0.0F);
}

TEST_CASE("used_texels takes no texel from the opposite border", "[raster][used_texels]") {
  const auto used = raster::used_texels<double>(body_of({{{{0, 0}, {0.1, 0}, {0, 0.1}}}}, 8, 8));
  CHECK(used(7, 0) == 1.0);
  CHECK(used(7, 7) == 0.0);
  CHECK(used(0, 0) == 0.0);
}

TEST_CASE("used_texels refuses what has no atlas", "[raster][used_texels][error]") {
  auto body = body_of({{{{0, 0}, {0.1, 0}, {0, 0.1}}}}, 8, 8);
  body.layout.kind = raster::TextureKind::solid;
  CHECK_THROWS_WITH(raster::used_texels<double>(body),
                    "used_texels: expected an atlas, found a texture of another kind");
  CHECK_THROWS_WITH(raster::used_texels<double>(body_of({{{{0, 0}, {9, 0}, {0, 1}}}}, 4, 4)),
                    "used_texels: face 0 spans over 9.000000 repetitions of the atlas, expected at most 8");
  body = body_of({{{{0, 0}, {0.1, 0}, {0, 0.1}}}}, 8, 8);
  body.painted.clear();
  CHECK_THROWS_AS(raster::used_texels<double>(body), ShapeError);
}

TEST_CASE("a face without extent on a border of the atlas uses what its lookups take",
          "[raster][used_texels]") {
  const std::array<double, 2> middle{0.3, 0.7};
  for (const double border : {-1.0, 0.0, 1.0, 2.0, 3.0})
    for (const std::size_t axis : {0U, 1U})
      for (const bool is_point : {true, false}) {
        std::array<std::array<double, 2>, 3> uv{middle, middle, middle};
        for (auto& corner : uv) corner[axis] = border;
        if (!is_point) uv[1][1 - axis] = 0.9;
        const auto body = body_of({uv}, 6, 9);
        const auto used = raster::used_texels<double>(body), looked_up = sampled(body, 50);
        CAPTURE(border, axis, is_point);
        for (std::size_t i = 0; i < used.size(); ++i)
          if (looked_up.data()[i] != 0) CHECK(used.data()[i] == 1);
        const auto count = [](const Array<double, 2>& of) {
          return std::count(of.data(), of.data() + of.size(), 1.0);
        };
        CHECK(count(used) <= 2 * count(looked_up) + 4);
      }
  for (const double at : {0.0, 1.0}) {  // values that files give to faces without a texture
    auto body = body_of({{{{at, at}, {at, at}, {at, at}}}}, 8, 8);
    body.layout.filter = raster::TextureFilter::anisotropic;
    const auto levels = (*raster::pyramid_of(body))(tapestry::filled<double, 2>({64, 3}, 0.7));
    for (std::size_t i = 0; i < levels.size(); ++i) REQUIRE(levels.data()[i] == Approx(0.7).epsilon(1e-12));
  }
}
