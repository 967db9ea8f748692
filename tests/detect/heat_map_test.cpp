#include <tapestry/detect/heat_map.hpp>

#include <tapestry/io/darknet/model_file.hpp>

#include "../support/finite_difference.hpp"
#include "../support/pointers_to.hpp"
#include "../support/random_model.hpp"
#include "../support/relative_distance.hpp"
#include "../support/small_exports.hpp"

using namespace tapestry;

namespace {
/// A pass, the surest candidate of class 1 and the adjoint of its score.
struct Explained {
  detect::Pass<double> pass;
  detect::BestCandidate best;
  std::vector<Array<double, 4>> adjoints;

  explicit Explained(const detect::Detector<double>& detector, std::size_t image = 1) {
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
    return test::dot(adjoints, other.logits);
  }
};
/// Two convolutions and a head of two anchors and two classes, on 2 × 2 cells.
const std::string darknet_cfg =
    "[net]\nwidth=16\nheight=16\n"
    "[convolutional]\nfilters=4\nsize=9\nstride=8\npad=1\nactivation=leaky\n"
    "[dropout]\nprobability=.5\n"
    "[convolutional]\nfilters=14\nsize=1\nactivation=linear\n"
    "[yolo]\nmask=0,1\nanchors=4,5, 9,8\nclasses=2\nnum=2\n";

detect::DarknetModel<double> darknet(const std::string& cfg) {
  return test::random_model<double>(io::parse_network_config(cfg, "some.cfg"), 1);
}

/// A detector that observes layers of the cfg.
detect::Detector<double> observing(const detect::DarknetModel<double>& model,
                                   const std::vector<std::size_t>& layers) {
  std::vector<std::string> names;
  for (const std::size_t layer : layers) names.push_back(model.value_name(layer));
  return model.detector(names);
}

std::string common_layer(const nn::NetworkDescription& network) {
  return detect::common_layer(network, detect::raw_outputs(network));
}
}  // namespace

TEST_CASE("the share of a heat map within a mask is its heat there over all of it", "[detect][heat_map]") {
  const Array<double, 2> heat = {{1.0, 3.0}, {0.0, 4.0}}, mask = {{1.0, 0.5}, {1.0, 0.0}};
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
  const Array<double, 3> values = {{{1.0, 2.0}}, {{3.0, -1.0}}}, adjoint = {{{0.5, -0.1}}, {{-1.0, 0.4}}};
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
  CHECK_THROWS_AS(detect::grad_cam(values, other), ShapeError);
}

TEST_CASE("a layer's adjoint adds up to the slope by its convolution's bias",
          "[detect][heat_map][gradient]") {
  const auto network = test::yolox_like(64);
  const std::string layer = network.nodes[4].outputs.front();  // the convolution of stride 8
  const detect::Detector<double> detector(network, detect::known_description("yolox"), 0, {layer});
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
      detect::Detector<double>(moved, detect::known_description("yolox"))
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
  const detect::Detector<double> detector(network, detect::known_description("yolox"), 0, layers);
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
  const detect::Detector<double> without(network, detect::known_description("yolox"));
  without.forward(test::pictures<double>(2, 64), plain);
  for (std::size_t h = 0; h < 3; ++h)
    CHECK(test::relative_distance(plain.logits[h], explained.pass.logits[h]) <= 1e-13);
}

