#include <tapestry/raster/used_texels.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"
#include "../support/uv_triangles.hpp"

using namespace tapestry;
using test::body_of, test::UvTriangle;

namespace {
/// Both halves of the rectangle [left, right] × [low, high].
std::vector<UvTriangle> rectangle(double left, double right, double low, double high) {
  return {{{{left, low}, {right, low}, {right, high}}}, {{{left, low}, {right, high}, {left, high}}}};
}

std::vector<UvTriangle> both(std::vector<UvTriangle> some, const std::vector<UvTriangle>& others) {
  some.insert(some.end(), others.begin(), others.end());
  return some;
}

/// The texels of charts as one list; fails where one stands twice or outside its box.
std::vector<std::size_t> texels_of(const std::vector<raster::TextureChart>& charts) {
  std::set<std::size_t> texels;
  std::size_t count = 0;
  for (const auto& chart : charts) {
    std::set<std::array<std::size_t, 2>> places;
    for (const auto& texel : chart.texels) {
      CHECK(texel.row < chart.height);
      CHECK(texel.column < chart.width);
      places.insert({texel.row, texel.column});
      texels.insert(texel.texel);
      ++count;
    }
    CHECK(places.size() == chart.texels.size());
  }
  CHECK(texels.size() == count);
  return {texels.begin(), texels.end()};
}
}  // namespace

TEST_CASE("charts are faces that hang together in uv, by value", "[raster][texture_charts]") {
  // Two rectangles a tenth of a texel apart, so that lookups in both take from the texels between them.
  const auto body = body_of(both(rectangle(0, 0.5, 0, 1), rectangle(0.51, 1, 0.5, 1)), 10, 10);
  const auto charts = raster::texture_charts(body);
  REQUIRE(charts.size() == 2);
  // The first has the centres of columns 0 to 4 and reaches column 5, which the other has in rows 0 to 4.
  // The other reaches row 5, but in column 5 it comes second; so it does in column 4, which it reaches.
  CHECK(charts[0].height == 10);
  CHECK(charts[0].width == 6);
  CHECK(charts[0].texels.size() == 50 + 5);
  CHECK(charts[1].height == 6);
  CHECK(charts[1].width == 5);
  CHECK(charts[1].texels.size() == 25 + 4);
}

TEST_CASE("the texels of charts are the used ones, each once", "[raster][texture_charts]") {
  for (const auto kind : {raster::TextureKind::atlas, raster::TextureKind::cube}) {
    const auto car = test::tiny_car(12, kind);
    const auto charts = raster::texture_charts(car);
    const auto texels = texels_of(charts);
    if (kind == raster::TextureKind::cube) {
      CHECK(charts.size() == 1);
      CHECK(charts[0].height == 10);  // two faces of the twelve are not painted
      continue;
    }
    const auto used = raster::used_texels<double>(car);
    std::vector<std::size_t> expected;
    for (std::size_t texel = 0; texel < used.size(); ++texel)
      if (used.data()[texel] != 0) expected.push_back(texel);
    CHECK(texels == expected);
    CHECK(charts.size() == 1);  // its sides lie edge to edge
  }
}

TEST_CASE("a chart's texels keep their places towards each other", "[raster][texture_charts]") {
  const auto charts = raster::texture_charts(body_of(rectangle(0.3, 0.6, 0.2, 0.7), 20, 30));
  REQUIRE(charts.size() == 1);
  const auto& texels = charts[0].texels;
  for (const auto& texel : texels)
    CHECK(texel.texel == (texels[0].texel / 30 + texel.row) * 30 + 8 + texel.column);  // 0.3 · 30 is column 9
  CHECK(texels_of(charts).size() == texels.size());
}

TEST_CASE("the texels of a cube that lookups take from are those of a dense lattice",
          "[raster][texture_charts]") {
  CHECK(raster::detail::used_cube_texels(6).size() == 86);  // as counted in Neural Mesh Renderer's cubes
  for (std::size_t edge = 1; edge <= 5; ++edge) {
    raster::TextureLayout layout;
    layout.kind = raster::TextureKind::cube;
    layout.texels_per_edge = edge;
    std::set<std::size_t> taken;
    const int lattice = 97;  // no multiple of edge − 1, so that no point falls on texels alone
    for (int a = 0; a <= lattice; ++a)
      for (int b = 0; a + b <= lattice; ++b)
        raster::visit_cube_taps(layout, 0,
                                {static_cast<double>(a) / lattice, static_cast<double>(b) / lattice,
                                 static_cast<double>(lattice - a - b) / lattice},
                                [&](const raster::Tap& tap) { taken.insert(tap.texel); });
    const auto used = raster::detail::used_cube_texels(edge);
    CAPTURE(edge);
    CHECK(std::vector<std::size_t>(taken.begin(), taken.end()) == used);
  }
}

