#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/io/darknet/model_file.hpp>

#include "../support/finite_difference.hpp"
#include "../support/pointers_to.hpp"
#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/relative_distance.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using test::dot, test::fourth_order_difference, test::pointers_to, test::random_array,
    test::relative_distance;

namespace {
const std::string every_layer = test::cfg_text("every_layer");
const std::string unequal_layers = test::cfg_text("unequal_shortcuts");
const std::string fused_layers = test::cfg_text("fused_layers");
const std::string more_activations = test::cfg_text("more_activations");
const std::string product_layers = test::cfg_text("product_layers");
/// The same with kinks.
std::string leaky(std::string cfg) {
  for (const std::string smooth : {"mish", "swish"})
    for (auto at = cfg.find(smooth); at != std::string::npos; at = cfg.find(smooth))
      cfg.replace(at, smooth.size(), "leaky");
  return cfg;
}
const std::string leaky_products = leaky(product_layers);
const std::string region_layers = test::cfg_text("region_layers");
const std::string strided_shortcuts = test::cfg_text("strided_shortcuts");
const std::string real_layers = test::cfg_text("real_layers");
const std::string grouped_layers = test::cfg_text("grouped_layers");
const std::string wide_layers = test::cfg_text("wide_layers");

template <class T>
detect::DarknetModel<T> random_model(const std::string& cfg) {
  return test::random_model<T>(io::parse_network_config(cfg, "some.cfg"), 1);
}

template <class T>
std::vector<Array<T, 4>> random_like(const std::vector<Array<T, 4>>& arrays, std::uint64_t seed) {
  std::vector<Array<T, 4>> result = arrays;
  Random random(seed);
  for (auto& array : result)
    for (auto& value : array.storage()) value = static_cast<T>(random.uniform(-1, 1));
  return result;
}

/// Rounding of f, a sum of some hundred terms, is below 1e-12 and divided by the step.
const double step_length = 1e-4;
const double rounding = 1e-8;
}  // namespace

TEST_CASE("the input gradient agrees with central differences", "[detect][darknet_model][gradient]") {
  const auto model = random_model<double>(
      GENERATE(every_layer, unequal_layers, region_layers, product_layers, strided_shortcuts));
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  for (const auto mode : {detect::Mode::input_gradient, detect::Mode::training}) {
    const auto detector = mode == detect::Mode::training ? model.learning_detector() : model.detector();
    detect::Pass<double> pass;
    detector.forward(images, pass, mode);
    const auto adjoint = random_like(pass.logits, 3);
    auto gradient = tapestry::zeros<double, 4>({2, 16, 16, 3});
    for (int half = 0; half < 2; ++half) detector.input_adjoint(pass, adjoint, gradient);  // adjoints add
    Random random(4);
    for (int trial = 0; trial < 12; ++trial) {
      const std::size_t i = random.index(images.size());
      const auto value = [&](double step) {
        auto moved = images;
        moved.data()[i] += step;
        detect::Pass<double> other;
        detector.forward(moved, other, mode);
        return dot(other.logits, adjoint);
      };
      CHECK(gradient.data()[i] / 2 ==
            Approx(fourth_order_difference(value, step_length)).epsilon(1e-7).margin(rounding));
    }
  }
}

TEST_CASE("what convolutions do beside their sums agrees with central differences and with one pass each",
          "[detect][darknet_model][gradient]") {
  const auto detector =
      random_model<double>(GENERATE(fused_layers, grouped_layers, leaky_products, more_activations))
          .detector();
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  CHECK(relative_distance(detect::forward(detector, images)[0], pass.logits[0]) == 0);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<double, 4>({2, 16, 16, 3});
  detector.input_adjoint(pass, adjoint, gradient);
  Random random(4);
  for (int trial = 0; trial < 24; ++trial) {
    const std::size_t i = random.index(images.size());
    const auto value = [&](double step) {
      auto moved = images;
      moved.data()[i] += step;
      return dot(detect::forward(detector, moved), adjoint);
    };
    constexpr double step = 1e-6;  // linear between kinks; rounding of the sum is 1e-14 / step
    CHECK(gradient.data()[i] == Approx((value(step) - value(-step)) / (2 * step)).epsilon(1e-6).margin(1e-7));
  }
}