TEST_CASE("a far candidate asks nothing of what it does not see", "[detect][heat_map]") {
  const auto network = test::yolox_like(64);
  const detect::Detector<double> detector(network, detect::known_description("yolox"), 0,
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
    CHECK(common_layer(network) == network.nodes[5].outputs.front());  // stride 8; 16 comes from it
  CHECK(common_layer({}).empty());
  const auto described = darknet(test::cfg_text("two_heads")).description();
  CHECK(detect::common_layer(described, described.outputs) == "layer_0");
}

TEST_CASE("layers that are not there or are no maps are refused", "[detect][heat_map][bad_input]") {
  const auto network = test::yolox_like(64);
  const auto with_layer = [&](const std::string& layer) {
    return detect::Detector<double>(network, detect::known_description("yolox"), 0, {layer});
  };
  CHECK_THROWS_WITH(with_layer("nowhere"), contains("no node makes the layer 'nowhere'"));
  CHECK_THROWS_WITH(with_layer(network.outputs.front()), contains("maps, [1, C, H, W]"));
  detect::Pass<double> pass;
  const auto detector = with_layer(network.nodes[5].outputs.front());
  detector.forward(test::pictures<double>(1, 64), pass);
  const std::vector<const Array<double, 4>*> none(3, nullptr);
  CHECK_THROWS_AS(detector.layer_adjoint(pass, none, 0, 0), DomainError);
}

TEST_CASE("a Darknet layer's values and adjoint equal their closed form", "[detect][heat_map]") {
  const auto model = darknet(darknet_cfg);
  const auto network = observing(model, {1, 0});  // a dropout only passes layer 0 on
  const auto described = model.description();
  CHECK(detect::common_layer(described, described.outputs) == "layer_0");
  detect::Pass<double> pass;
  network.forward(test::pictures<double>(3, 16), pass, detect::Mode::input_gradient);
  const detect::BestCandidate best{0, 1 * 4 + 2, 0.5};  // anchor 1, cell 2: the lower left one
  const std::size_t image = 2;
  const auto adjoints = detect::score_adjoint(network.heads(), pass.logits, image, 1, best);
  const auto values = network.layer_values(pass, 0, image);
  const auto adjoint = network.layer_adjoint(pass, test::pointers_to(adjoints), 0, image);
  REQUIRE(values.shape() == Extents<3>{4, 2, 2});
  // The head reads W · A + b, whose score is the sum of two rows: objectness and the class.
  const double* const weights = model.parameters().data() + model.layout().layers[2].weight;
  const double* const biases = model.parameters().data() + model.layout().layers[2].bias;
  const std::size_t objectness = 7 + 4, class_row = 7 + 5 + 1;
  double score = biases[objectness] + biases[class_row], heat = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    const double asked = weights[objectness * 4 + c] + weights[class_row * 4 + c];
    score += asked * values(c, 1, 0);
    heat += std::max(asked, 0.0) * values(c, 1, 0);
    for (std::size_t y = 0; y < 2; ++y)
      for (std::size_t x = 0; x < 2; ++x)
        CHECK(adjoint(c, y, x) == Approx(y == 1 && x == 0 ? asked : 0.0).margin(1e-15));
  }
  const auto& logits = pass.logits[0];
  CHECK(score == Approx(logits(image, objectness, 1, 0) + logits(image, class_row, 1, 0)).epsilon(1e-13));
  const auto map = detect::layer_cam(values, adjoint);
  for (std::size_t y = 0; y < 2; ++y)
    for (std::size_t x = 0; x < 2; ++x)
      CHECK(map(y, x) == Approx(y == 1 && x == 0 ? std::max(heat, 0.0) : 0.0).margin(1e-15));
  CHECK(test::relative_distance(network.layer_values(pass, 1, image), values) == 0);
  CHECK(test::relative_distance(network.layer_adjoint(pass, test::pointers_to(adjoints), 1, image),
                                adjoint) == 0);
}

