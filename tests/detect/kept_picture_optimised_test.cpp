#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/io/darknet/model_file.hpp>

#include "../support/active_tape.hpp"
#include "../support/kept_pass.hpp"
#include "../support/random_model.hpp"

using namespace tapestry;
using namespace tapestry::test;
using image::PixelWindow;

namespace {
template <class T>
detect::Detector<T> random_detector(const std::string& name, std::size_t size) {
  return test::random_model<T>(io::parse_network_config(test::cfg_text(name), "some.cfg"), 1, size)
      .detector();
}

/// A picture is repainted within a window three times; each time logits and adjoint must be a whole pass's.
template <class T>
void require_same_bits(const detect::Detector<T>& detector, const PixelWindow& window, detect::Mode mode,
                       std::uint64_t seed) {
  INFO("window " << window.height << "x" << window.width << " at " << window.top << ", " << window.left);
  Random random(seed);
  auto images = random_array<T>({1, detector.input_height(), detector.input_width(), 3}, seed);
  detect::KeptPicture<T> kept(window);
  detect::Pass<T> kept_pass, whole_pass;
  for (int step = 0; step < 3; ++step) {
    repaint(images, 0, window, random);
    detector.forward_within(images, {&kept}, kept_pass, mode);
    detector.forward(images, whole_pass, mode);
    REQUIRE(differences(kept_pass.logits, whole_pass.logits) == 0);
    if (mode == detect::Mode::input_gradient)
      REQUIRE(adjoint_differences(detector, kept_pass, whole_pass, {window}, random) == 0);
  }
}

std::vector<PixelWindow> windows_in(std::size_t height, std::size_t width) {
  std::vector<PixelWindow> windows{{0, 0, height, width},
                                   {0, 0, 1, 1},
                                   {height - 1, width - 1, 1, 1},
                                   {height / 2 + 1, width / 2 - 2, 1, 1},
                                   {height / 3, width / 3, 0, 0},
                                   {height, width, 0, 0},
                                   {0, width / 3, height / 4, width / 5},
                                   {height / 3, 0, height / 5, width},
                                   {height - 7, width - 9, 7, 9}};
  Random random(6);
  for (int i = 0; i < 4; ++i) {
    const std::size_t top = random.index(height), left = random.index(width);
    windows.push_back({top, left, 1 + random.index(std::min(height - top, height / 4)),
                       1 + random.index(std::min(width - left, width / 4))});
  }
  return windows;
}
}  // namespace

TEMPLATE_TEST_CASE("a picture that changes within a window has the bits of a whole pass",
                   "[detect][kept][long]", float, double) {
  const auto engine = GENERATE(nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2,
                               nn::Engine::winograd_f4, nn::Engine::bfloat16);
  const auto mode = GENERATE(detect::Mode::input_gradient, detect::Mode::inference);
  constexpr std::size_t side = std::is_same_v<TestType, float> ? 224 : 96;  // double has no vector kernels
  auto detector = random_detector<TestType>("window_layers", side);
  detector.set_engine(engine);
  for (const auto& window : windows_in(side, side)) require_same_bits(detector, window, mode, 2);
}

TEMPLATE_TEST_CASE("whatever the layers, a window has the bits of a whole pass", "[detect][kept]", float,
                   double) {
  const std::string name =
      GENERATE(as<std::string>(), "every_layer", "unequal_shortcuts", "fused_layers", "more_activations",
               "product_layers", "region_layers", "strided_shortcuts", "real_layers", "wide_layers",
               "common_layers", "relatives_layers");
  INFO(name);
  const auto detector = random_detector<TestType>(name, 64);
  for (const auto& window : windows_in(64, 64))
    require_same_bits(detector, window, detect::Mode::input_gradient, 3);
}

TEST_CASE("whatever the activation, a window has the bits of a whole pass", "[detect][kept]") {
  auto config = io::parse_network_config(test::cfg_text("window_layers"), "some.cfg");
  const auto activation = GENERATE(from_range(nn::activations));
  CAPTURE(nn::name_of(activation));
  for (auto& layer : config.layers) layer.activation = activation;
  const auto detector = test::random_model<float>(config, 1, 96).detector();
  for (const auto& window : windows_in(96, 96))
    require_same_bits(detector, window, detect::Mode::input_gradient, 3);
}

