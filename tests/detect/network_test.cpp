#include <tapestry/detect/network.hpp>
#include <tapestry/io/darknet/cfg_file.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "../support/catch.hpp"
#include "../support/cfg_text.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/random_detector.hpp"
#include "../support/relative_distance.hpp"

namespace detect = tapestry::detect;
namespace io = tapestry::io;
namespace nn = tapestry::nn;
using tapestry::Array;
using tapestry::test::random_array;
using tapestry::test::relative_distance;

namespace {
const std::string every_layer = tapestry::test::cfg_text("every_layer");
const std::string unequal_layers = tapestry::test::cfg_text("unequal_shortcuts");
const std::string fused_layers = tapestry::test::cfg_text("fused_layers");
const std::string more_activations = tapestry::test::cfg_text("more_activations");
const std::string product_layers = tapestry::test::cfg_text("product_layers");
/// The same with kinks.
std::string leaky(std::string cfg) {
  for (const std::string smooth : {"mish", "swish"})
    for (auto at = cfg.find(smooth); at != std::string::npos; at = cfg.find(smooth))
      cfg.replace(at, smooth.size(), "leaky");
  return cfg;
}
const std::string leaky_products = leaky(product_layers);
const std::string region_layers = tapestry::test::cfg_text("region_layers");
const std::string strided_shortcuts = tapestry::test::cfg_text("strided_shortcuts");
const std::string real_layers = tapestry::test::cfg_text("real_layers");
const std::string grouped_layers = R"(# Groups of channels that are no whole vectors, and whole ones.
[net]
width=16
height=16
[convolutional]
filters=32
size=1
activation=leaky
[convolutional]
filters=48
groups=16
size=3
pad=1
activation=leaky
[convolutional]
filters=32
groups=2
size=3
stride=2
pad=1
activation=relu
[convolutional]
filters=14
size=1
activation=linear
[yolo]
mask=0,1
anchors=4,5, 9,8
classes=2
num=2
)";
const std::string wide_layers = tapestry::test::cfg_text("wide_layers");

template <class T>
detect::Network<T> random_network(const std::string& cfg) {
  return tapestry::test::random_detector<T>(io::parse_network_config(cfg, "some.cfg"), 1);
}

template <class T>
std::vector<Array<T, 4>> random_like(const std::vector<Array<T, 4>>& arrays, std::uint64_t seed) {
  std::vector<Array<T, 4>> result = arrays;
  tapestry::Random random(seed);
  for (auto& array : result)
    for (auto& value : array.storage()) value = static_cast<T>(random.uniform(-1, 1));
  return result;
}

double dot(const std::vector<Array<double, 4>>& a, const std::vector<Array<double, 4>>& b) {
  double sum = 0;
  for (std::size_t h = 0; h < a.size(); ++h) sum += tapestry::test::dot(a[h], b[h]);
  return sum;
}

template <class T>
std::vector<T> flat(const Array<T, 4>& array) {
  return {array.data(), array.data() + array.size()};
}

/// Rounding of f, a sum of some hundred terms, is below 1e-12 and divided by the step.
const double step_length = 1e-4;
const double rounding = 1e-8;

/// Fourth-order central difference of f at 0, of a function of the step.
template <class Function>
double central_difference(Function f, double h) {
  return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}
}  // namespace

TEST_CASE("the input gradient agrees with central differences", "[detect][network][gradient]") {
  const auto network = random_network<double>(
      GENERATE(every_layer, unequal_layers, region_layers, product_layers, strided_shortcuts));
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  for (const auto mode : {detect::Mode::input_gradient, detect::Mode::training}) {
    detect::Pass<double> pass;
    network.forward(images, pass, mode);
    const auto adjoint = random_like(pass.logits, 3);
    auto gradient = tapestry::zeros<double, 4>({2, 16, 16, 3});
    for (int half = 0; half < 2; ++half) network.input_adjoint(pass, adjoint, gradient);  // adjoints add
    tapestry::Random random(4);
    for (int trial = 0; trial < 12; ++trial) {
      const std::size_t i = random.index(images.size());
      const auto value = [&](double step) {
        auto moved = images;
        moved.data()[i] += step;
        detect::Pass<double> other;
        network.forward(moved, other, mode);
        return dot(other.logits, adjoint);
      };
      CHECK(gradient.data()[i] / 2 ==
            Approx(central_difference(value, step_length)).epsilon(1e-7).margin(rounding));
    }
  }
}

