#include <tapestry/segment/car_component.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
/// One row a text; # is 1, + is half, everything else 0.
Array<float, 2> drawn(const std::vector<std::string>& rows) {
  Array<float, 2> mask({rows.size(), rows.empty() ? 0 : rows[0].size()});
  for (std::size_t i = 0; i < mask.size(); ++i) {
    const char pixel = rows[i / mask.shape(1)][i % mask.shape(1)];
    mask.data()[i] = pixel == '#' ? 1 : pixel == '+' ? 0.5F : 0.25F;
  }
  return mask;
}

std::vector<std::string> shown(const Array<std::uint8_t, 2>& mask) {
  std::vector<std::string> rows(mask.shape(0), std::string(mask.shape(1), '.'));
  for (std::size_t row = 0; row < mask.shape(0); ++row)
    for (std::size_t column = 0; column < mask.shape(1); ++column)
      if (mask(row, column) != 0) rows[row][column] = '#';
  return rows;
}
using Rows = std::vector<std::string>;
}  // namespace

TEST_CASE("the car is the largest piece, joined by edges, of what reaches the threshold",
          "[segment][car_component]") {
  const auto mask = drawn({"##..+", "##..#", "..###", "....#"});
  CHECK(shown(segment::car_component(mask)) == Rows{"....#", "....#", "..###", "....#"});
  CHECK(shown(segment::car_component(mask, {}, 0.75)) == Rows{".....", "....#", "..###", "....#"});
  CHECK(shown(segment::car_component(drawn({"#.", ".#"}))) == Rows{"#.", ".."});  // corners do not join
}

TEST_CASE("with a region the car is the piece with most pixels in it", "[segment][car_component]") {
  const auto mask = drawn({"######", "......", "#.##.#", "......"});
  CHECK(shown(segment::car_component(mask)) == Rows{"######", "......", "......", "......"});
  CHECK(shown(segment::car_component(mask, segment::Region{1, 1, 5, 4})) ==
        Rows{"......", "......", "..##..", "......"});
  // One pixel each, by their centres: the larger of the two wins.
  CHECK(shown(segment::car_component(mask, segment::Region{2.5, 0, 3.6, 4})) ==
        Rows{"######", "......", "......", "......"});
  CHECK(shown(segment::car_component(mask, segment::Region{-9, 1.5, 1, 99})) ==
        Rows{"......", "......", "#.....", "......"});  // at the edge, and a region that leaves the picture
  // No piece in the region, or an empty region: no car, though there are pieces.
  for (const segment::Region none :
       {segment::Region{0, 3, 6, 4}, segment::Region{2, 2, 2, 2}, segment::Region{7, 7, 9, 9},
        segment::Region{0, 0, std::numeric_limits<double>::quiet_NaN(), 4}})
    CHECK(shown(segment::car_component(mask, none)) == Rows(4, "......"));
}

TEST_CASE("of equal pieces the first, row by row, is the car", "[segment][car_component]") {
  CHECK(shown(segment::car_component(drawn({"...#", "##.#", "...."}))) == Rows{"...#", "...#", "...."});
  CHECK(shown(segment::car_component(drawn({"#.#"}), segment::Region{0, 0, 3, 1})) == Rows{"#.."});
}

TEST_CASE("a mask without a car has no piece", "[segment][car_component]") {
  CHECK(shown(segment::car_component(drawn({"..", ".."}))) == Rows{"..", ".."});
  CHECK(segment::car_component(drawn({})).size() == 0);
  const float none = std::numeric_limits<float>::quiet_NaN();
  Array<float, 2> broken = drawn({"#.#", "###"});
  broken(1, 1) = none;  // cuts the piece in two
  CHECK(shown(segment::car_component(broken)) == Rows{"#..", "#.."});
  broken.fill(none);
  CHECK(shown(segment::car_component(broken)) == Rows{"...", "..."});
}

TEST_CASE("a piece that fills a large picture is found without recursion", "[segment][car_component]") {
  Array<float, 2> mask({1500, 1500});
  mask.fill(1);
  const auto chosen = segment::car_component(mask);
  CHECK(std::count(chosen.data(), chosen.data() + chosen.size(), 1) == 1500 * 1500);
}

TEST_CASE("overlap of masks counts what is not zero", "[segment][car_component]") {
  const auto a = segment::car_component(drawn({"###.", "...."}));
  auto b = segment::car_component(drawn({".###", "...."}));
  CHECK(segment::mask_iou(a, a) == 1.0);
  CHECK(segment::mask_iou(a, b) == 0.5);
  b.fill(0);
  CHECK(segment::mask_iou(a, b) == 0.0);
  CHECK(segment::mask_iou(b, b) == 1.0);
  CHECK_THROWS_WITH(segment::mask_iou(a, Array<std::uint8_t, 2>({3, 4})),
                    "mask_iou: b is [3, 4], expected [2, 4]");
}