TEST_CASE("what a window does not reach is taken from what was kept", "[detect][kept]") {
  const auto detector = random_detector<float>("window_layers", 224);
  const PixelWindow window{90, 100, 20, 30};
  auto images = random_array<float>({1, 224, 224, 3}, 2);
  detect::KeptPicture<float> kept(window);
  CHECK(kept.bytes() == 0);
  detect::Pass<float> pass;
  detector.forward_within(images, {&kept}, pass);
  const auto before = pass.logits;
  // Less than the picture: rings, not whole maps.
  CHECK(kept.bytes() > 0);
  CHECK(kept.bytes() < images.size() * sizeof(float));
  for (auto& ring : kept.values().rings)
    for (std::size_t i = 0; i < ring.size(); ++i) ring.data()[i] += 1;
  detector.forward_within(images, {&kept}, pass);
  CHECK(differences(pass.logits, before) > 0);
}

TEST_CASE("the share of products that a window leaves out is what its layers need not compute",
          "[detect][kept]") {
  const auto model = test::random_model<float>(
      io::parse_classifier_config("[net]\nwidth=32\nheight=32\n"
                                  "[convolutional]\nfilters=8\nsize=3\npad=1\nactivation=mish\n"
                                  "[convolutional]\nfilters=4\nsize=3\nstride=2\npad=1\nactivation=linear\n",
                                  "some.cfg"),
      1);
  auto detector = model.detector();
  detector.set_engine(nn::Engine::direct);
  // 4 x 4 pixels reach 6 x 6 of the first layer, of 9 · 3 · 8 products each, and rows and columns 4 to 7 of
  // the second, whose row y reads rows 2y − 1 to 2y + 1, of 9 · 8 · 4 products.
  const double all = 32 * 32 * 9 * 3 * 8 + 16 * 16 * 9 * 8 * 4,
               planned = 6 * 6 * 9 * 3 * 8 + 4 * 4 * 9 * 8 * 4;
  CHECK(detector.share_kept({10, 10, 4, 4}) == Approx(1 - planned / all).epsilon(1e-14));
  CHECK(detector.share_kept({0, 0, 32, 32}) == 0);
  CHECK_THROWS_AS(detector.share_kept({30, 0, 3, 1}), ShapeError);
}

TEST_CASE("everything is computed again when the rest of a picture, weights, mode or engine have changed",
          "[detect][kept]") {
  auto detector = random_detector<float>("window_layers", 224);
  const PixelWindow window{90, 100, 20, 30};
  auto images = random_array<float>({1, 224, 224, 3}, 2);
  detect::KeptPicture<float> kept(window);
  detect::Pass<float> pass, whole;
  auto mode = detect::Mode::inference;
  const auto require_same = [&] {
    detector.forward_within(images, {&kept}, pass, mode);
    detector.forward(images, whole, mode);
    REQUIRE(differences(pass.logits, whole.logits) == 0);
  };
  require_same();
  images(0, 89, 100, 0) += 1;
  require_same();
  images(0, 0, 0, 2) = std::numeric_limits<float>::quiet_NaN();
  require_same();
  images(0, 0, 0, 2) = 0;
  require_same();
  for (const std::size_t x : std::initializer_list<std::size_t>{40, 43, 46, 48})
    images(0, 3, x, 0) *= -1;  // signs alone, some 32 bytes apart
  require_same();
  std::swap(images(0, 200, 0, 0), images(0, 200, 8, 0));
  require_same();
  auto weights = detector.weights();
  weights[7] += 1;
  detector.set_weights(weights);
  require_same();
  detector.set_engine(nn::Engine::direct);
  require_same();
  mode = detect::Mode::input_gradient;
  require_same();
  mode = detect::Mode::training;
  detector.forward_within(images, {&kept}, pass, mode);
  auto gradient = tapestry::zeros<float, 1>({weights.size()});
  detector.pull_back(pass, {pass.logits.data(), nullptr}, nullptr, &gradient);  // of everything
  const auto other = random_detector<float>("window_layers", 256);
  images = random_array<float>({1, 256, 256, 3}, 2);
  mode = detect::Mode::input_gradient;
  other.forward_within(images, {&kept}, pass, mode);
  other.forward(images, whole, mode);
  CHECK(differences(pass.logits, whole.logits) == 0);
}

