#include <tapestry/detect/heat_map.hpp>

#include <cmath>
#include <string>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/recognised_detector.hpp>
#include <variant>
#include <vector>

#include "../support/catch.hpp"
#include "../support/relative_distance.hpp"
#include "../support/small_exports.hpp"

namespace detect = tapestry::detect;
namespace nn = tapestry::nn;
namespace test = tapestry::test;
using tapestry::Array;

namespace {
/// A pass, the surest candidate of class 1 and the adjoint of its score.
struct Explained {
  detect::Pass<double> pass;
  detect::BestCandidate best;
  std::vector<Array<double, 4>> adjoints;

  explicit Explained(const detect::GraphDetector<double>& detector, std::size_t image = 1) {
    detector.forward(test::pictures<double>(2, 64), pass, detect::Mode::input_gradient);
    best = detect::best_candidate<double>(
               detector.heads(), {&pass.logits[0], &pass.logits[1], &pass.logits[2]}, image, {1}, 64, 64)
               .value();
    adjoints = detect::score_adjoint(detector.heads(), pass.logits, image, 1, best);
  }
  [[nodiscard]] std::vector<const Array<double, 4>*> pointers() const {
    return {&adjoints[0], &adjoints[1], &adjoints[2]};
  }
  /// The score itself, of the same candidate in another pass.
  [[nodiscard]] double score_of(const detect::Pass<double>& other) const {
    double sum = 0;
    for (std::size_t h = 0; h < adjoints.size(); ++h)
      for (std::size_t i = 0; i < adjoints[h].size(); ++i)
        sum += adjoints[h].data()[i] * other.logits[h].data()[i];
    return sum;
  }
};
}  // namespace

TEST_CASE("the share of a heat map within a mask is its heat there over all of it", "[detect][heat_map]") {
  const Array<double, 2> heat = {{1.0, 3.0}, {0.0, 4.0}};
  const Array<double, 2> mask = {{1.0, 0.5}, {1.0, 0.0}};
  CHECK(detect::share_within(heat, mask) == 2.5 / 8);
  const Array<double, 2> even = {{2.0, 2.0}, {2.0, 2.0}};
  CHECK(detect::share_within(even, mask) == 2.5 / 4);  // the mask's area
  CHECK(detect::share_within(heat, Array<double, 2>{{1.0, 1.0}, {1.0, 1.0}}) == 1.0);
  CHECK(!detect::share_within(Array<double, 2>{{0.0, 0.0}, {0.0, 0.0}}, mask));
  CHECK(!detect::share_within(Array<double, 2>{{std::nan(""), 0.0}, {0.0, 0.0}}, mask));
  CHECK_THROWS_WITH(detect::share_within(heat, Array<double, 2>{{1.0, 1.0}}),
                    "share_within: mask is [1, 2], expected [2, 2]");
}

TEST_CASE("heat maps equal what is worked out by hand", "[detect][heat_map]") {
  const Array<double, 3> values = {{{1.0, 2.0}}, {{3.0, -1.0}}};
  const Array<double, 3> adjoint = {{{0.5, -0.1}}, {{-1.0, 0.4}}};
  const auto plain = detect::grad_cam(values, adjoint);  // means .2 and −.3
  CHECK(plain(0, 0) == 0);                               // .2 − .9
  CHECK(plain(0, 1) == Approx(0.4 + 0.3));
  const auto plus = detect::grad_cam_plus_plus(values, adjoint);
  const double first = 0.5 / (2 + 3 * 0.5), second = 0.4 / (2 + 2 * 0.4);
  CHECK(plus(0, 0) == Approx(first + 3 * second));
  CHECK(plus(0, 1) == Approx(2 * first - second));
  const auto layer = detect::layer_cam(values, adjoint);
  CHECK(layer(0, 0) == Approx(0.5));
  CHECK(layer(0, 1) == 0);  // −.4
  const Array<double, 3> other = {{{0.5, -0.1}}};
  CHECK_THROWS_AS(detect::grad_cam(values, other), tapestry::ShapeError);
}