TEST_CASE("adjoints of Darknet layers add up to the slope by their convolution's bias, and change nothing",
          "[detect][heat_map][gradient]") {
  const auto model = darknet(test::cfg_text(GENERATE("every_layer", "fused_layers", "two_heads")));
  std::vector<std::size_t> layers;
  for (std::size_t i = 0; i < model.config().layers.size(); ++i) layers.push_back(i);
  const auto plain = model.detector(), network = observing(model, layers);
  const auto images = test::pictures<double>(2, model.input_width());
  detect::Pass<double> pass, other;
  network.forward(images, pass, detect::Mode::input_gradient);
  plain.forward(images, other, detect::Mode::input_gradient);
  std::vector<Array<double, 4>> adjoints;
  for (std::size_t h = 0; h < pass.logits.size(); ++h) {
    CHECK(test::relative_distance(pass.logits[h], other.logits[h]) == 0);
    const auto shape = pass.logits[h].shape();
    adjoints.push_back(test::random_array<double>({shape[0], shape[1], shape[2], shape[3]}, 5 + h));
  }
  auto gradient = tapestry::zeros<double, 4>(images.shape()), expected = gradient;
  network.input_adjoint(pass, adjoints, gradient);
  plain.input_adjoint(other, adjoints, expected);
  CHECK(test::relative_distance(gradient, expected) == 0);

  std::size_t checked = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const auto& layer = model.config().layers[i];
    const bool is_known = layer.activation == nn::Activation::linear ||
                          layer.activation == nn::Activation::leaky ||
                          layer.activation == nn::Activation::logistic;
    if (layer.kind != detect::LayerKind::convolutional || !is_known) continue;
    const std::size_t channel = i % layer.filters;
    double sum = 0;
    for (std::size_t image = 0; image < 2; ++image) {
      const auto values = network.layer_values(pass, i, image);
      const auto asked = network.layer_adjoint(pass, test::pointers_to(adjoints), i, image);
      const std::size_t pixels = values.shape(1) * values.shape(2);
      for (std::size_t p = channel * pixels; p < (channel + 1) * pixels; ++p) {
        const double a = values.data()[p];
        const double slope = layer.activation == nn::Activation::linear  ? 1
                             : layer.activation == nn::Activation::leaky ? (a > 0 ? 1 : 0.1)
                                                                         : a * (1 - a);
        sum += slope * asked.data()[p];
      }
    }
    const auto logits_with = [&](double step) {
      auto moved = model;
      moved.parameters()[moved.layout().layers[i].bias + channel] += step;
      return detect::forward(moved.detector(), images);
    };
    const double step = 1e-6;
    const auto ahead = logits_with(step), behind = logits_with(-step);
    double slope = 0;  // of differences, which are small: a sum of whole logits would round away their digits
    for (std::size_t h = 0; h < adjoints.size(); ++h)
      for (std::size_t k = 0; k < adjoints[h].size(); ++k)
        slope += adjoints[h].data()[k] * (ahead[h].data()[k] - behind[h].data()[k]) / (2 * step);
    INFO("layer " << i << ": " << sum << " " << slope);
    CHECK(std::abs(sum - slope) <= 1e-7 * std::abs(slope) + 1e-8);
    ++checked;
  }
  CHECK(checked >= 2);
}

namespace {
/// Distance of pull_back_layer() from the slopes of weights · layer by the pictures, along one direction.
template <class Detector>
void check_pull_back_layer(const Detector& detector, std::size_t layer, std::size_t side) {
  const auto images = test::pictures<double>(2, side);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  const auto shape = detector.layer_values(pass, layer, 1).shape();
  const auto weights = test::random_array<double>({shape[0], shape[1], shape[2]}, 7, -1, 1);
  auto gradient = tapestry::zeros<double, 4>(images.shape());
  for (int half = 0; half < 2; ++half) {  // two halves make a whole only if it adds
    const Array<double, 3> of_half = weights / 2.0;
    detector.pull_back_layer(pass, layer, 1, of_half, gradient);
  }
  for (std::size_t i = 0; i < gradient.size() / 2; ++i) REQUIRE(gradient.data()[i] == 0);  // the other image
  const auto direction = test::random_array<double>({2, side, side, 3}, 8, -1, 1);
  const auto values_at = [&](double step) {
    const Array<double, 4> moved = images + step * direction;
    detector.forward(moved, pass, detect::Mode::input_gradient);
    return detector.layer_values(pass, layer, 1);
  };
  const double step = 1e-7;  // short, since every leaky unit within it is a kink
  const auto ahead = values_at(step), behind = values_at(-step);
  double slope = 0;
  const double expected = test::dot(gradient, direction);
  for (std::size_t i = 0; i < weights.size(); ++i)
    slope += weights.data()[i] * (ahead.data()[i] - behind.data()[i]) / (2 * step);
  INFO("layer " << layer << ": " << expected << " " << slope);
  CHECK(std::abs(expected - slope) <= 1e-6 * std::max(1.0, std::abs(slope)));
}
}  // namespace

