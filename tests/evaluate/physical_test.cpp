#include <tapestry/evaluate/meter.hpp>

#include "../support/catch.hpp"

namespace evaluate = tapestry::evaluate;

TEST_CASE("the photographs are the paper's 144, of 72 views that are also seen as they are",
          "[evaluate][physical]") {
  const evaluate::PhysicalGrid grid;
  const auto table = evaluate::physical_table(grid);
  const auto frames = evaluate::physical_frames(grid);
  REQUIRE(frames.size() == 144 + 72);
  REQUIRE(table.rows.size() == 6);
  REQUIRE(table.columns == std::vector<std::string>{"3", "4.5", "6"});
  CHECK(table.rows[4] == "street 2 as it is");
  CHECK(table.pictures_of_row(0) == 2);
  CHECK(table.pictures_of_row(3) == 1);
  std::set<std::size_t> views;
  std::vector<std::size_t> counts(table.cell_count());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto shown = evaluate::physical_frame(grid, i);
    ++counts[table.cell_of(frames[i])];
    views.insert(shown.view);
    CHECK(frames[i].row == shown.surroundings + (shown.photograph ? 0 : 3));
    CHECK(shown.photograph.value_or(2) == i % 3);
    CHECK(frames[i].distance == grid.distances[frames[i].column]);
    if (i % 3 == 0) continue;  // the same view as the one before
    CHECK(evaluate::physical_frame(grid, i - 1).view == shown.view);
    CHECK(frames[i - 1].azimuth_deg == frames[i].azimuth_deg);
    CHECK(frames[i - 1].column == frames[i].column);
  }
  CHECK(views.size() == 72);
  CHECK(*views.rbegin() == 71);
  for (std::size_t cell = 0; cell < 9; ++cell) CHECK(counts[cell] == 16);
  for (std::size_t cell = 9; cell < 18; ++cell) CHECK(counts[cell] == 8);
  CHECK(evaluate::physical_frames(evaluate::PhysicalGrid::quick()).size() == 72);
}

TEST_CASE("a physical grid without photographs or with uneven directions is refused",
          "[evaluate][physical]") {
  evaluate::PhysicalGrid grid;
  grid.photographs = 0;
  CHECK_THROWS_WITH(evaluate::physical_frames(grid), "physical_frames: no photographs of a view");
  grid.photographs = 1;
  grid.azimuth_step_deg = 7;
  CHECK_THROWS_AS(evaluate::physical_frames(grid), tapestry::DomainError);
}