TEST_CASE("the parameter gradient agrees with central differences", "[detect][darknet_model][gradient]") {
  const auto model = random_model<double>(
      GENERATE(every_layer, unequal_layers, region_layers, product_layers, strided_shortcuts));
  const bool batch_statistics = GENERATE(true, false);
  auto detector = model.learning_detector(batch_statistics);
  const auto images = random_array<double>({3, 16, 16, 3}, 2);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::training);
  const auto adjoint = random_like(pass.logits, 3);
  const auto weights = detector.weights();
  auto gradient = tapestry::zeros<double, 1>({weights.size()});
  for (int half = 0; half < 2; ++half) detector.pull_back(pass, pointers_to(adjoint), nullptr, &gradient);
  std::size_t learning = 0;
  for (const auto& block : model.layout().blocks)
    learning += detect::is_running_statistic(block.role) ? 0 : 1;
  REQUIRE(detector.network().weight_blocks().size() == learning);
  Random random(4);
  for (const auto& block : detector.network().weight_blocks()) {
    const std::size_t i = block.offset + random.index(nn::size_of(block.shape));
    const auto value = [&](double step) {
      auto moved = weights;
      moved[i] += step;
      detector.set_weights(moved);
      detect::Pass<double> other;
      detector.forward(images, other, detect::Mode::training);
      return dot(other.logits, adjoint);
    };
    CAPTURE(block.name, batch_statistics);
    CHECK(gradient[i] / 2 ==
          Approx(fourth_order_difference(value, step_length)).epsilon(1e-7).margin(rounding));
  }
}

TEST_CASE("float follows double", "[detect][darknet_model]") {
  const auto model = random_model<double>(real_layers);
  const auto images = random_array<double>({2, 32, 32, 3}, 2);
  const auto detector = model.detector();
  const auto single = model.cast<float>().detector();
  detect::Pass<double> pass;
  detect::Pass<float> single_pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  single.forward(tapestry::cast<float>(images), single_pass, detect::Mode::input_gradient);
  const auto adjoint = random_like(pass.logits, 3);
  std::vector<Array<float, 4>> single_adjoint;
  for (std::size_t h = 0; h < 2; ++h) {
    CHECK(relative_distance(single_pass.logits[h], pass.logits[h]) < 2e-6);
    single_adjoint.push_back(tapestry::cast<float>(adjoint[h]));
  }
  auto gradient = tapestry::zeros<double, 4>({2, 32, 32, 3});
  auto single_gradient = tapestry::zeros<float, 4>({2, 32, 32, 3});
  detector.input_adjoint(pass, adjoint, gradient);
  single.input_adjoint(single_pass, single_adjoint, single_gradient);
  CHECK(relative_distance(single_gradient, gradient) < 3e-6);
}

TEST_CASE("with the kinks of the float pass every engine's gradient follows double",
          "[detect][darknet_model]") {
  const auto model = random_model<double>(wide_layers);
  const auto images = random_array<double>({2, 64, 64, 3}, 2);
  const auto detector = model.detector();
  auto single = model.cast<float>().detector();
  const auto engine =
      GENERATE(nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2, nn::Engine::winograd_f4);
  single.set_engine(engine);
  CAPTURE(nn::name_of(engine));
  detect::Pass<double> pass;
  detect::Pass<float> single_pass;
  detector.forward(images, pass, detect::Mode::input_gradient);
  single.forward(tapestry::cast<float>(images), single_pass, detect::Mode::input_gradient);
  CHECK(relative_distance(single_pass.logits[0], pass.logits[0]) < 2e-6);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<double, 4>({2, 64, 64, 3});
  auto single_gradient = tapestry::zeros<float, 4>({2, 64, 64, 3});
  pass.copy_branches(single_pass);
  detector.input_adjoint(pass, adjoint, gradient);
  single.input_adjoint(single_pass, {tapestry::cast<float>(adjoint[0])}, single_gradient);
  CHECK(relative_distance(single_gradient, gradient) < 3e-6);

  detect::Pass<double> inference;
  detector.forward(images, inference);
  CHECK_THROWS_AS(inference.copy_branches(single_pass), DomainError);
}

