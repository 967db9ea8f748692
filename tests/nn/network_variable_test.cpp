#include <tapestry/nn/network_variable.hpp>

#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
/// A convolution, Mish, and a second result that pools the first; pictures are [1, 5, 6, 3].
nn::NetworkDescription small_network() {
  nn::NetworkDescription network;
  network.opset = 18;
  network.inputs = {{"x", {1, 3, 5, 6}}};
  const auto weights = random_array<float>({4, 3, 3, 3}, 1, -1, 1);
  network.constants["w"] = {
      {4, 3, 3, 3}, nn::ElementType::floating, std::vector<float>(weights.begin(), weights.end())};
  network.constants["b"] = {{4}, nn::ElementType::floating, std::vector<float>{0.1F, -0.2F, 0.3F, 0}};
  network.nodes = {{"", "Conv", {"x", "w", "b"}, {"sums"}, {}},
                   {"", "Mish", {"sums"}, {"y"}, {}},
                   {"", "GlobalAveragePool", {"y"}, {"z"}, {}}};
  network.outputs = {"y", "z"};
  return network;
}

/// Σ y² + Σ z of two pictures that are results themselves.
struct Problem {
  nn::Network<double> network{small_network(), {}, true};
  Array<double, 4> pictures = random_array<double>({2, 5, 6, 3}, 2, -1, 1);
  Array<double, 1> weights =
      tapestry::array_of(std::vector<double>(network.weights().begin(), network.weights().end()));

  double value(Array<double, 4>* of_pictures = nullptr, Array<double, 1>* of_weights = nullptr) {
    ActiveTape<double> tape;
    const auto x = tape.input(pictures);
    const auto w = tape.input(weights);
    const ArrayVariable<double, 4> computed = 1.25 * x;
    const auto results = nn::forward(network, computed, w);
    REQUIRE(results.size() == 2);
    const auto loss = sum(results[0] * results[0]) + sum(results[1]);
    if (of_pictures != nullptr) {
      tape.reverse(loss);
      *of_pictures = x.adjoint();
      *of_weights = w.adjoint();
    }
    return loss.value();
  }
};
}  // namespace

TEST_CASE("a network on the tape has the gradients of central differences", "[nn][network][variable]") {
  Problem problem;
  Array<double, 4> of_pictures;
  Array<double, 1> of_weights;
  problem.value(&of_pictures, &of_weights);
  const double step = test::central_difference_step<double>();
  const auto slope = [&](double& number) { return slope_by(number, step, [&] { return problem.value(); }); };
  for (std::size_t i = 0; i < of_pictures.size(); i += 7)
    CHECK(of_pictures.data()[i] == Approx(slope(problem.pictures.data()[i])).epsilon(1e-6).margin(1e-7));
  REQUIRE(of_weights.size() == 4 * 3 * 3 * 3 + 4);
  for (std::size_t i = 0; i < of_weights.size(); i += 5)
    CHECK(of_weights[i] == Approx(slope(problem.weights[i])).epsilon(1e-6).margin(1e-7));
}

TEST_CASE("frozen weights and passive pictures take no tape", "[nn][network][variable]") {
  const nn::Network<double> network(small_network(), {}, true);
  const auto pictures = random_array<double>({2, 5, 6, 3}, 2, -1, 1);
  ActiveTape<double> tape;
  const auto passive = nn::forward(network, ArrayVariable<double, 4>(pictures));
  CHECK(tape.statement_count() == 0);
  CHECK(passive[0].shape() == Extents<4>{2, 4, 3, 4});
  const auto pass = std::make_shared<nn::NetworkPass<double>>();
  Problem problem;
  Array<double, 4> expected;
  Array<double, 1> ignored;
  problem.value(&expected, &ignored);
  const auto x = tape.input(pictures);
  const ArrayVariable<double, 4> computed = 1.25 * x;
  for (int again = 0; again < 2; ++again) {
    const auto results = nn::forward(network, computed, pass);
    tape.reverse(sum(results[0] * results[0]) + sum(results[1]));
    CHECK(test::dot(x.adjoint(), pictures) == Approx(test::dot(expected, pictures)).epsilon(1e-12));
  }
}

TEST_CASE("a network on the tape refuses what does not fit", "[nn][network][variable][error]") {
  nn::Network<double> network(small_network(), {}, true);
  const std::vector<double> before(network.weights().begin(), network.weights().end());
  ActiveTape<double> tape;
  const auto x = tape.input(random_array<double>({2, 5, 6, 3}, 2));
  CHECK_THROWS_WITH(nn::forward(network, x, tape.input(tapestry::zeros<double, 1>({3}))),
                    contains("weights is [3], expected"));
  const auto wide = tape.input(random_array<double>({2, 5, 7, 3}, 2));
  CHECK_THROWS_WITH(nn::forward(network, wide), "nn::forward: x is [2, 5, 7, 3], expected [2, 5, 6, 3]");
  CHECK_THROWS_WITH(nn::forward(network, ArrayVariable<double, 4>(tapestry::zeros<double, 4>({0, 5, 6, 3}))),
                    "nn::forward: a batch of none");
  CHECK(std::ranges::equal(network.weights(), before));
  auto description = small_network();
  description.nodes.push_back({"", "Flatten", {"y"}, {"flat"}, {}});
  description.outputs.push_back("flat");
  const nn::Network<double> flat(description, {}, true);
  CHECK_THROWS_WITH(nn::forward(flat, x), contains("a result of the network is [1, 48], expected four axes"));
}
