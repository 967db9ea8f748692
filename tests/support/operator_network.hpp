#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/nn/network/network.hpp>
#include "relative_distance.hpp"

namespace tapestry::test {
/// An operand of the operator under test: an input of the network, a constant, or none.
struct TestOperand {
  enum class Kind { given, constant, left_out };
  Kind kind = Kind::left_out;
  nn::Shape shape{};
  std::vector<double> values{};
  nn::ElementType type = nn::ElementType::floating;
};

/// Values in [low, high).
inline std::vector<double> random_values(std::size_t count, std::uint64_t seed, double low = -1,
                                         double high = 1) {
  Random random(seed);
  std::vector<double> values(count);
  // rounded to float, so that both precisions start equal
  for (double& value : values) value = static_cast<double>(static_cast<float>(random.uniform(low, high)));
  return values;
}
inline TestOperand given(const nn::Shape& shape, std::uint64_t seed, double low = -1, double high = 1) {
  return {TestOperand::Kind::given, shape, random_values(nn::size_of(shape), seed, low, high)};
}
inline TestOperand weight(const nn::Shape& shape, std::uint64_t seed, double low = -1, double high = 1) {
  return {TestOperand::Kind::constant, shape, random_values(nn::size_of(shape), seed, low, high)};
}
inline TestOperand numbers(std::vector<double> values, nn::ElementType type = nn::ElementType::integer) {
  const std::size_t count = values.size();
  return {TestOperand::Kind::constant, {count}, std::move(values), type};
}

/// A network that applies one operator twice, for the results y and z, to operands that a
/// node before it passes on: the first pullback finds their adjoints fresh, the second one
/// adds. It runs without simplification.
struct OperatorNetwork {
  nn::Node node{};
  std::vector<TestOperand> operands{};
  std::int64_t opset = 13;

  [[nodiscard]] nn::NetworkDescription description() const {
    nn::NetworkDescription network;
    network.path = "test.onnx";
    network.opset = opset;
    nn::Node first = node;
    first.inputs.clear();
    for (std::size_t i = 0; i < operands.size(); ++i) {
      const TestOperand& operand = operands[i];
      const std::string name = std::to_string(i);
      first.inputs.push_back(operand.kind == TestOperand::Kind::left_out ? "" : "operand" + name);
      if (operand.kind == TestOperand::Kind::constant)
        network.constants[first.inputs.back()] = {operand.shape, operand.type, operand.values};
      if (operand.kind != TestOperand::Kind::given) continue;
      network.inputs.push_back({"input" + name, {operand.shape.begin(), operand.shape.end()}, operand.type});
      network.nodes.push_back({"", "Identity", {"input" + name}, {first.inputs.back()}, {}});
    }
    nn::Node second = first;
    first.outputs = {"y"};
    second.outputs = {"z"};
    network.nodes.push_back(first);
    network.nodes.push_back(second);
    network.outputs = {"y", "z"};
    return network;
  }

  template <class T>
  [[nodiscard]] nn::Network<T> network() const {
    return nn::Network<T>(description(), {}, false, false);
  }

