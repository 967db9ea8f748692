#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "../../examples/programs/shell/paint_panels.hpp"
#include "../../examples/programs/shell/pdf_file.hpp"
#include "../../examples/programs/shell/print_sheet.hpp"
#include "../support/catch.hpp"

namespace shell = tapestry::shell;

namespace {
using Points = std::vector<std::array<double, 3>>;
using Uvs = std::vector<std::array<double, 2>>;

/// All faces painted; corners have the same index in positions and uvs.
tapestry::raster::PaintedMesh body_of(Points positions, Uvs uvs, std::vector<std::array<int, 3>> faces) {
  tapestry::raster::PaintedMesh body;
  body.mesh.positions = std::move(positions);
  body.mesh.uvs = std::move(uvs);
  for (const auto& [a, b, c] : faces) body.mesh.faces.push_back({a, b, c});
  body.mesh.face_uvs = body.mesh.faces;
  body.painted.assign(faces.size(), 1);
  return body;
}

const Points rectangle{{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}};  // 2 x 1
const Uvs unit_square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
const std::vector<std::array<int, 3>> two_faces{{0, 1, 2}, {0, 2, 3}};
}  // namespace

TEST_CASE("a panel has the size of its faces on the car, whatever their size in uv", "[programs][panels]") {
  const auto found = shell::paint_panels(body_of(rectangle, unit_square, two_faces), 0.5);
  REQUIRE(found.panels.size() == 1);
  const auto& panel = found.panels[0];
  CHECK(panel.width_m == Approx(1).margin(1e-12));  // two units of half a metre
  CHECK(panel.height_m == Approx(0.5).margin(1e-12));
  CHECK(panel.area_m2 == Approx(0.5).margin(1e-12));
  CHECK(panel.stretch[0] == Approx(1).margin(1e-12));
  CHECK(panel.stretch[1] == Approx(1).margin(1e-12));
  CHECK(panel.rim.size() == 4);
  CHECK(found.flat_faces == 0);
}

TEST_CASE("the stretch of a panel is that of its faces by the mean scale", "[programs][panels]") {
  // One half is twice as wide as in uv, the other as wide: areas 2 and 1 on 1 and 1, the scales along u 2
  // and 1.
  const auto body =
      body_of({{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}, {3, 0, 0}, {3, 1, 0}},
              {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 0}, {2, 1}}, {{0, 1, 2}, {0, 2, 3}, {1, 4, 5}, {1, 5, 2}});
  const auto found = shell::paint_panels(body, 1);
  REQUIRE(found.panels.size() == 1);
  // right · up = 3 / 2 and right / up = 2^(2/3), as two thirds of the area have the ratio 2.
  const double right = std::sqrt(1.5 * std::cbrt(4.0)), up = 1.5 / right;
  CHECK(found.panels[0].width_m == Approx(2 * right).margin(1e-12));
  CHECK(found.panels[0].height_m == Approx(up).margin(1e-12));
  CHECK(found.panels[0].stretch[0] == Approx(1 / right).margin(1e-12));
  CHECK(found.panels[0].stretch[1] == Approx(2 / right).margin(1e-12));
}

TEST_CASE("a panel whose texture is mirrored is turned over", "[programs][panels]") {
  const auto plain = shell::paint_panels(body_of(rectangle, unit_square, two_faces), 1).panels.at(0);
  const auto turned =
      shell::paint_panels(body_of(rectangle, {{1, 0}, {0, 0}, {0, 1}, {1, 1}}, two_faces), 1).panels.at(0);
  CHECK(plain.place_m({0, 0})[0] == Approx(0).margin(1e-12));
  // The corner of u = 1 is on the left of the car.
  CHECK(turned.place_m({1, 0})[0] == Approx(0).margin(1e-12));
  const auto uv = turned.uv(turned.place_m({0.3, 0.8}));
  CHECK(uv[0] == Approx(0.3).margin(1e-12));
  CHECK(uv[1] == Approx(0.8).margin(1e-12));
}

TEST_CASE("halves that share their texture are two panels", "[programs][panels]") {
  const auto body = body_of({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}}, {{0, 0}, {1, 0}, {0, 1}, {1, 0}},
                            {{0, 1, 2}, {0, 2, 3}});
  const auto found = shell::paint_panels(body, 1);
  REQUIRE(found.panels.size() == 2);
  CHECK(found.panels[0].right * found.panels[1].right < 0);
}

TEST_CASE("the inside of sheet metal is a panel of its own", "[programs][panels]") {
  auto faces = two_faces;
  faces.insert(faces.end(), {{0, 2, 1}, {0, 3, 2}});
  const auto found = shell::paint_panels(body_of(rectangle, unit_square, faces), 1);
  REQUIRE(found.panels.size() == 2);
  CHECK(found.panels[0].faces.size() == 2);
  CHECK(found.panels[0].right * found.panels[1].right < 0);
}

TEST_CASE("faces that turn differently are one panel where the texture goes on", "[programs][panels]") {
  CHECK(shell::paint_panels(body_of(rectangle, unit_square, {{0, 1, 2}, {0, 3, 2}}), 1).panels.size() == 1);
}

TEST_CASE("faces without area in the texture are counted", "[programs][panels]") {
  auto body = body_of(rectangle, {{0, 0}, {1, 0}, {1, 1}, {0.5, 0.5}}, two_faces);
  CHECK(shell::paint_panels(body, 1).flat_faces == 1);
  body.painted = {1, 0};
  CHECK(shell::paint_panels(body, 1).flat_faces == 0);
}

TEST_CASE("tiles cover a panel with a centimetre in common", "[programs][panels]") {
  // A window of A4 is 19 x 25.9 cm: two tiles side by side show 37 cm.
  CHECK(shell::tile_grid(19, 25.9, 21, 29.7).columns == 1);
  CHECK(shell::tile_grid(19.1, 25.9, 21, 29.7).columns == 2);
  CHECK(shell::tile_grid(37, 1, 21, 29.7).columns == 2);
  CHECK(shell::tile_grid(37.1, 1, 21, 29.7).columns == 3);
  CHECK(shell::tile_grid(100, 100, 21, 29.7).columns == 6);
  CHECK(shell::tile_grid(100, 100, 21, 29.7).rows == 4);
}

TEST_CASE("a page escapes what would end its text", "[programs][pdf]") {
  shell::PdfPage page(21, 29.7);
  page.text({2.54, 0}, 9, "\xC3\xA9 a(b)\\");
  CHECK(page.content() == "BT /F1 9.000 Tf 72.000 0.000 Td (?? a\\(b\\)\\\\) Tj ET\n");
}