TEST_CASE("a layer's adjoint adds up to the slope by its convolution's bias",
          "[detect][heat_map][gradient]") {
  const auto network = test::yolox_like(64);
  const std::string layer = network.nodes[4].outputs.front();  // the convolution of stride 8
  const detect::GraphDetector<double> detector(network, detect::known_description("yolox"), 0, {layer});
  REQUIRE(detector.layer_shape(0) == nn::Shape{1, 8, 8, 8});
  Explained explained(detector);
  const auto adjoint = detector.layer_adjoint(explained.pass, explained.pointers(), 0, 1);
  for (const std::size_t channel : {std::size_t(0), std::size_t(5)}) {
    const auto score_with = [&](double step) {
      auto moved = network;
      auto& bias = moved.constants.at(network.nodes[4].inputs[2]);
      const auto& single = std::get<std::vector<float>>(bias.values);
      std::vector<double> exact(single.begin(), single.end());
      exact[channel] += step;
      bias.values = exact;
      detect::Pass<double> pass;
      detect::GraphDetector<double>(moved, detect::known_description("yolox"))
          .forward(test::pictures<double>(2, 64), pass);
      return explained.score_of(pass);
    };
    double sum = 0;
    for (std::size_t i = 0; i < 64; ++i) sum += adjoint.data()[channel * 64 + i];
    const double slope = (score_with(1e-5) - score_with(-1e-5)) / 2e-5;
    INFO(sum << " " << slope);
    CHECK(std::abs(slope) > 1e-4);
    CHECK(std::abs(sum - slope) <= 1e-6 * std::abs(slope) + 1e-9);
  }
}

TEST_CASE("layers before and behind an activation agree by its slope, and change no logit",
          "[detect][heat_map][gradient]") {
  const auto network = test::yolox_like(64);
  const std::vector<std::string> layers{network.nodes[4].outputs.front(), network.nodes[5].outputs.front()};
  const detect::GraphDetector<double> detector(network, detect::known_description("yolox"), 0, layers);
  Explained explained(detector, 0);
  const auto before = detector.layer_adjoint(explained.pass, explained.pointers(), 0, 0);
  const auto behind = detector.layer_adjoint(explained.pass, explained.pointers(), 1, 0);
  const auto values = detector.layer_values(explained.pass, 1, 0);
  double asked = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double a = values.data()[i];
    asked += std::abs(before.data()[i]);
    CHECK(before.data()[i] == Approx(behind.data()[i] * a * (1 - a)).margin(1e-14));
  }
  CHECK(asked > 0);
  detect::Pass<double> plain;
  const detect::GraphDetector<double> without(network, detect::known_description("yolox"));
  without.forward(test::pictures<double>(2, 64), plain);
  for (std::size_t h = 0; h < 3; ++h)
    CHECK(test::relative_distance(plain.logits[h], explained.pass.logits[h]) <= 1e-13);
}

TEST_CASE("a far candidate asks nothing of what it does not see", "[detect][heat_map]") {
  const auto network = test::yolox_like(64);
  const detect::GraphDetector<double> detector(network, detect::known_description("yolox"), 0,
                                               {network.nodes[5].outputs.front()});
  Explained explained(detector);
  explained.best = {0, 0, 1};  // the upper left cell of stride 8, through one convolution of 3 × 3
  explained.adjoints = detect::score_adjoint(detector.heads(), explained.pass.logits, 1, 1, explained.best);
  const auto adjoint = detector.layer_adjoint(explained.pass, explained.pointers(), 0, 1);
  double near = 0, far = 0;
  for (std::size_t c = 0; c < 8; ++c)
    for (std::size_t y = 0; y < 8; ++y)
      for (std::size_t x = 0; x < 8; ++x) (y < 2 && x < 2 ? near : far) += std::abs(adjoint(c, y, x));
  CHECK(near > 0);
  CHECK(far == 0);
}

TEST_CASE("the common layer is the last one that all heads see", "[detect][heat_map]") {
  for (const auto& network : {test::yolox_like(64), test::nanodet_like(64)})
    CHECK(detect::common_layer(network) == network.nodes[5].outputs.front());  // stride 8; 16 comes from it
  CHECK(detect::common_layer({}).empty());
}

TEST_CASE("layers that are not there or are no maps are refused", "[detect][heat_map][bad_input]") {
  const auto network = test::yolox_like(64);
  const auto with_layer = [&](const std::string& layer) {
    return detect::GraphDetector<double>(network, detect::known_description("yolox"), 0, {layer});
  };
  CHECK_THROWS_WITH(with_layer("nowhere"), Catch::Contains("no node makes the layer 'nowhere'"));
  CHECK_THROWS_WITH(with_layer(network.outputs.front()), Catch::Contains("maps, [1, C, H, W]"));
  detect::Pass<double> pass;
  const auto detector = with_layer(network.nodes[5].outputs.front());
  detector.forward(test::pictures<double>(1, 64), pass);
  const std::vector<const Array<double, 4>*> none(3, nullptr);
  CHECK_THROWS_AS(detector.layer_adjoint(pass, none, 0, 0), tapestry::DomainError);
}