TEST_CASE("what a layer asks of the pictures agrees with central differences",
          "[detect][heat_map][gradient]") {
  SECTION("of a graph") {
    const auto network = test::yolox_like(64);
    const detect::Detector<double> detector(network, detect::known_description("yolox"), 0,
                                            {network.nodes[4].outputs.front()});
    check_pull_back_layer(detector, 0, 64);
    detect::Pass<double> none;
    auto gradient = tapestry::zeros<double, 4>({1, 64, 64, 3});
    detector.forward(test::pictures<double>(1, 64), none);
    const auto adjoint = tapestry::zeros<double, 3>({8, 8, 8});
    CHECK_THROWS_AS(detector.pull_back_layer(none, 0, 0, adjoint, gradient), DomainError);
  }
  SECTION("of a Darknet network") {
    const std::string cfg = test::cfg_text(GENERATE("every_layer", "fused_layers", "two_heads"));
    const auto model = darknet(cfg);
    for (std::size_t i = 0; i < model.config().layers.size(); ++i) {
      if (model.config().layers[i].kind != detect::LayerKind::convolutional) continue;
      check_pull_back_layer(observing(model, {i}), 0, model.input_width());
    }
  }
  SECTION("and is refused what does not fit") {
    const auto network = observing(darknet(darknet_cfg), {0});
    detect::Pass<double> pass;
    network.forward(test::pictures<double>(1, 16), pass);
    auto gradient = tapestry::zeros<double, 4>({1, 16, 16, 3});
    const auto adjoint = tapestry::zeros<double, 3>({4, 2, 2});
    CHECK_THROWS_AS(network.pull_back_layer(pass, 0, 0, adjoint, gradient), DomainError);
    network.forward(test::pictures<double>(1, 16), pass, detect::Mode::input_gradient);
    CHECK_THROWS_AS(network.pull_back_layer(pass, 1, 0, adjoint, gradient), DomainError);
    CHECK_THROWS_AS(network.pull_back_layer(pass, 0, 1, adjoint, gradient), DomainError);
    CHECK_THROWS_WITH(network.pull_back_layer(pass, 0, 0, tapestry::zeros<double, 3>({4, 2, 3}), gradient),
                      "Detector::pull_back_layer: layer_adjoint is [4, 2, 3], expected [4, 2, 2]");
  }
}

TEST_CASE("Darknet layers that cannot be observed are refused", "[detect][heat_map][bad_input]") {
  const auto model = darknet(darknet_cfg);
  CHECK_THROWS_WITH(model.value_name(4), contains("layer 4 cannot be observed"));
  const std::string dropped = "[net]\nwidth=16\nheight=16\n[dropout]\n" + darknet_cfg.substr(25);
  CHECK_THROWS_WITH(darknet(dropped).value_name(0), contains("layer 0 cannot be observed"));
  const auto network = observing(model, {0});
  detect::Pass<double> pass;
  network.forward(test::pictures<double>(1, 16), pass);
  const std::vector<const Array<double, 4>*> none(1, nullptr);
  CHECK_THROWS_AS(network.layer_values(pass, 0, 0), DomainError);
  CHECK_THROWS_AS(network.layer_adjoint(pass, none, 0, 0), DomainError);
  network.forward(test::pictures<double>(1, 16), pass, detect::Mode::input_gradient);
  CHECK_THROWS_AS(network.layer_values(pass, 1, 0), DomainError);
  CHECK_THROWS_AS(network.layer_values(pass, 0, 1), DomainError);
  const auto asked = network.layer_adjoint(pass, none, 0, 0);
  CHECK(std::ranges::all_of(asked.storage(), [](double value) { return value == 0; }));
}
