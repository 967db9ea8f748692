#include <tapestry/evaluate/meter.hpp>
#include <tapestry/image/batch.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
/// A view of the tiny car, and a network whose random weights find all sorts of things in it.
struct Fixture {
  raster::PaintedMesh car = test::tiny_car();
  detect::Detector<float> network = test::tiny_detector<float>();
  camouflage::ViewStore<float> store = test::tiny_store<float>(car, 3);

  /// The detections of detector programs, with a threshold of confidence alone.
  [[nodiscard]] std::vector<detect::Detection> detections(const Array<float, 3>& picture, double confidence) {
    return detect::suppress(all_detections(picture, confidence), 0.45);
  }
  [[nodiscard]] std::vector<detect::Detection> all_detections(const Array<float, 3>& picture,
                                                              double confidence) const {
    const auto logits = detect::forward(network, image::batch_of(picture));
    return detect::decode(network.heads(), logits, 0, confidence, 48, 48);
  }
};
}  // namespace

TEST_CASE("a meter's sweep finds what a detector with each threshold finds", "[evaluate][meter][repeated]") {
  Fixture fixture;
  const std::vector<double> sweep{0.05, 0.2, 0.3, 0.9};
  evaluate::Meter meter(fixture.network, 1, {0.25, 0.45, sweep});
  std::size_t counts = 0;
  for (std::size_t i = 0; i < fixture.store.size(); ++i) {
    auto view = *fixture.store.view(i);
    std::vector<std::vector<detect::Detection>> detections;
    for (const double threshold : sweep) detections.push_back(fixture.detections(view.background, threshold));
    const auto usual = fixture.detections(view.background, 0.25);
    REQUIRE(!detections[0].empty());
    for (const detect::Detection& wanted : detections[0]) {  // each in turn is the wanted box
      if (wanted.class_index != 1) continue;
      view.target = wanted.box;
      const auto result = meter.examine(view.background, view);
      CHECK(result.found == meter.shows_car(usual, view.target));
      for (std::size_t k = 0; k < sweep.size(); ++k) {
        const bool found = meter.shows_car(detections[k], view.target);
        CHECK((result.found_confidence > sweep[k]) == found);
        counts += found ? 1 : 0;
      }
      CHECK(result.found_confidence > sweep[0]);
    }
  }
  CHECK(counts > 0);
}

TEST_CASE("a meter tells the best confidence of the car below any threshold", "[evaluate][meter]") {
  Fixture fixture;
  evaluate::Meter strict(fixture.network, 1, {0.9, 0.45, {}});
  std::size_t counts = 0;
  for (std::size_t i = 0; i < fixture.store.size(); ++i) {
    auto view = *fixture.store.view(i);
    const auto all = fixture.all_detections(view.background, 0);
    view.target = all[all.size() / 2].box;
    double expected = 0;
    for (const auto& found : all)
      if (found.class_index == 1 && detect::iou(found.box, view.target) >= 0.5)
        expected = std::max(expected, found.confidence);
    const auto result = strict.examine(view.background, view);
    CHECK(result.best_confidence == expected);
    CHECK(!result.found);
    counts += expected > 0 && expected < 0.9 ? 1U : 0U;
  }
  CHECK(counts > 0);
}

TEST_CASE("a meter's detections are those above its confidence, the most confident first",
          "[evaluate][meter]") {
  Fixture fixture;
  const auto view = fixture.store.view(0);
  evaluate::Meter meter(fixture.network, 0, {0.25, 0.45, {0.01}});
  const auto result = meter.examine(view->background, *view);
  const auto expected = fixture.detections(view->background, 0.25);
  REQUIRE(result.detections.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(result.detections[i].confidence == expected[i].confidence);
    CHECK(result.detections[i].candidate == expected[i].candidate);
  }
}

TEST_CASE("a meter refuses outputs that are not finite, naming the view", "[evaluate][meter]") {
  Fixture fixture;
  test::spoil(fixture.network);
  evaluate::Meter meter(fixture.network, 0);
  const auto view = fixture.store.view(0);
  CHECK_THROWS_AS(meter.examine(view->background, *view), NumericError);
  CHECK_THROWS_WITH(meter.examine(view->background, *view), contains("frame0: output 0"));
}

TEST_CASE("a meter refuses a class that the network does not have", "[evaluate][meter]") {
  Fixture fixture;
  CHECK_THROWS_WITH(evaluate::Meter(fixture.network, 2), "Meter: class 2 of a network with 2 classes");
}
