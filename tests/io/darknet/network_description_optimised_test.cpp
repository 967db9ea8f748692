#include <tapestry/io/darknet/network_description.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <tapestry/detect/network.hpp>
#include <tapestry/nn/network/network.hpp>

#include "../../support/catch.hpp"
#include "../../support/differential.hpp"
#include "../../support/random_array.hpp"
#include "../../support/random_cfg.hpp"
#include "../../support/random_detector.hpp"

namespace detect = tapestry::detect;
namespace io = tapestry::io;
namespace nn = tapestry::nn;
using tapestry::Array;
using tapestry::Random;

namespace {
/// Logits one behind the other, and the adjoint of one picture by the same weighting of them.
template <class T>
struct Outcome {
  std::vector<T> logits{}, gradient{};
};

template <class T>
std::vector<Array<T, 4>> weighting_like(const std::vector<Array<T, 4>>& logits) {
  auto weighting = logits;
  Random random(3);
  for (auto& head : weighting)
    for (T& value : head.storage()) value = static_cast<T>(random.uniform(-1, 1));
  return weighting;
}

template <class T>
Outcome<T> by_layers(const detect::Network<T>& network, const Array<T, 4>& picture) {
  detect::Pass<T> pass;
  network.forward(picture, pass, detect::Mode::input_gradient);
  auto gradient = tapestry::zeros<T, 4>(picture.shape());
  network.input_adjoint(pass, weighting_like(pass.logits), gradient);
  Outcome<T> outcome;
  for (const auto& head : pass.logits)
    outcome.logits.insert(outcome.logits.end(), head.data(), head.data() + head.size());
  outcome.gradient.assign(gradient.data(), gradient.data() + gradient.size());
  return outcome;
}

template <class T>
Outcome<T> by_operators(const detect::Network<T>& layers, const Array<T, 4>& picture) {
  nn::Network<T> network(io::network_description(layers.config(), layers.parameters()), {}, true);
  network.set_engine(layers.engine());
  nn::Buffer<T> input;
  input.resize(picture.size() + 32);
  std::copy_n(picture.data(), picture.size(), input.data());
  nn::NetworkPass<T> pass;
  network.forward({input.data()}, pass, nn::Mode::input_gradient);
  std::vector<Array<T, 4>> logits;
  for (std::size_t i = 0; i < network.output_count(); ++i) {
    const auto& shape = network.output_shape(i);
    Array<T, 4> head(tapestry::Extents<4>{shape[0], shape[1], shape[2], shape[3]});
    std::copy_n(pass.output(i), head.size(), head.data());
    logits.push_back(head);
  }
  const auto weighting = weighting_like(logits);
  std::vector<const T*> adjoints;
  for (const auto& head : weighting) adjoints.push_back(head.data());
  Outcome<T> outcome;
  outcome.gradient.resize(picture.size(), T(0));
  network.adjoint(pass, adjoints, {outcome.gradient.data()});
  for (const auto& head : logits)
    outcome.logits.insert(outcome.logits.end(), head.data(), head.data() + head.size());
  return outcome;
}

/// Largest difference, over the largest value, or over 1e-4 where a softmax before a mean leaves only
/// rounding.
template <class T>
double distance(const std::vector<T>& found, const std::vector<T>& expected) {
  REQUIRE(found.size() == expected.size());
  double largest = 0, difference = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    largest = std::max(largest, std::abs(static_cast<double>(expected[i])));
    difference =
        std::max(difference, std::abs(static_cast<double>(found[i]) - static_cast<double>(expected[i])));
  }
  return difference / std::max(largest, 1e-4);
}
}  // namespace

TEST_CASE("a batch of pictures has the bits of each alone", "[io][darknet][differential][batch]") {
  tapestry::test::DifferentialRun run("batches of networks of operators", 2);
  while (run.next()) {
    const tapestry::test::RandomCfg cfg(run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const auto layers = tapestry::test::random_detector<float>(cfg.config(), run.seed());
    const nn::Network<float> network(io::network_description(layers.config(), layers.parameters()), {}, true);
    constexpr std::size_t batch = 3;
    const std::size_t size = 3 * layers.input_height() * layers.input_width();
    const auto pictures = tapestry::test::random_array<float>({batch, size}, run.seed());
    nn::Buffer<float> input;
    input.resize(pictures.size());
    std::copy_n(pictures.data(), pictures.size(), input.data());
    nn::NetworkPass<float> together, alone;
    network.forward({input.data()}, together, nn::Mode::input_gradient, batch);
    std::vector<const float*> adjoints;
    for (std::size_t i = 0; i < network.output_count(); ++i) adjoints.push_back(together.output(i));
    std::vector<float> gradient(pictures.size(), 0.F), expected(pictures.size(), 0.F);
    network.adjoint(together, adjoints, {gradient.data()});
    for (std::size_t n = 0; n < batch; ++n) {
      network.forward({input.data() + n * size}, alone, nn::Mode::input_gradient);
      for (std::size_t i = 0; i < network.output_count(); ++i) {
        const std::size_t count = nn::size_of(network.output_shape(i));
        adjoints[i] = alone.output(i);
        REQUIRE(std::equal(adjoints[i], adjoints[i] + count, together.output(i) + n * count));
      }
      network.adjoint(alone, adjoints, {expected.data() + n * size});
    }
    REQUIRE(gradient == expected);
  }
}

TEST_CASE("random Darknet networks give the same as operators, forward and backward",
          "[io][darknet][differential]") {
  tapestry::test::DifferentialRun run("Darknet networks as operators", 4);
  while (run.next()) {
    const tapestry::test::RandomCfg cfg(run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const auto network = tapestry::test::random_detector<double>(cfg.config(), run.seed());
    const auto picture = tapestry::test::random_array<double>(
        {1, network.input_height(), network.input_width(), 3}, run.seed());
    const auto expected = by_layers(network, picture);
    const auto found = by_operators(network, picture);
    REQUIRE(distance(found.logits, expected.logits) < 1e-10);
    REQUIRE(distance(found.gradient, expected.gradient) < 1e-9);
  }
}
