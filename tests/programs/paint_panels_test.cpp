#include <set>
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/io/obj_file.hpp>

#include "../../examples/programs/shell/paint_panels.hpp"
#include "../../examples/programs/shell/print_sheet.hpp"
#include "../support/catch.hpp"
#include "../support/paths.hpp"

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

TEST_CASE("a panel has the size of its faces on the car, whatever their uv", "[programs][panels]") {
  const auto found =
      shell::paint_panels(body_of(rectangle, {{0, 0}, {1, 0}, {0.3, 0.1}, {0, 0}}, two_faces), 0.5);
  REQUIRE(found.panels.size() == 1);
  const auto& panel = found.panels[0];
  CHECK(panel.height_m == Approx(1).margin(1e-6));  // level: its front, +x, is up
  CHECK(panel.width_m == Approx(0.5).margin(1e-6));
  CHECK(panel.area_m2 == Approx(0.5).margin(1e-12));
  CHECK(panel.stretch[0] == Approx(1).margin(1e-6));
  CHECK(panel.stretch[1] == Approx(1).margin(1e-6));
  CHECK(panel.rim.size() == 4);
  CHECK(panel.to_front[1] == Approx(1).margin(1e-6));
  CHECK(std::hypot(panel.to_top[0], panel.to_top[1]) < 1e-6);
  CHECK(panel.marks.empty());
  CHECK(found.flat_faces == 0);
}

TEST_CASE("a wall's panel stands upright, seen from outside", "[programs][panels]") {
  // The left side of a car, whose front is +x: seen from outside, the front is on the left.
  const auto body = body_of({{2, 1, 0}, {0, 1, 0}, {0, 1, 1}, {2, 1, 1}}, unit_square, two_faces);
  const auto panel = shell::paint_panels(body, 1).panels.at(0);
  CHECK(panel.width_m == Approx(2).margin(1e-6));
  CHECK(panel.to_top[1] == Approx(1).margin(1e-6));
  CHECK(panel.to_front[0] == Approx(-1).margin(1e-6));
  CHECK(panel.places_m[0][0][0] == Approx(0).margin(1e-6));
}

TEST_CASE("the inside of sheet metal is a panel of its own", "[programs][panels]") {
  auto faces = two_faces;
  faces.insert(faces.end(), {{0, 2, 1}, {0, 3, 2}});
  const auto found = shell::paint_panels(body_of(rectangle, unit_square, faces), 1);
  REQUIRE(found.panels.size() == 2);
  CHECK(found.panels[0].faces.size() == 2);
  CHECK(found.panels[1].faces.size() == 2);
}

TEST_CASE("a face as thin as a hair is a panel", "[programs][panels]") {
  const auto body = body_of({{0, 0, 0}, {1, 0, 0}, {0.5, 1e-9, 0}}, unit_square, {{0, 1, 2}});
  const auto found = shell::paint_panels(body, 1);
  REQUIRE(found.panels.size() == 1);
  CHECK(found.panels[0].height_m == Approx(1));
}

TEST_CASE("faces without area are counted", "[programs][panels]") {
  auto body = body_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {2, 2, 0}}, unit_square, two_faces);
  body.mesh.positions[3] = {0.5, 0.5, 0};
  CHECK(shell::paint_panels(body, 1).flat_faces == 1);
  body.painted = {1, 0};
  CHECK(shell::paint_panels(body, 1).flat_faces == 0);
}

