#include <tapestry/camouflage/usable_views.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

namespace camouflage = tapestry::camouflage;
namespace test = tapestry::test;

TEST_CASE("views that do not show the car are left out with a warning", "[camouflage][usable_views]") {
  const auto car = test::tiny_car();
  std::vector<camouflage::ViewStore<float>::Loader> loaders;
  for (std::size_t i = 0; i < 3; ++i) {
    loaders.push_back([i] {
      auto frame = test::tiny_frame(i);
      if (i == 1) frame.mask = tapestry::zeros<std::uint8_t, 2>({48, 48});  // wholly hidden
      return frame;
    });
  }
  camouflage::ViewStore<float> store(car, {48, 48, 2}, loaders);
  std::vector<std::string> visited;
  const auto usable = camouflage::usable_views(
      store, [&](const camouflage::View<float>& view) { visited.push_back(view.name); });
  CHECK(usable.indices == std::vector<std::size_t>{0, 2});
  CHECK(usable.warnings == std::vector<std::string>{"frame frame1 does not show the car and is left out"});
  CHECK(visited == std::vector<std::string>{"frame0", "frame1", "frame2"});
  CHECK(camouflage::usable_views(store).indices == usable.indices);
}
