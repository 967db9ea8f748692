#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

TEST_CASE("views that do not show the car are left out with a warning", "[camouflage][usable_views]") {
  const auto car = test::tiny_car();
  auto store = test::tiny_store<float>(car, 3, {48, 48, 2}, [](std::size_t i) {
    auto frame = test::tiny_frame(i);
    if (i == 1) frame.mask = tapestry::zeros<std::uint8_t, 2>({48, 48});  // wholly hidden
    return frame;
  });
  std::vector<std::string> visited;
  const auto usable = camouflage::usable_views(
      store, [&](const camouflage::View<float>& view) { visited.push_back(view.name); });
  CHECK(usable.indices == std::vector<std::size_t>{0, 2});
  CHECK(usable.warnings == std::vector<std::string>{"frame frame1 does not show the car and is left out"});
  CHECK(visited == std::vector<std::string>{"frame0", "frame1", "frame2"});
  CHECK(camouflage::usable_views(store).indices == usable.indices);
}

TEST_CASE("a view that was kept has the bits of one that is made anew", "[camouflage][view_store]") {
  const auto car = test::tiny_car();
  for (const std::size_t side : {48U, 40U}) {  // as the frames are, kept as bytes; and fitted
    const auto store_with = [&](std::size_t keep_bytes) {
      return test::tiny_store<float>(car, 1, {side, side, 2, keep_bytes},
                                     [](std::size_t) { return test::tiny_frame(1); });
    };
    auto keeping = store_with(1U << 30U), forgetting = store_with(0);
    for (int again = 0; again < 3; ++again) {
      const auto kept = keeping.view(0), made = forgetting.view(0);
      CHECK(kept->background == made->background);
      CHECK(kept->background.shape(0) == side);
      CHECK(kept->paint_to_picture->weights == made->paint_to_picture->weights);
      CHECK(*kept->interior == *made->interior);
      CHECK(kept->visible_pixels == made->visible_pixels);
    }
    keeping.for_each(
        [&](std::size_t, const auto& view) { CHECK(view.background == forgetting.view(0)->background); });
  }
}
