#include <tapestry/evaluate/views.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;
using evaluate::OcclusionGroup;

namespace {
const std::vector<OcclusionGroup> groups{OcclusionGroup::small, OcclusionGroup::middle,
                                         OcclusionGroup::large};

camouflage::View<float> car_view(double distance = 5) {
  auto car = test::tiny_car();
  car.mesh = geometry::normalise_mesh(std::move(car.mesh));
  return evaluate::protocol_view({distance, 20, 40, 0, 0}, car, {48, 48, 4, {}, {1, 1, 1}});
}

/// The hidden share pixel by pixel of the whole picture.
double brute_force_share(const camouflage::View<float>& view,
                         const std::vector<evaluate::Occluder>& occluders) {
  double hidden = 0, total = 0;
  for (std::size_t y = 0; y < view.window.height; ++y)
    for (std::size_t x = 0; x < view.window.width; ++x) {
      const auto share = static_cast<double>(view.paint_to_picture->coverage(y, x));
      total += share;
      const std::size_t row = y + view.window.top, column = x + view.window.left;
      if (std::any_of(occluders.begin(), occluders.end(), [&](const evaluate::Occluder& occluder) {
            const auto& window = occluder.window;
            return row >= window.top && row - window.top < window.height && column >= window.left &&
                   column - window.left < window.width;
          }))
        hidden += share;
    }
  return hidden / total;
}
}  // namespace

TEST_CASE("groups end where the paper says", "[evaluate][occlusion]") {
  CHECK(evaluate::occlusion_group(0) == OcclusionGroup::small);
  CHECK(evaluate::occlusion_group(0.3) == OcclusionGroup::small);
  CHECK(evaluate::occlusion_group(0.31) == OcclusionGroup::middle);
  CHECK(evaluate::occlusion_group(0.69) == OcclusionGroup::middle);
  CHECK(evaluate::occlusion_group(0.7) == OcclusionGroup::large);
  CHECK(evaluate::occlusion_group(1) == OcclusionGroup::large);
}

TEST_CASE("the hidden share is the hidden part of the silhouette", "[evaluate][occlusion]") {
  const auto view = car_view();
  REQUIRE(view.visible_pixels > 50);
  for (const auto group : groups)
    for (std::uint64_t seed = 0; seed < 40; ++seed) {
      const auto occlusion =
          evaluate::draw_occlusion(view.paint_to_picture->coverage, view.window, 48, 48, group, Random(seed));
      REQUIRE(occlusion);
      CHECK(evaluate::occlusion_group(occlusion->hidden_share) == group);
      CHECK(occlusion->hidden_share == Approx(brute_force_share(view, occlusion->occluders)).epsilon(1e-12));
      CHECK(occlusion->hidden_share >= 0.05);
      CHECK(occlusion->hidden_share <= 0.95);
    }
}

TEST_CASE("overlapping rectangles hide a pixel once, and those beside the car nothing",
          "[evaluate][occlusion]") {
  const Array<float, 2> coverage = {{1, 1, 0}, {0.5F, 1, 0.5F}};
  evaluate::HiddenPixels hidden(coverage, {10, 20, 2, 3});  // rows 10 and 11, columns 20 to 22
  CHECK(hidden.share() == 0);
  hidden.hide({0, 0, 11, 21});  // the first pixel, by its lower right corner
  CHECK(hidden.share() == 0.25);
  hidden.hide({10, 20, 1, 2});  // this pixel again, and the next
  CHECK(hidden.share() == 0.5);
  hidden.hide({12, 20, 5, 5});
  hidden.hide({10, 23, 2, 9});
  CHECK(hidden.share() == 0.5);
  CHECK(hidden.gain_of({9, 19, 9, 9}) == 2);
  CHECK(hidden.share() == 0.5);
  hidden.hide({9, 19, 9, 9});
  CHECK(hidden.share() == 1);
  CHECK_THROWS_AS(evaluate::HiddenPixels(coverage, {0, 0, 3, 3}), ShapeError);
}

TEST_CASE("the same seed draws the same rectangles, another seed others", "[evaluate][occlusion]") {
  const auto view = car_view();
  const auto draw = [&](std::uint64_t seed) {
    return evaluate::draw_occlusion(view.paint_to_picture->coverage, view.window, 48, 48,
                                    OcclusionGroup::middle, Random(seed));
  };
  REQUIRE((draw(3) && draw(4)));
  CHECK(draw(3)->hidden_share == draw(3)->hidden_share);
  CHECK(draw(3)->occluders.front().window == draw(3)->occluders.front().window);
  CHECK(draw(3)->hidden_share != draw(4)->hidden_share);
}

TEST_CASE("a car that does not show, or in one pixel, cannot be hidden in part", "[evaluate][occlusion]") {
  const Random random(1);
  CHECK(!evaluate::draw_occlusion(tapestry::zeros<float, 2>({0, 0}), {0, 0, 0, 0}, 48, 48,
                                  OcclusionGroup::small, random));
  CHECK(!evaluate::draw_occlusion(tapestry::zeros<float, 2>({4, 4}), {3, 3, 4, 4}, 48, 48,
                                  OcclusionGroup::large, random));
  const auto pixel = tapestry::filled<float, 2>({1, 1}, 1.0F);
  for (const auto group : groups)
    CHECK(!evaluate::draw_occlusion(pixel, {5, 5, 1, 1}, 48, 48, group, random));
  CHECK_THROWS_AS(evaluate::draw_occlusion(pixel, {48, 5, 1, 1}, 48, 48, OcclusionGroup::small, random),
                  ShapeError);
}

TEST_CASE("rectangles are painted over the picture and nowhere else", "[evaluate][occlusion]") {
  auto picture = tapestry::filled<float, 3>({6, 6, 3}, 0.125F);
  const evaluate::Occluder plain{{1, 1, 2, 4}, {1, 0, 0}, {0, 1, 0}, 0, 0};
  const evaluate::Occluder squares{{2, 2, 4, 4}, {0, 0, 1}, {0, 1, 0}, 1, 2};
  evaluate::lay_occluders(picture, {plain, squares});
  for (std::size_t y = 0; y < 6; ++y)
    for (std::size_t x = 0; x < 6; ++x) {
      const bool in_squares = y >= 2 && x >= 2, in_plain = y >= 1 && y < 3 && x >= 1 && x < 5;
      const bool odd = ((x - 2) % 2 != 0) != ((y - 2) / 2 % 2 != 0);
      CHECK(picture(y, x, 0) == (in_squares ? 0 : in_plain ? 1 : 0.125F));
      CHECK(picture(y, x, 1) == (in_squares ? (odd ? 1 : 0) : in_plain ? 0 : 0.125F));
    }
  CHECK_THROWS_AS(evaluate::lay_occluders(picture, {{{0, 0, 7, 1}, {}, {}, 0, 0}}), ShapeError);
}

TEST_CASE("each group and distance has 90 frames, the same views in every group", "[evaluate][occlusion]") {
  const auto grid = evaluate::occlusion_grid();
  const auto frames = evaluate::occlusion_frames(grid);
  const auto table = evaluate::occlusion_table(grid);
  REQUIRE(frames.size() == 1080);
  std::vector<std::size_t> counts(table.cell_count());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    ++counts[table.cell_of(frames[i])];
    CHECK(frames[i].azimuth_deg == frames[i % 360].azimuth_deg);
    CHECK(frames[i].distance == frames[i % 360].distance);
  }
  CHECK(counts == std::vector<std::size_t>(12, 90));
  CHECK(evaluate::occlusion_frames(evaluate::quick_occlusion_grid()).size() == 216);
}