TEST_CASE("what convolutions do beside their sums agrees with central differences and with one pass each",
          "[detect][network][gradient]") {
  const auto network =
      random_network<double>(GENERATE(fused_layers, grouped_layers, leaky_products, more_activations));
  const auto images = random_array<double>({2, 16, 16, 3}, 2);
  detect::Pass<double> pass;
  network.forward(images, pass, detect::Mode::input_gradient);
  detect::Pass<double> inference;
  network.forward(images, inference, detect::Mode::inference);
  CHECK(relative_distance(inference.logits[0], pass.logits[0]) == 0);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<double, 4>({2, 16, 16, 3});
  network.input_adjoint(pass, adjoint, gradient);
  tapestry::Random random(4);
  for (int trial = 0; trial < 24; ++trial) {
    const std::size_t i = random.index(images.size());
    const auto value = [&](double step) {
      auto moved = images;
      moved.data()[i] += step;
      detect::Pass<double> other;
      network.forward(moved, other, detect::Mode::inference);
      return dot(other.logits, adjoint);
    };
    constexpr double step = 1e-6;  // linear between kinks; rounding of the sum is 1e-14 / step
    CHECK(gradient.data()[i] == Approx((value(step) - value(-step)) / (2 * step)).epsilon(1e-6).margin(1e-7));
  }
}

TEST_CASE("the parameter gradient agrees with central differences", "[detect][network][gradient]") {
  auto network = random_network<double>(
      GENERATE(every_layer, unequal_layers, region_layers, product_layers, strided_shortcuts));
  const auto images = random_array<double>({3, 16, 16, 3}, 2);
  detect::Pass<double> pass;
  network.forward(images, pass, detect::Mode::training);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<double, 1>({network.parameters().size()});
  for (int half = 0; half < 2; ++half) network.parameter_adjoint(pass, adjoint, gradient);
  tapestry::Random random(4);
  for (const auto& block : network.layout().blocks) {
    const std::size_t i = block.offset + random.index(block.count);
    const double kept = network.parameters()[i];
    const auto value = [&](double step) {
      network.parameters()[i] = kept + step;
      detect::Pass<double> other;
      network.forward(images, other, detect::Mode::training);
      return dot(other.logits, adjoint);
    };
    CAPTURE(block.layer, static_cast<int>(block.role));
    CHECK(gradient[i] / 2 == Approx(central_difference(value, step_length)).epsilon(1e-7).margin(rounding));
    network.parameters()[i] = kept;
  }
}

TEST_CASE("float follows double", "[detect][network]") {
  const auto network = random_network<double>(real_layers);
  const auto images = random_array<double>({2, 32, 32, 3}, 2);
  const auto single = network.cast<float>();
  detect::Pass<double> pass;
  detect::Pass<float> single_pass;
  network.forward(images, pass, detect::Mode::input_gradient);
  single.forward(tapestry::cast<float>(images), single_pass, detect::Mode::input_gradient);
  const auto adjoint = random_like(pass.logits, 3);
  std::vector<Array<float, 4>> single_adjoint;
  for (std::size_t h = 0; h < 2; ++h) {
    CHECK(relative_distance(single_pass.logits[h], pass.logits[h]) < 2e-6);
    single_adjoint.push_back(tapestry::cast<float>(adjoint[h]));
  }
  auto gradient = tapestry::zeros<double, 4>({2, 32, 32, 3});
  auto single_gradient = tapestry::zeros<float, 4>({2, 32, 32, 3});
  network.input_adjoint(pass, adjoint, gradient);
  single.input_adjoint(single_pass, single_adjoint, single_gradient);
  CHECK(relative_distance(single_gradient, gradient) < 3e-6);
}