TEST_CASE("vertices and a solid colour are one chart, and without painted faces there is none",
          "[raster][texture_charts]") {
  auto car = test::tiny_car(12, raster::TextureKind::vertex);
  car.painted.assign(car.painted.size(), 0);
  CHECK(raster::texture_charts(car).empty());
  car.painted[3] = 1;
  const auto vertices = raster::texture_charts(car);
  REQUIRE(vertices.size() == 1);
  CHECK(texels_of(vertices) == std::vector<std::size_t>{2, 4, 6});
  CHECK(vertices[0].width == 3);
  car.layout.kind = raster::TextureKind::solid;
  CHECK(texels_of(raster::texture_charts(car)) == std::vector<std::size_t>{0});
  car.layout.kind = raster::TextureKind::atlas;
  car.painted[3] = 0;
  CHECK(raster::texture_charts(car).empty());
}

TEST_CASE("an atlas that its faces repeat without end is one chart", "[raster][texture_charts]") {
  const auto charts = raster::texture_charts(body_of({{{{0, 0}, {40, 0}, {0, 1}}}}, 4, 6));
  REQUIRE(charts.size() == 1);
  CHECK(charts[0].height == 4);
  CHECK(charts[0].width == 6);
  CHECK(texels_of(charts).size() == 24);
}

TEST_CASE("charts of what is painted are the pieces that hang together", "[raster][texture_charts]") {
  // A U of 3 × 3 texels, whose arms meet below, and beside it, at a corner only, one more texel.
  const std::vector<std::uint8_t> painted{1, 0, 1, 0,  //
                                          1, 0, 1, 0,  //
                                          1, 1, 1, 0,  //
                                          0, 0, 0, 1};
  raster::TextureChart chart{4, 4};
  for (std::size_t i = 0; i < 16; ++i) chart.texels.push_back({i / 4, i % 4, 100 + i});
  std::vector<std::uint8_t> of_texture(116, 1);
  std::copy(painted.begin(), painted.end(), of_texture.begin() + 100);
  const auto pieces = raster::painted_charts({chart}, of_texture);
  REQUIRE(pieces.size() == 2);
  CHECK(pieces[0].height == 3);
  CHECK(pieces[0].width == 3);
  CHECK(pieces[0].texels.size() == 7);
  CHECK(pieces[0].texels.back().texel == 110);
  CHECK(pieces[1].height == 1);
  CHECK(pieces[1].width == 1);
  CHECK(pieces[1].texels.front().texel == 115);
  CHECK(pieces[1].texels.front().row == 0);
  CHECK(texels_of(pieces).size() == 8);
  CHECK(raster::painted_charts({chart}, std::vector<std::uint8_t>(116, 0)).empty());
  const auto all = raster::painted_charts({chart}, {});
  REQUIRE(all.size() == 1);
  CHECK(all[0].texels.size() == 16);
  CHECK_THROWS_WITH(raster::painted_charts({chart}, std::vector<std::uint8_t>(115, 1)),
                    "painted_charts: 115 texels are painted or not, and a chart has texel 115");
}

TEST_CASE("charts need a mesh that fits its texture", "[raster][texture_charts][error]") {
  auto body = body_of(rectangle(0, 1, 0, 1), 4, 4);
  body.mesh.face_uvs[1][2] = -1;
  CHECK_THROWS_WITH(raster::texture_charts(body),
                    "texture_charts: face 1 is painted from an atlas but has no uv");
  body.painted.pop_back();
  CHECK_THROWS_AS(raster::texture_charts(body), ShapeError);
}

TEST_CASE("the share of the paint without texels is that of faces at points of a palette",
          "[raster][texture_charts]") {
  const std::vector<UvTriangle> point{{{{0.25, 0.5}, {0.25, 0.5}, {0.25, 0.5}}}};
  CHECK(raster::starved_share(body_of(rectangle(0, 1, 0, 1), 8, 8)) == 0);
  CHECK(raster::starved_share(body_of(point, 8, 8)) == 1);
  CHECK(raster::starved_share(body_of(rectangle(0.2, 0.3, 0.2, 0.3), 8, 8)) == 1);    // .64 texels
  CHECK(raster::starved_share(body_of(rectangle(0.2, 0.4, 0.2, 0.4), 16, 16)) == 0);  // 10
  auto mixed = body_of(both(rectangle(0, 1, 0, 1), point), 64, 64);
  CHECK(raster::starved_share(mixed) == Approx(1.0 / 3));
  mixed.painted[2] = 0;
  CHECK(raster::starved_share(mixed) == 0);
  std::vector<UvTriangle> fine;  // no face has a texel of its own, but all are connected
  for (double i = 0; i < 400; ++i) fine = both(fine, rectangle(i / 400, (i + 1) / 400, 0, 1));
  CHECK(raster::starved_share(body_of(fine, 4, 4)) == 0);
  // A cell of a palette for many faces: less than a hundredth of their area's share.
  std::vector<UvTriangle> cell;
  for (int i = 0; i < 100; ++i) cell = both(cell, rectangle(0.5, 0.52, 0.5, 0.52));
  CHECK(raster::starved_share(body_of(cell, 100, 100)) == 1);
  mixed.layout.kind = raster::TextureKind::cube;
  mixed.layout.texels_per_edge = 4;
  CHECK(raster::starved_share(mixed) == 0);
}