TEST_CASE("in bfloat16 logits stay within 1e-2, the gradient at the same kinks within 2e-2",
          "[detect][darknet_model]") {
  auto detector = random_model<float>(wide_layers).detector();
  const auto images = random_array<float>({2, 64, 64, 3}, 2);
  detect::Pass<float> pass, rounded;
  detector.forward(images, pass, detect::Mode::input_gradient);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<float, 4>({2, 64, 64, 3});
  auto rounded_gradient = gradient;
  detector.input_adjoint(pass, adjoint, gradient);
  detector.set_engine(nn::Engine::bfloat16);
  detector.forward(images, rounded, detect::Mode::input_gradient);
  rounded.copy_branches(pass);
  detector.input_adjoint(rounded, adjoint, rounded_gradient);
  const double logits_error = relative_distance(rounded.logits[0], pass.logits[0]);
  const double gradient_error = relative_distance(rounded_gradient, gradient);
  CAPTURE(logits_error, gradient_error);
  CHECK(logits_error < 1e-2);
  CHECK(gradient_error < 2e-2);
  CHECK(std::min(logits_error, gradient_error) > 1e-4);  // they are rounded at all
}

TEST_CASE("a model's detector, which borrows its parameters, has the bits of one made of copies",
          "[detect][darknet_model]") {
  const auto model = random_model<float>(GENERATE(every_layer, wide_layers, grouped_layers));
  const detect::Detector<float> borrowing = model.detector(), copying(model.description(), model.heads());
  CHECK(std::ranges::equal(borrowing.network().weights(), copying.network().weights()));
}

TEST_CASE("one and more threads, and any batch, give the same bits", "[detect][darknet_model]") {
  const auto model = random_model<float>(GENERATE(real_layers, wide_layers)).resized(32, 32);
  auto detector = model.detector(), learning = model.learning_detector();
  const auto engine = GENERATE(nn::Engine::automatic, nn::Engine::winograd_f4, nn::Engine::bfloat16);
  detector.set_engine(engine);
  learning.set_engine(engine);
  const auto images = random_array<float>({7, 32, 32, 3}, 2);
  test::same_by_threads({1, 2, 3, 8}, [&] {
    detect::Pass<float> pass;
    learning.forward(images, pass, detect::Mode::training);
    const auto adjoint = random_like(pass.logits, 3);
    auto gradient = tapestry::zeros<float, 4>({7, 32, 32, 3});
    auto weights_adjoint = tapestry::zeros<float, 1>({learning.weights().size()});
    learning.pull_back(pass, pointers_to(adjoint), &gradient, &weights_adjoint);
    return std::tuple(pass.logits, gradient, weights_adjoint);
  });

  const auto all = detect::forward(detector, images);
  detect::Pass<float> single;
  for (std::size_t n = 0; n < 7; ++n) {
    Array<float, 4> image({1, 32, 32, 3});
    std::copy_n(images.data() + n * image.size(), image.size(), image.data());
    detector.forward(image, single);  // the pass is used again
    for (std::size_t h = 0; h < all.size(); ++h)
      CHECK(std::equal(single.logits[h].data(), single.logits[h].data() + single.logits[h].size(),
                       all[h].data() + n * single.logits[h].size()));
  }
}

TEST_CASE("inference and gradient passes give the same logits", "[detect][darknet_model]") {
  const auto detector = random_model<float>(every_layer).detector();
  const auto images = random_array<float>({1, 16, 16, 3}, 2);
  detect::Pass<float> gradient;
  detector.forward(images, gradient, detect::Mode::input_gradient);
  CHECK(detect::forward(detector, images) == gradient.logits);
}

TEST_CASE("running statistics of one batch reproduce the training pass", "[detect][darknet_model]") {
  auto model = random_model<double>(real_layers);
  const auto images = random_array<double>({4, 32, 32, 3}, 2);
  detect::Pass<double> training;
  model.learning_detector().forward(images, training, detect::Mode::training);
  model.update_running_statistics(training, 1);  // take the batch's own
  const auto inference = detect::forward(model.detector(), images);
  // The running variance is unbiased: n/(n−1) with n = 4·8·8 in the smallest normalised layer.
  CHECK(relative_distance(inference[0], training.logits[0]) < 1.0 / (4 * 8 * 8 - 1));
}