TEST_CASE("values that are not finite reach as far in a window as in a whole pass", "[detect][kept]") {
  const auto detector = random_detector<float>("window_layers", 224);
  const PixelWindow window{60, 33, 12, 9};
  auto images = random_array<float>({1, 224, 224, 3}, 2);
  detect::KeptPicture<float> kept(window);
  detect::Pass<float> pass, whole;
  for (const float value : {1.0F, std::numeric_limits<float>::quiet_NaN(), 1e38F,
                            -std::numeric_limits<float>::infinity(), 1e-42F}) {
    images(0, 63, 35, 1) = value;
    detector.forward_within(images, {&kept}, pass, detect::Mode::input_gradient);
    detector.forward(images, whole, detect::Mode::input_gradient);
    CHECK(differences(pass.logits, whole.logits) == 0);
  }
}

TEST_CASE("each image of a batch has a window of its own, or none", "[detect][kept]") {
  const auto detector = random_detector<float>("window_layers", 224);
  const std::vector<PixelWindow> windows{{90, 100, 20, 30}, {0, 0, 224, 224}, {200, 3, 11, 50}};
  auto images = random_array<float>({3, 224, 224, 3}, 2);
  detect::KeptPicture<float> first(windows[0]), last(windows[2]);
  const std::vector<detect::KeptPicture<float>*> kept{&first, nullptr, &last};
  detect::Pass<float> pass, whole;
  Random random(4);
  for (int step = 0; step < 2; ++step) {
    for (std::size_t i = 0; i < 3; ++i) repaint(images, i, windows[i], random);
    detector.forward_within(images, kept, pass, detect::Mode::input_gradient);
    detector.forward(images, whole, detect::Mode::input_gradient);
    REQUIRE(differences(pass.logits, whole.logits) == 0);
    REQUIRE(adjoint_differences(detector, pass, whole, windows, random) == 0);
  }
}

TEST_CASE("a window is a record on the tape, as a whole pass is", "[detect][kept]") {
  const auto detector = random_detector<double>("window_layers", 224);
  const PixelWindow window{90, 100, 20, 30};
  auto images = random_array<double>({1, 224, 224, 3}, 2);
  detect::KeptPicture<double> kept(window);
  Random random(4);
  for (int step = 0; step < 2; ++step) {
    repaint(images, 0, window, random);
    std::vector<Array<double, 4>> gradients;
    for (const bool within : {true, false}) {
      ActiveTape<double> tape;
      const auto input = tape.input(images);
      const auto logits =
          within ? detect::forward_within(detector, input, {&kept}) : detect::forward(detector, input);
      tape.reverse(sum(logits[0] * logits[0]) + sum(exp(0.1 * logits[1])));
      gradients.push_back(input.adjoint());
    }
    std::size_t wrong = 0;
    for (std::size_t y = 0; y < 224; ++y)
      for (std::size_t x = 0; x < 224; ++x)
        if (is_inside(window, y, x) && gradients[0](0, y, x, 0) != gradients[1](0, y, x, 0)) ++wrong;
    CHECK(wrong == 0);
  }
}

TEST_CASE("windows outside of the picture and lists of another length are refused", "[detect][kept]") {
  const auto detector = random_detector<float>("two_convolutions", 32);
  const auto images = random_array<float>({2, 32, 32, 3}, 2);
  detect::KeptPicture<float> kept({0, 0, 4, 4}), outside({30, 0, 3, 1});
  detect::Pass<float> pass;
  CHECK_THROWS_WITH(detector.forward_within(images, {&kept}, pass),
                    "Detector::forward_within: 1 kept pictures for 2 images");
  CHECK_THROWS_AS(detector.forward_within(images, {&kept, &outside}, pass), ShapeError);
  detector.forward_within(images, {&kept, nullptr}, pass);
  auto gradient = tapestry::zeros<float, 4>({2, 32, 32, 3});
  CHECK_THROWS_AS(detector.input_adjoint(pass, pass.logits, gradient),
                  DomainError);  // kept nothing
  detect::Pass<float> other;
  detector.forward_within(images, {&kept, nullptr}, other, detect::Mode::input_gradient);
  CHECK_THROWS_AS(pass.copy_branches(other), DomainError);
}