TEST_CASE("with the kinks of the float pass every engine's gradient follows double", "[detect][network]") {
  const auto network = random_network<double>(wide_layers);
  const auto images = random_array<double>({2, 64, 64, 3}, 2);
  auto single = network.cast<float>();
  single.set_engine(
      GENERATE(nn::Engine::automatic, nn::Engine::direct, nn::Engine::winograd_f2, nn::Engine::winograd_f4));
  CAPTURE(nn::name_of(single.engine()));
  detect::Pass<double> pass;
  detect::Pass<float> single_pass;
  network.forward(images, pass, detect::Mode::input_gradient);
  single.forward(tapestry::cast<float>(images), single_pass, detect::Mode::input_gradient);
  CHECK(relative_distance(single_pass.logits[0], pass.logits[0]) < 2e-6);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<double, 4>({2, 64, 64, 3});
  auto single_gradient = tapestry::zeros<float, 4>({2, 64, 64, 3});
  pass.take_kinks(single_pass);
  network.input_adjoint(pass, adjoint, gradient);
  single.input_adjoint(single_pass, {tapestry::cast<float>(adjoint[0])}, single_gradient);
  CHECK(relative_distance(single_gradient, gradient) < 3e-6);

  detect::Pass<double> inference;
  network.forward(images, inference);
  CHECK_THROWS_AS(inference.take_kinks(single_pass), tapestry::DomainError);
}

TEST_CASE("in bfloat16 logits stay within 1e-2, the gradient at the same kinks within 2e-2",
          "[detect][network]") {
  auto network = random_network<float>(wide_layers);
  const auto images = random_array<float>({2, 64, 64, 3}, 2);
  detect::Pass<float> pass, rounded;
  network.forward(images, pass, detect::Mode::input_gradient);
  const auto adjoint = random_like(pass.logits, 3);
  auto gradient = tapestry::zeros<float, 4>({2, 64, 64, 3});
  auto rounded_gradient = gradient;
  network.input_adjoint(pass, adjoint, gradient);
  network.set_engine(nn::Engine::bfloat16);
  network.forward(images, rounded, detect::Mode::input_gradient);
  rounded.take_kinks(pass);
  network.input_adjoint(rounded, adjoint, rounded_gradient);
  const double logits_error = relative_distance(rounded.logits[0], pass.logits[0]);
  const double gradient_error = relative_distance(rounded_gradient, gradient);
  CAPTURE(logits_error, gradient_error);
  CHECK(logits_error < 1e-2);
  CHECK(gradient_error < 2e-2);
  CHECK(std::min(logits_error, gradient_error) > 1e-4);  // they are rounded at all
}

TEST_CASE("one and more threads, and any batch, give the same bits", "[detect][network]") {
  auto network = random_network<float>(GENERATE(real_layers, wide_layers));
  network.set_engine(GENERATE(nn::Engine::automatic, nn::Engine::winograd_f4, nn::Engine::bfloat16));
  network = network.resized(32, 32);
  const auto images = random_array<float>({7, 32, 32, 3}, 2);
  const auto run = [&](int threads) {
    tapestry::limit_threads(threads);
    detect::Pass<float> pass;
    network.forward(images, pass, detect::Mode::training);
    const auto adjoint = random_like(pass.logits, 3);
    auto gradient = tapestry::zeros<float, 4>({7, 32, 32, 3});
    auto parameters_adjoint = tapestry::zeros<float, 1>({network.parameters().size()});
    network.input_adjoint(pass, adjoint, gradient);
    network.parameter_adjoint(pass, adjoint, parameters_adjoint);
    auto bits = flat(gradient);
    bits.insert(bits.end(), parameters_adjoint.begin(), parameters_adjoint.end());
    for (const auto& logits : pass.logits)
      bits.insert(bits.end(), logits.data(), logits.data() + logits.size());
    return bits;
  };
  const int threads = tapestry::thread_count();
  const auto one = run(1);
  CHECK(one == run(2));
  CHECK(one == run(3));
  CHECK(one == run(8));
  tapestry::limit_threads(threads);

  detect::Pass<float> all;
  detect::Pass<float> single;
  network.forward(images, all);
  for (std::size_t n = 0; n < 7; ++n) {
    Array<float, 4> image({1, 32, 32, 3});
    std::copy_n(images.data() + n * image.size(), image.size(), image.data());
    network.forward(image, single);  // the pass is used again
    for (std::size_t h = 0; h < all.logits.size(); ++h)
      CHECK(std::equal(single.logits[h].data(), single.logits[h].data() + single.logits[h].size(),
                       all.logits[h].data() + n * single.logits[h].size()));
  }
}

TEST_CASE("inference and gradient passes give the same logits", "[detect][network]") {
  const auto network = random_network<float>(every_layer);
  const auto images = random_array<float>({1, 16, 16, 3}, 2);
  detect::Pass<float> inference;
  detect::Pass<float> gradient;
  network.forward(images, inference);
  network.forward(images, gradient, detect::Mode::input_gradient);
  for (std::size_t h = 0; h < 2; ++h) CHECK(flat(inference.logits[h]) == flat(gradient.logits[h]));
}

