#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/detect/batch_norm_folding_variable.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <tapestry/io/darknet/cfg_file.hpp>

#include <cmath>
#include <vector>

#include "../support/catch.hpp"
#include "../support/cfg_text.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "../support/random_detector.hpp"

namespace detect = tapestry::detect;
using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::test::random_array;

namespace {
template <class T>
detect::Network<T> normalised_network() {
  return tapestry::test::random_detector<T>(
      tapestry::io::parse_network_config(tapestry::test::cfg_text("two_heads"), "two heads"), 3);
}

/// Random numbers, but 0 for running statistics, which are constants.
template <class T>
Array<T, 1> learnt_direction(const detect::ParameterLayout& layout) {
  auto direction = tapestry::test::random_direction<T>({layout.count}, 4);
  for (const auto& block : layout.blocks)
    if (block.role == detect::ParameterRole::mean || block.role == detect::ParameterRole::variance)
      for (std::size_t i = 0; i < block.count; ++i) direction[block.offset + i] = 0;
  return direction;
}
}  // namespace

TEST_CASE("fold_batch_norm of one filter is what is worked out by hand", "[detect][folding]") {
  auto config = tapestry::io::parse_classifier_config(
      "[net]\nwidth=2\nheight=2\nchannels=3\n[convolutional]\nbatch_normalize=1\nfilters=1\nsize=1\n"
      "activation=linear\n",
      "one filter");
  config.batch_norm_epsilon = 1;
  const auto layout = detect::parameter_layout(config, detect::infer_shapes(config, 2, 2));
  Array<double, 1> parameters(tapestry::Extents<1>{7});
  const std::vector<double> values{5, 6, 2, 3, 1, 2, 4};  // β, γ, μ, σ², three weights; f = 6 / √(3 + 1) = 3
  std::copy(values.begin(), values.end(), parameters.data());
  const auto folded = detect::fold_batch_norm(config, layout, parameters);
  REQUIRE(folded.size() == 4);
  CHECK(std::vector<double>(folded.begin(), folded.end()) == std::vector<double>{-1, 3, 6, 12});

  Array<double, 1> folded_adjoint(tapestry::Extents<1>{4});
  const std::vector<double> seeds{1, 10, 100, 1000};
  std::copy(seeds.begin(), seeds.end(), folded_adjoint.data());
  auto adjoint = tapestry::filled<double, 1>({7}, 0.5);
  detect::fold_batch_norm_adjoint(config, layout, parameters, folded_adjoint, adjoint);
  // γ̄ = (1·10 + 2·100 + 4·1000 − 2·1) / 2
  CHECK(std::vector<double>(adjoint.begin(), adjoint.end()) ==
        std::vector<double>{1.5, 2104.5, 0.5, 0.5, 30.5, 300.5, 3000.5});
}

TEMPLATE_TEST_CASE("fold_batch_norm_adjoint agrees with central differences", "[detect][folding][gradient]",
                   float, double) {
  const auto network = normalised_network<TestType>();
  const auto& layout = network.layout();
  const auto folded = detect::fold_batch_norm(network.config(), layout, network.parameters());
  const auto weights = tapestry::test::random_direction<TestType>({folded.size()}, 5);
  const auto value = [&](const Array<TestType, 1>& parameters) {
    return tapestry::test::dot(weights, detect::fold_batch_norm(network.config(), layout, parameters));
  };
  Array<TestType, 1> half = weights;
  for (auto& entry : half) entry /= 2;
  auto adjoint = tapestry::zeros<TestType, 1>({layout.count});
  for (int i = 0; i < 2; ++i)  // two halves make a whole only if the adjoint adds
    detect::fold_batch_norm_adjoint(network.config(), layout, network.parameters(), half, adjoint);
  const auto direction = learnt_direction<TestType>(layout);
  CHECK(std::abs(tapestry::test::dot(adjoint, direction) -
                 tapestry::test::central_difference(value, network.parameters(), direction)) <=
        tapestry::test::central_difference_tolerance(value(network.parameters())));
}

TEST_CASE("a training pass of the folded network is inference but for rounding", "[detect][folding][tape]") {
  auto network = normalised_network<float>();
  detect::Network<float> folded(detect::without_batch_norm(network.config()));
  const auto images = random_array<float, 4>({2, 8, 8, 3}, 6);
  detect::Pass<float> pass;
  network.forward(images, pass);
  tapestry::Tape<float> tape;
  const auto scope = tape.activate();
  const auto parameters = tape.input(network.parameters());
  const auto logits =
      detect::forward(folded, ArrayVariable<float, 4>(images),
                      detect::fold_batch_norm(network.config(), network.layout(), parameters));
  // Training keeps what its adjoint needs, so activations are put on after the convolution, not within it.
  for (std::size_t head = 0; head < logits.size(); ++head)
    for (std::size_t i = 0; i < logits[head].size(); ++i)
      CHECK(logits[head].value().data()[i] == Approx(pass.logits[head].data()[i]).epsilon(1e-5).margin(1e-5));
}

TEST_CASE("weights learn through a folded network as central differences say",
          "[detect][folding][gradient]") {
  const auto network = normalised_network<double>();
  detect::Network<double> folded(detect::without_batch_norm(network.config()));
  const auto images = random_array<double, 4>({2, 8, 8, 3}, 7);
  const auto total = [&](const ArrayVariable<double, 1>& parameters) {
    const auto logits =
        detect::forward(folded, ArrayVariable<double, 4>(images),
                        detect::fold_batch_norm(network.config(), network.layout(), parameters));
    return tapestry::Variable<double>(sum(logits[0] * logits[0]) + sum(logits[1] * exp(0.1 * logits[1])));
  };
  const auto value = [&](const Array<double, 1>& parameters) {
    return total(ArrayVariable<double, 1>(parameters)).value();
  };
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const Array<double, 1> start = network.parameters();
  const auto parameters = tape.input(start);
  tape.reverse(total(parameters));
  const auto direction = learnt_direction<double>(network.layout());
  const double expected = tapestry::test::central_difference(value, start, direction);
  CHECK(tapestry::test::dot(parameters.adjoint(), direction) ==
        Approx(expected).epsilon(1e-8).margin(tapestry::test::central_difference_tolerance(value(start))));
}

TEST_CASE("fold_batch_norm_adjoint names both lengths", "[detect][folding]") {
  const auto network = normalised_network<double>();
  auto adjoint = tapestry::zeros<double, 1>({network.layout().count});
  auto short_adjoint = tapestry::zeros<double, 1>({3});
  const auto folded = detect::fold_batch_norm(network.config(), network.layout(), network.parameters());
  CHECK_THROWS_AS(detect::fold_batch_norm_adjoint(network.config(), network.layout(), network.parameters(),
                                                  short_adjoint, adjoint),
                  tapestry::ShapeError);
  CHECK_THROWS_WITH(detect::fold_batch_norm_adjoint(network.config(), network.layout(), network.parameters(),
                                                    folded, short_adjoint),
                    "fold_batch_norm_adjoint: parameters_adjoint is [3], expected [" +
                        std::to_string(network.layout().count) + "]");
}