namespace {
/// Lengths along the edges of a mesh over those along its panel, from the ends of long ways: stretch and
/// slack of a print folded onto the mesh.
std::array<double, 2> way_ratios(const tapestry::geometry::Mesh& mesh, const shell::PaintPanel& panel) {
  using Place = std::array<double, 2>;
  std::map<Place, std::size_t> numbers;
  std::vector<std::vector<std::array<double, 3>>> ways;  // to, length on the car, length on the panel
  const auto number = [&](const Place& place) {
    const auto [found, is_new] = numbers.try_emplace(place, numbers.size());
    if (is_new) ways.emplace_back();
    return found->second;
  };
  for (std::size_t i = 0; i < panel.faces.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Place a = panel.places_m[i][k], b = panel.places_m[i][(k + 1) % 3];
      const double on_car = tapestry::geometry::length(
          tapestry::geometry::subtract(shell::detail::place_of(mesh, panel.faces[i], k),
                                       shell::detail::place_of(mesh, panel.faces[i], (k + 1) % 3)));
      const std::size_t from = number(a), to = number(b);
      const double on_panel = std::hypot(a[0] - b[0], a[1] - b[1]);
      ways[from].push_back({double(to), on_car, on_panel});
      ways[to].push_back({double(from), on_car, on_panel});
    }
  std::array<double, 2> range{1, 1};
  for (std::size_t start = 0; start < ways.size(); start += 1 + ways.size() / 7) {
    std::vector<std::array<double, 2>> far(ways.size(), {1e300, 0});
    std::set<std::pair<double, std::size_t>> waiting{{0, start}};
    far[start] = {0, 0};
    double farthest = 0;
    while (!waiting.empty()) {
      const auto [length, at] = *waiting.begin();
      waiting.erase(waiting.begin());
      if (length > far[at][0]) continue;
      farthest = length;
      for (const auto& [to, on_car, on_panel] : ways[at])
        if (auto& other = far[static_cast<std::size_t>(to)]; length + on_car < other[0]) {
          other = {length + on_car, far[at][1] + on_panel};
          waiting.insert({other[0], static_cast<std::size_t>(to)});
        }
    }
    for (const auto& [on_car, on_panel] : far)
      if (on_car > farthest / 2 && on_car < 1e300) {
        range[0] = std::min(range[0], on_car / on_panel);
        range[1] = std::max(range[1], on_car / on_panel);
      }
  }
  return range;
}
}  // namespace

TEST_CASE("panels of round bodies keep lengths, and cover them once", "[programs][panels]") {
  namespace geometry = tapestry::geometry;
  tapestry::raster::PaintedMesh body;
  const bool is_sphere = GENERATE(true, false);
  CAPTURE(is_sphere);
  body.mesh = is_sphere
                  ? geometry::icosphere(3)
                  : tapestry::io::read_obj(tapestry::test::in_sources("examples/assets/car_sedan.obj")).mesh;
  body.painted.assign(body.mesh.faces.size(), 1);
  if (!is_sphere) body.painted = geometry::faces_by_material(body.mesh, {"body"});
  const auto found = shell::paint_panels(body, 1);
  double area = 0, stated = 0;
  std::map<std::size_t, std::vector<geometry::Vector3>> marked;
  std::set<std::size_t> faces;
  for (const auto& panel : found.panels) {
    CHECK(panel.stretch[0] >= 0.97);
    CHECK(panel.stretch[1] <= 1.03);
    const auto [shortest, longest] = way_ratios(body.mesh, panel);
    CHECK(shortest >= 0.98);
    CHECK(longest <= 1.02);
    stated += panel.area_m2;
    for (std::size_t i = 0; i < panel.faces.size(); ++i) {
      CHECK(faces.insert(panel.faces[i]).second);
      const auto& [a, b, c] = panel.places_m[i];
      const double turn = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
      CHECK(turn > 0);
      area += turn / 2;
      for (const auto& mark : panel.marks) {  // a mark is the middle of an edge of the rim
        for (std::size_t k = 0; k < 3; ++k) {
          const auto &p = panel.places_m[i][k], &q = panel.places_m[i][(k + 1) % 3];
          if (std::hypot((p[0] + q[0]) / 2 - mark.place_m[0], (p[1] + q[1]) / 2 - mark.place_m[1]) < 1e-9)
            marked[mark.number].push_back(geometry::scale(
                geometry::add(shell::detail::place_of(body.mesh, panel.faces[i], k),
                              shell::detail::place_of(body.mesh, panel.faces[i], (k + 1) % 3)),
                0.5));
        }
      }
    }
  }
  CHECK(area == Approx(stated).epsilon(0.01));
  CHECK(faces.size() + found.flat_faces == static_cast<std::size_t>(std::ranges::count(body.painted, 1)));
  REQUIRE(!marked.empty());
  for (const auto& [number, places] : marked) {
    CAPTURE(number);
    REQUIRE(places.size() == 2);
    CHECK(geometry::length(geometry::subtract(places[0], places[1])) < 1e-12);
  }
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