  /// The operands that are given, as a network takes them.
  template <class T>
  [[nodiscard]] std::vector<nn::Buffer<T>> inputs() const {
    std::vector<nn::Buffer<T>> all;
    for (const TestOperand& operand : operands) {
      if (operand.kind != TestOperand::Kind::given) continue;
      all.emplace_back(operand.values.size());
      for (std::size_t i = 0; i < operand.values.size(); ++i)
        all.back().data()[i] = static_cast<T>(operand.values[i]);
    }
    return all;
  }
};

/// \param computed  whether constant operands are given, too
inline OperatorNetwork operator_network(const std::string& operation, std::vector<TestOperand> operands,
                                        std::map<std::string, nn::Attribute> attributes = {},
                                        std::int64_t opset = 13, bool computed = false) {
  OperatorNetwork test{{"", operation, {}, {}, std::move(attributes)}, std::move(operands), opset};
  for (TestOperand& operand : test.operands)
    if (computed) operand.kind = TestOperand::Kind::given;
  return test;
}

template <class T>
std::vector<const T*> addresses(const std::vector<nn::Buffer<T>>& buffers) {
  std::vector<const T*> all;
  for (const auto& buffer : buffers) all.push_back(buffer.data());
  return all;
}

/// The operator's first result.
template <class T>
std::vector<T> result_of(const OperatorNetwork& test) {
  const auto network = test.network<T>();
  nn::NetworkPass<T> pass;
  const auto inputs = test.inputs<T>();
  network.forward(addresses(inputs), pass);
  const std::size_t count = nn::size_of(network.output_shape(0));
  return std::vector<T>(pass.output(0), pass.output(0) + count);
}

/// A sum, and the sum of its terms' absolute values.
struct Objective {
  double value = 0, magnitude = 0;
};

/// Gradients of Σ u·y + Σ v·z for drawn u and v, for each given operand and then for the constants.
template <class T>
std::vector<std::vector<double>> gradients_of(const OperatorNetwork& test, const nn::Network<T>& network,
                                              Objective& objective) {
  const auto inputs = test.inputs<T>();
  nn::NetworkPass<T> pass;
  network.forward(addresses(inputs), pass, nn::Mode::training);
  const std::size_t count = nn::size_of(network.output_shape(0));
  nn::Buffer<T> weights[2] = {nn::Buffer<T>(count), nn::Buffer<T>(count)};
  objective = {};
  for (std::size_t k = 0; k < 2; ++k) {
    const auto drawn = random_values(count, 77 + k);
    for (std::size_t i = 0; i < count; ++i) {
      weights[k].data()[i] = static_cast<T>(drawn[i]);
      const double term = drawn[i] * static_cast<double>(pass.output(k)[i]);
      objective.value += term;
      objective.magnitude += std::abs(term);
    }
  }
  std::vector<std::vector<T>> found;
  std::vector<T*> wanted;
  for (const auto& input : inputs) found.emplace_back(input.size(), T(0));
  for (auto& gradient : found) wanted.push_back(gradient.data());
  std::vector<T> of_weights(network.weights().size(), T(0));
  network.adjoint(pass, {weights[0].data(), weights[1].data()}, wanted, of_weights.data());
  found.push_back(of_weights);
  std::vector<std::vector<double>> gradients;
  for (const auto& gradient : found) gradients.emplace_back(gradient.begin(), gradient.end());
  return gradients;
}

/// Checks the adjoint with respect to all given operands and all weights: in double against central
/// differences along drawn directions, in float against double.
/// \param float_tolerance  beside the largest value of each gradient
inline void check_adjoints(const OperatorNetwork& test, double float_tolerance = 2e-5) {
  auto network = test.network<double>();
  Objective objective;
  const auto gradients = gradients_of(test, network, objective);
  const double h = std::cbrt(std::numeric_limits<double>::epsilon());
  std::size_t g = 0;
  const auto check = [&](const std::vector<double>& direction, const auto& value_at) {
    double slope = 0;
    for (std::size_t i = 0; i < direction.size(); ++i) slope += gradients[g][i] * direction[i];
    const double difference = (value_at(h) - value_at(-h)) / (2 * h);
    CAPTURE(g, slope, difference);
    // Truncation h²/6·f''' and rounding ε|f|/h, both about ε^(2/3) for such values.
    CHECK(std::abs(slope - difference) <= 4 * h * h * std::max({1.0, objective.magnitude, std::abs(slope)}));
    ++g;
  };
  for (std::size_t o = 0; o < test.operands.size(); ++o) {
    if (test.operands[o].kind != TestOperand::Kind::given) continue;
    const auto direction = random_values(test.operands[o].values.size(), 5 + o);
    check(direction, [&](double step) {
      OperatorNetwork moved = test;
      for (std::size_t i = 0; i < direction.size(); ++i) moved.operands[o].values[i] += step * direction[i];
      Objective result;
      static_cast<void>(gradients_of(moved, network, result));
      return result.value;
    });
  }
  const std::vector<double> weights(network.weights().begin(), network.weights().end());
  const auto direction = random_values(weights.size(), 6);
  check(direction, [&](double step) {
    auto moved = weights;
    for (std::size_t i = 0; i < moved.size(); ++i) moved[i] += step * direction[i];
    network.set_weights(moved);
    Objective result;
    static_cast<void>(gradients_of(test, network, result));
    return result.value;
  });
  const auto single = gradients_of(test, test.network<float>(), objective);
  for (std::size_t i = 0; i < gradients.size(); ++i) {
    CAPTURE(i);
    double largest = 1;
    for (const double slope : gradients[i]) largest = std::max(largest, std::abs(slope));
    CHECK(largest_difference(single[i], gradients[i]) <= float_tolerance * largest);
  }
}

/// The network's error when it refuses the operator.
inline std::string refusal_of(const OperatorNetwork& test) {
  try {
    static_cast<void>(test.network<float>());
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}
}  // namespace tapestry::test