TEST_CASE("NaN and infinity in a picture stay visible", "[detect][darknet_model]") {
  const auto detector = random_model<float>(every_layer).detector();
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    auto images = random_array<float>({1, 16, 16, 3}, 2);
    images(0, 7, 7, 1) = bad;
    const auto logits = detect::forward(detector, images)[1];
    CHECK(std::ranges::any_of(logits.storage(), [](float x) { return !std::isfinite(x); }));
  }
}

TEST_CASE("a model takes over what its detector has learnt, and keeps running statistics",
          "[detect][darknet_model]") {
  auto model = random_model<float>(real_layers);
  const auto before = model.parameters();
  auto detector = model.learning_detector();
  detector.set_weights(Array<float, 1>(2.F * detector.weights()));
  model.take_weights(detector);
  for (const auto& block : model.layout().blocks)
    for (std::size_t i = block.offset; i < block.offset + block.count; ++i)
      REQUIRE(model.parameters()[i] == (detect::is_running_statistic(block.role) ? 1 : 2) * before[i]);
}

TEST_CASE("a network of one pixel works", "[detect][darknet_model]") {
  const std::string cfg =
      "[net]\nwidth=1\nheight=1\n[convolutional]\nfilters=255\nsize=3\npad=1\nactivation=leaky\n[maxpool]"
      "\nsize=2\n"
      "stride=1\n[convolutional]\nfilters=7\nactivation=linear\n[yolo]\nclasses=2\nanchors=1,1\n";
  const auto detector = random_model<double>(cfg).learning_detector();
  const auto images = random_array<double>({1, 1, 1, 3}, 2);
  detect::Pass<double> pass;
  detector.forward(images, pass, detect::Mode::training);
  CHECK(pass.logits[0].shape() == Extents<4>{1, 7, 1, 1});
  auto gradient = tapestry::zeros<double, 1>({detector.weights().size()});
  detector.pull_back(pass, pointers_to(pass.logits), nullptr, &gradient);
  CHECK(std::all_of(gradient.begin(), gradient.end(), [](double x) { return std::isfinite(x); }));
}

TEST_CASE("a network names the arguments that do not fit", "[detect][darknet_model]") {  // T21
  auto model = random_model<float>(real_layers);
  const auto detector = model.detector();
  detect::Pass<float> pass;
  CHECK_THROWS_WITH(detector.forward(tapestry::zeros<float, 4>({0, 32, 32, 3}), pass),
                    "Detector::forward: a batch of no images");
  CHECK_THROWS_WITH(detector.forward(tapestry::zeros<float, 4>({1, 32, 64, 3}), pass),
                    "Detector::forward: images is [1, 32, 64, 3], expected [1, 32, 32, 3]");
  const auto images = random_array<float>({1, 32, 32, 3}, 2);
  detector.forward(images, pass);
  auto gradient = tapestry::zeros<float, 4>({1, 32, 32, 3});
  auto weights_adjoint = tapestry::zeros<float, 1>({detector.weights().size()});
  CHECK_THROWS_AS(detector.input_adjoint(pass, pass.logits, gradient), DomainError);
  detector.forward(images, pass, detect::Mode::input_gradient);
  CHECK_THROWS_AS(detector.input_adjoint(pass, {}, gradient), ShapeError);
  CHECK_THROWS_AS(detector.pull_back(pass, pointers_to(pass.logits), nullptr, &weights_adjoint), DomainError);
  CHECK_THROWS_AS(model.update_running_statistics(pass), DomainError);
  detector.forward(images, pass, detect::Mode::training);  // with running statistics
  CHECK_THROWS_AS(model.update_running_statistics(pass), DomainError);
  CHECK_THROWS_AS(model.resized(30, 32), FileError);
  CHECK(model.resized(64, 96).heads()[0].grid_width == 24);
}
