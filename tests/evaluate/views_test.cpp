#include <tapestry/evaluate/views.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
raster::PaintedMesh normalised_car() {
  auto car = test::tiny_car();
  car.mesh = geometry::normalise_mesh(std::move(car.mesh));
  return car;
}
}  // namespace

TEST_CASE("an azimuth on the edge of two sectors belongs to the one that begins there", "[evaluate][views]") {
  const double below_45 = std::nextafter(45.0, 0.0), below_360 = std::nextafter(360.0, 0.0);
  // 360 − 10⁻¹⁸ rounds to 360.
  const std::vector<std::pair<double, std::size_t>> sectors{
      {0, 0},   {below_45, 0}, {45, 1},  {315, 7},  {below_360, 7}, {360, 0},
      {765, 1}, {-45, 7},      {-46, 6}, {-360, 0}, {-1e-18, 7}};
  for (const auto& [azimuth_deg, sector] : sectors) {
    CAPTURE(azimuth_deg);
    CHECK(evaluate::sector_of(azimuth_deg) == sector);
  }
  for (const double azimuth_deg : {std::nan(""), std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(evaluate::sector_of(azimuth_deg), DomainError);
}

TEST_CASE("the views are the paper's 4,320, 90 to a cell, none twice", "[evaluate][views]") {
  const evaluate::ViewGrid grid;
  const auto frames = evaluate::view_frames(grid);
  const auto table = evaluate::view_table(grid);
  REQUIRE(frames.size() == 4320);
  REQUIRE(table.rows.size() == 8);
  REQUIRE(table.columns == std::vector<std::string>{"1.5", "3", "5", "10", "15", "20"});
  CHECK(table.rows.back() == "315-360");
  std::vector<std::size_t> counts(table.cell_count());
  std::set<std::array<double, 3>> distinct;
  for (const auto& frame : frames) {
    ++counts[table.cell_of(frame)];
    distinct.insert({frame.distance, frame.elevation_deg, frame.azimuth_deg});
    CHECK(frame.distance == grid.distances[frame.column]);
    CHECK((45.0 * static_cast<double>(frame.row) <= frame.azimuth_deg &&
           frame.azimuth_deg < 45.0 * static_cast<double>(frame.row + 1)));
  }
  CHECK(distinct.size() == frames.size());
  CHECK(counts == std::vector<std::size_t>(48, 90));
  CHECK(evaluate::view_frames(evaluate::ViewGrid::quick()).size() == 432);
  CHECK_THROWS_AS(evaluate::view_frames({{5}, {0}, 7}), DomainError);
  CHECK_THROWS_AS(evaluate::view_frames({{5}, {0}, 0}), DomainError);
}

TEST_CASE("a protocol's camera is as far, as high and as wide as it says", "[evaluate][views]") {
  const auto camera = evaluate::protocol_camera({10, 30, 90, 0, 0});
  const auto eye = geometry::eye_of(camera);
  CHECK(std::abs(eye[0]) < 1e-12);
  CHECK(std::abs(eye[1] - 10 * std::cos(std::acos(-1.0) / 6)) < 1e-12);  // at the car's left
  CHECK(std::abs(eye[2] - 5) < 1e-12);
  // Half of the picture is tan 30° of the distance: a length of 1 across the axis is 1 / (10 · tan 30°) of
  // it.
  const auto at = geometry::picture_from_view(camera, geometry::view_from_world(camera, {1, 0, 0}), 100, 100);
  CHECK(std::abs(std::abs(at[1] - 50) - 50 * std::sqrt(3.0) / 10) < 1e-9);
}

TEST_CASE("a protocol's view is the car alone, and its target what shows of it", "[evaluate][views]") {
  const auto car = normalised_car();
  const evaluate::ProtocolPicture picture{48, 48, 4, {}, {0.2, 0.4, 0.6}};
  const auto view = evaluate::protocol_view({5, 0, 90, 0, 0}, car, picture);
  // From the side the box is 2 wide, 1.3/2 high, and its near side 0.45 nearer: 24 pixels are 4.55 · tan 30°.
  const double scale = 24 / ((5 - 0.45) * std::tan(std::acos(-1.0) / 6));
  CHECK(std::abs(view.target.w - 2 * scale) <= 2);  // whole pixels around it
  CHECK(std::abs(view.target.h - 0.65 * scale) <= 2);
  CHECK(view.target.cx == 24);
  for (std::size_t y = 0; y < 48; ++y)
    for (std::size_t x = 0; x < 48; ++x)
      CHECK((view.background(y, x, 0) == 51 / 255.0F && view.background(y, x, 1) == 102 / 255.0F &&
             view.background(y, x, 2) == 153 / 255.0F));
  CHECK(view.name == "distance 5, elevation 0, azimuth 90");

  // In a wide input the square picture lies in the middle, and the car in its own proportions.
  const auto wide = evaluate::protocol_view({5, 0, 90, 0, 0}, car, {48, 96, 4, {}, {1, 1, 1}});
  CHECK(wide.target.cx == 48);
  CHECK(wide.background(0, 23, 0) == 0.5F);  // beside the square
  CHECK(wide.background(0, 24, 0) == 1);
  CHECK(std::abs(wide.target.w - view.target.w) <= 2);
  CHECK(std::abs(wide.target.h - view.target.h) <= 2);
}

TEST_CASE("a car beyond what the camera draws is not in view", "[evaluate][views]") {
  const auto view = evaluate::protocol_view({5000, 0, 0, 0, 0}, normalised_car(), {48, 48, 2, {}, {1, 1, 1}});
  CHECK(view.visible_pixels == 0);
  CHECK(view.target.w == 0);
  CHECK_THROWS_AS(evaluate::protocol_camera({0, 0, 0, 0, 0}), DomainError);
}