TEST_CASE("running statistics of one batch reproduce the training pass", "[detect][network]") {
  auto network = random_network<double>(real_layers);
  const auto images = random_array<double>({4, 32, 32, 3}, 2);
  detect::Pass<double> training;
  network.forward(images, training, detect::Mode::training);
  network.update_running_statistics(training, 1);  // take the batch's own
  detect::Pass<double> inference;
  network.forward(images, inference);
  // The running variance is unbiased: n/(n−1) with n = 4·8·8 in the smallest normalised layer.
  CHECK(relative_distance(inference.logits[0], training.logits[0]) < 1.0 / (4 * 8 * 8 - 1));
}

TEST_CASE("NaN and infinity in a picture stay visible", "[detect][network]") {
  const auto network = random_network<float>(every_layer);
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    auto images = random_array<float>({1, 16, 16, 3}, 2);
    images(0, 7, 7, 1) = bad;
    detect::Pass<float> pass;
    network.forward(images, pass);
    const auto logits = flat(pass.logits[1]);
    CHECK(std::any_of(logits.begin(), logits.end(), [](float x) { return !std::isfinite(x); }));
  }
}

TEST_CASE("parameters that change are noticed by the next pass", "[detect][network]") {
  auto network = random_network<float>(real_layers);
  const auto images = random_array<float>({1, 32, 32, 3}, 2);
  auto& parameters = network.parameters();
  detect::Pass<float> before;
  detect::Pass<float> after;
  network.forward(images, before);
  parameters[0] += 0.5F;
  network.forward(images, after);
  CHECK(flat(before.logits[0]) != flat(after.logits[0]));
}

TEST_CASE("a network of one pixel works", "[detect][network]") {
  const std::string cfg =
      "[net]\nwidth=1\nheight=1\n[convolutional]\nfilters=255\nsize=3\npad=1\nactivation=leaky\n[maxpool]"
      "\nsize=2\n"
      "stride=1\n[convolutional]\nfilters=7\nactivation=linear\n[yolo]\nclasses=2\nanchors=1,1\n";
  const auto network = random_network<double>(cfg);
  const auto images = random_array<double>({1, 1, 1, 3}, 2);
  detect::Pass<double> pass;
  network.forward(images, pass, detect::Mode::training);
  CHECK(pass.logits[0].shape() == tapestry::Extents<4>{1, 7, 1, 1});
  auto gradient = tapestry::zeros<double, 1>({network.parameters().size()});
  network.parameter_adjoint(pass, pass.logits, gradient);
  CHECK(std::all_of(gradient.begin(), gradient.end(), [](double x) { return std::isfinite(x); }));
}

TEST_CASE("a network names the arguments that do not fit", "[detect][network]") {  // T21
  auto network = random_network<float>(real_layers);
  detect::Pass<float> pass;
  CHECK_THROWS_WITH(network.forward(tapestry::zeros<float, 4>({0, 32, 32, 3}), pass),
                    "Detector::forward: a batch of no images");
  CHECK_THROWS_WITH(network.forward(tapestry::zeros<float, 4>({1, 32, 64, 3}), pass),
                    "Detector::forward: images is [1, 32, 64, 3], expected [1, 32, 32, 3]");
  const auto images = random_array<float>({1, 32, 32, 3}, 2);
  network.forward(images, pass);
  auto gradient = tapestry::zeros<float, 4>({1, 32, 32, 3});
  auto parameters_adjoint = tapestry::zeros<float, 1>({network.parameters().size()});
  CHECK_THROWS_AS(network.input_adjoint(pass, pass.logits, gradient), tapestry::DomainError);
  network.forward(images, pass, detect::Mode::input_gradient);
  CHECK_THROWS_AS(network.input_adjoint(pass, {}, gradient), tapestry::ShapeError);
  CHECK_THROWS_AS(network.parameter_adjoint(pass, pass.logits, parameters_adjoint), tapestry::DomainError);
  CHECK_THROWS_AS(network.update_running_statistics(pass), tapestry::DomainError);
  CHECK_THROWS_AS(network.resized(30, 32), tapestry::FileError);
  CHECK(network.resized(64, 96).heads()[0].grid_width == 24);
}
