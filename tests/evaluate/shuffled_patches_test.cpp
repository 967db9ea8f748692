#include <tapestry/evaluate/controls.hpp>

#include <set>

#include "../support/catch.hpp"
#include "../support/charts.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;

namespace {
/// Texels i = 0, 1, … of the colour (i, i/100, 0), so that each is unique.
Array<float, 2> numbered(std::size_t count) {
  Array<float, 2> colours(Extents<2>{count, 3});
  for (std::size_t i = 0; i < count; ++i) {
    colours(i, 0) = static_cast<float>(i);
    colours(i, 1) = static_cast<float>(i) / 100;
    colours(i, 2) = 0;
  }
  return colours;
}

/// Index of the texel that each colour comes from; fails if its channels were separated.
std::vector<std::size_t> sources(const Array<float, 2>& colours) {
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < colours.shape(0); ++i) {
    CHECK(colours(i, 1) == colours(i, 0) / 100);
    CHECK(colours(i, 2) == 0);
    numbers.push_back(static_cast<std::size_t>(colours(i, 0)));
  }
  return numbers;
}
}  // namespace

TEST_CASE("patches of a chart change places as a whole", "[evaluate][shuffled_patches]") {
  // Two patches, of columns 0, 1 and 2, 3, can only change places; three can in two ways.
  const auto two = test::rectangle_chart(2, 4);
  CHECK(sources(evaluate::shuffled_patches(numbered(8), {two}, {2, 2}, Random(1))) ==
        std::vector<std::size_t>{2, 3, 0, 1, 6, 7, 4, 5});
  const auto three = test::rectangle_chart(1, 6);
  std::set<std::vector<std::size_t>> seen;
  for (std::uint64_t seed = 0; seed < 20; ++seed)
    seen.insert(sources(evaluate::shuffled_patches(numbered(6), {three}, {1, 2}, Random(seed))));
  CHECK(seen == std::set<std::vector<std::size_t>>{{2, 3, 4, 5, 0, 1}, {4, 5, 0, 1, 2, 3}});
}

TEST_CASE("what patches leave over changes places among its like", "[evaluate][shuffled_patches]") {
  // Two squares of 2 × 2, and seven texels around them, whose patches of half the edge are single texels.
  const auto chart = test::rectangle_chart(3, 5);
  std::vector<std::set<std::size_t>> seen(15);
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const auto from = sources(evaluate::shuffled_patches(numbered(15), {chart}, {2, 2}, Random(seed)));
    for (std::size_t i = 0; i < 15; ++i) seen[i].insert(from[i]);
  }
  for (const std::size_t i : {0U, 1U, 5U, 6U}) {
    CHECK(seen[i] == std::set<std::size_t>{i + 2});
    CHECK(seen[i + 2] == std::set<std::size_t>{i});
  }
  for (const std::size_t i : {4U, 9U, 10U, 11U, 12U, 13U, 14U}) {
    std::set<std::size_t> others{4, 9, 10, 11, 12, 13, 14};
    others.erase(i);
    CHECK(seen[i] == others);
  }
}

TEST_CASE("a chart with room for one patch is cut into smaller ones", "[evaluate][shuffled_patches]") {
  const auto chart = test::rectangle_chart(5, 5);  // one of 4 × 4, four of 2 × 2 and nine texels
  const auto from = sources(evaluate::shuffled_patches(numbered(25), {chart}, {4, 4}, Random(2)));
  for (std::size_t i = 0; i < 25; ++i) CHECK(from[i] != i);
  for (const std::size_t corner : {0U, 2U, 10U, 12U}) {
    CHECK(from[corner + 1] == from[corner] + 1);
    CHECK(from[corner + 5] == from[corner] + 5);
  }
}

TEST_CASE("shuffled patches keep each colour in its chart", "[evaluate][shuffled_patches]") {
  const auto first =
      test::chart_of(11, 13, [](std::size_t y, std::size_t x) { return y + x > 5 && x * y < 90; });
  const auto second = test::rectangle_chart(5, 9, first.texels.size());
  const std::size_t count = first.texels.size() + second.texels.size();
  const auto colours = numbered(count + 2);
  const auto shuffled = evaluate::shuffled_patches(colours, {first, second}, {4, 4}, Random(3));
  const auto from = sources(shuffled);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < from.size(); ++i) {
    CHECK((from[i] < first.texels.size()) == (i < first.texels.size()));
    moved += from[i] != i ? 1U : 0U;
  }
  CHECK(std::set<std::size_t>(from.begin(), from.end()).size() == from.size());
  CHECK(from[count] == count);  // in no chart
  CHECK(moved == count);
  CHECK((evaluate::shuffled_patches(colours, {first, second}, {4, 4}, Random(3)) == shuffled));
  CHECK((evaluate::shuffled_patches(colours, {first, second}, {4, 4}, Random(4)) != shuffled));
}

TEST_CASE("patches larger than a chart, and charts without texels", "[evaluate][shuffled_patches]") {
  const auto colours = numbered(6);
  const auto chart = test::rectangle_chart(2, 3);
  const auto from = sources(evaluate::shuffled_patches(colours, {chart}, {64, 64}, Random(1)));
  CHECK(std::set<std::size_t>(from.begin(), from.end()).size() == 6);
  CHECK((evaluate::shuffled_patches(colours, {}, {2, 2}, Random(1)) == colours));
  CHECK((evaluate::shuffled_patches(colours, {raster::TextureChart{}}, {2, 2}, Random(1)) == colours));
  CHECK((evaluate::shuffled_patches(colours, {test::rectangle_chart(1, 1)}, {2, 2}, Random(1)) == colours));
}

TEST_CASE("patches are an eighth of an atlas's height, and whole faces of cubes",
          "[evaluate][shuffled_patches]") {
  raster::TextureLayout layout;
  layout.height = 64;
  CHECK(evaluate::patch_extents(layout).height == 8);
  CHECK(evaluate::patch_extents(layout).width == 8);
  layout.height = 3;
  CHECK(evaluate::patch_extents(layout).height == 1);
  layout.kind = raster::TextureKind::cube;
  layout.texels_per_edge = 6;
  CHECK(evaluate::patch_extents(layout).height == 1);
  CHECK(evaluate::patch_extents(layout).width == 86);
  layout.kind = raster::TextureKind::vertex;
  CHECK(evaluate::patch_extents(layout).width == 1);
}

TEST_CASE("shuffled patches refuse what does not fit", "[evaluate][shuffled_patches][error]") {
  auto colours = test::random_array<float>({4, 3}, 1);
  CHECK_THROWS_WITH(evaluate::shuffled_patches(colours, {test::rectangle_chart(2, 2)}, {0, 2}, Random(1)),
                    "shuffled_patches: a patch must have rows and columns");
  CHECK_THROWS_WITH(evaluate::shuffled_patches(colours, {test::rectangle_chart(3, 2)}, {2, 2}, Random(1)),
                    "shuffled_patches: a chart has texel 4 of a texture of 4");
  colours(2, 0) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH(evaluate::shuffled_patches(colours, {test::rectangle_chart(2, 2)}, {2, 2}, Random(1)),
                    "shuffled_patches: texel 2 has a colour that is not finite");
}
