#include "../../../support/operator_case.hpp"
#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
constexpr double epsilon = 1e-3;

template <class T>
double tolerance() {
  return 60 * static_cast<double>(std::numeric_limits<T>::epsilon());
}

/// scale · (x − mean)/√(variance + ε) + bias of each set of elements; set_of, scale_of and bias_of return an
/// element's by its place in [N, C, …].
template <class SetOf, class ScaleOf, class BiasOf>
std::vector<double> normalised(const std::vector<double>& x, std::size_t sets, SetOf set_of, ScaleOf scale_of,
                               BiasOf bias_of) {
  std::vector<double> mean(sets), variance(sets), y(x.size());
  const double count = static_cast<double>(x.size() / sets);
  for (std::size_t i = 0; i < x.size(); ++i) mean[set_of(i)] += x[i] / count;
  for (std::size_t i = 0; i < x.size(); ++i)
    variance[set_of(i)] += std::pow(x[i] - mean[set_of(i)], 2) / count;
  for (std::size_t i = 0; i < x.size(); ++i)
    y[i] = (x[i] - mean[set_of(i)]) / std::sqrt(variance[set_of(i)] + epsilon) * scale_of(i) + bias_of(i);
  return y;
}

OperatorNetwork network_of(const char* operation, std::vector<TestOperand> operands, bool computed = false) {
  return operator_network(operation, std::move(operands), {{"epsilon", epsilon}}, 13, computed);
}
const std::vector<nn::Shape> shapes = {{2, 6, 3, 5}, {3, 6}, {2, 6, 7}, {2, 6, 2, 2, 3}, {1, 6, 17, 16}};
std::size_t pixels_of(const nn::Shape& shape) { return nn::size_of(shape) / shape[0] / shape[1]; }
}  // namespace

TEMPLATE_TEST_CASE("BatchNormalization takes the statistics that it is given", "[nn][network][normalization]",
                   float, double) {
  for (const nn::Shape& shape : shapes)
    for (const bool computed : {false, true}) {
      CAPTURE(shape, computed);
      const auto test = network_of(
          "BatchNormalization",
          {given(shape, 1), weight({6}, 2), weight({6}, 3), weight({6}, 4), weight({6}, 5, 0.5, 2)},
          computed);
      std::vector<double> expected;
      for (std::size_t i = 0; i < test.operands[0].values.size(); ++i) {
        const std::size_t c = i / pixels_of(shape) % 6;
        const auto at = [&](std::size_t operand) { return test.operands[operand].values[c]; };
        expected.push_back(at(1) * (test.operands[0].values[i] - at(3)) / std::sqrt(at(4) + epsilon) + at(2));
      }
      CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
      check_adjoints(test);
    }
}

TEMPLATE_TEST_CASE("BatchNormalization in training takes the statistics of the batch",
                   "[nn][network][normalization]", float, double) {
  for (const nn::Shape& shape : {nn::Shape{2, 6, 3, 5}, nn::Shape{9, 6}, nn::Shape{1, 6, 17, 16}})
    for (const bool computed : {false, true}) {
      CAPTURE(shape, computed);
      auto test = network_of(
          "BatchNormalization",
          {given(shape, 1), weight({6}, 2), weight({6}, 3), weight({6}, 4), weight({6}, 5, 0.5, 2)},
          computed);
      test.node.attributes["training_mode"] = std::int64_t(1);
      const std::size_t pixels = pixels_of(shape);
      const auto at = [&](std::size_t operand) {
        return [&, operand](std::size_t i) { return test.operands[operand].values[i / pixels % 6]; };
      };
      const auto expected = normalised(
          test.operands[0].values, 6, [&](std::size_t i) { return i / pixels % 6; }, at(1), at(2));
      CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
      check_adjoints(test, 1e-4);
    }
}

TEST_CASE("BatchNormalization in training moves running statistics, which have derivatives, too",
          "[nn][network][normalization]") {
  OperatorCase batch{"BatchNormalization", {{2, 3, 2, 3}, {3}, {3}, {3}, {3}}};
  batch.attributes = {{"training_mode", std::int64_t(1)}, {"momentum", 0.7}};
  batch.output_count = batch.smooth_outputs = 3;
  check_operator(batch);
  batch.shapes.resize(1);
  for (const std::size_t operand : {1U, 2U, 3U, 4U})
    batch.constants[operand] = tapestry::test::numbers(nn::Shape{3}, std::vector<double>{1, 2, 3});
  batch.shapes[0] = {4, 3};
  const auto results = results_of(batch, {{1, 2, 3, 1, 2, 4, 5, 2, 1, 5, 2, 0}});
  CHECK(results[12] == Approx(0.7 * 1 + 0.3 * 3));
  CHECK(results[13] == Approx(0.7 * 2 + 0.3 * 2));
  CHECK(results[15] == Approx(0.7 * 1 + 0.3 * 4));  // the biased variance
  CHECK(results[16] == Approx(0.7 * 2));
}

TEST_CASE("a batch of pictures is normalised as one tensor of all", "[nn][network][normalization]") {
  nn::NetworkDescription network;
  network.opset = 15;
  network.inputs = {{"x", {1, 3, 4, 5}}};
  for (const char* name : {"scale", "bias", "mean", "variance"})
    network.constants[name] = tapestry::test::numbers(nn::Shape{3}, std::vector<double>{0.5, 2, -1});
  network.nodes = {{"",
                    "BatchNormalization",
                    {"x", "scale", "bias", "mean", "variance"},
                    {"y", "means", "variances"},
                    {{"training_mode", std::int64_t(1)}, {"momentum", 0.0}}}};
  network.outputs = {"y", "means", "variances"};
  const nn::Network<double> one(network);
  network.inputs[0].shape[0] = 4;
  const nn::Network<double> all(network);
  const auto drawn = random_values(240, 3);
  nn::Buffer<double> x(240);
  std::ranges::copy(drawn, x.data());
  nn::NetworkPass<double> of_one, of_all;
  one.forward({x.data()}, of_one, nn::Mode::training, 4);
  all.forward({x.data()}, of_all, nn::Mode::training);
  const auto bits = [](const double* values, std::size_t count) {
    return std::vector<double>(values, values + count);
  };
  CHECK(bits(of_one.output(0), 240) == bits(of_all.output(0), 240));
  for (const std::size_t result : {1U, 2U})
    for (const std::size_t n : {0U, 3U})
      CHECK(bits(of_one.output(result) + 3 * n, 3) == bits(of_all.output(result), 3));
  const auto adjoint = random_values(240, 4);
  std::vector<double> x_one(240), x_all(240), weights_one(one.weights().size()), weights_all = weights_one;
  one.adjoint(of_one, {adjoint.data(), nullptr, nullptr}, {x_one.data()}, weights_one.data());
  all.adjoint(of_all, {adjoint.data(), nullptr, nullptr}, {x_all.data()}, weights_all.data());
  CHECK(x_one == x_all);
  CHECK(weights_one == weights_all);
}

TEMPLATE_TEST_CASE("InstanceNormalization and GroupNormalization take those of their sets",
                   "[nn][network][normalization]", float, double) {
  for (const nn::Shape& shape : shapes)
    for (const std::int64_t opset : {18, 21})
      for (const std::size_t groups : {std::size_t(6), std::size_t(2), std::size_t(1)}) {
        const std::size_t pixels = pixels_of(shape), of_group = 6 / groups;
        if (pixels * of_group < 2) continue;  // a set of one
        CAPTURE(shape, opset, groups);
        const std::size_t weights = opset == 18 ? groups : 6;
        auto test =
            network_of("GroupNormalization", {given(shape, 1), weight({weights}, 2), weight({weights}, 3)});
        test.opset = opset;
        test.node.attributes["num_groups"] = static_cast<std::int64_t>(groups);
        const auto at = [&](std::size_t operand) {
          return [&, operand](std::size_t i) {
            return test.operands[operand].values[i / pixels % 6 / (6 / weights)];
          };
        };
        const auto expected = normalised(
            test.operands[0].values, shape[0] * groups,
            [&](std::size_t i) { return i / (pixels * of_group); }, at(1), at(2));
        CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
        check_adjoints(test, 1e-4);
        if (weights != 6 || groups != 6) continue;
        test.node.operation = "InstanceNormalization";
        test.node.attributes.erase("num_groups");
        CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
      }
}

TEMPLATE_TEST_CASE("LayerNormalization takes those of its last axes", "[nn][network][normalization]", float,
                   double) {
  for (const std::int64_t axis : {-1, -2, 1}) {
    const nn::Shape shape = {3, 4, 5};
    CAPTURE(axis);
    const std::size_t size = axis == -1 ? 5 : 20;
    const nn::Shape row = axis == -1 ? nn::Shape{5} : nn::Shape{4, 5};
    auto test = network_of("LayerNormalization", {given(shape, 1), weight(row, 2), weight({5}, 3)});
    test.node.attributes["axis"] = axis;
    const auto expected = normalised(
        test.operands[0].values, 60 / size, [&](std::size_t i) { return i / size; },
        [&](std::size_t i) { return test.operands[1].values[i % size]; },
        [&](std::size_t i) { return test.operands[2].values[i % 5]; });
    CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
    check_adjoints(test, 1e-4);
    test.operands.pop_back();  // without a bias
    check_adjoints(test, 1e-4);
  }
}

TEMPLATE_TEST_CASE("LRN divides by neighbouring channels", "[nn][network][normalization]", float, double) {
  for (const nn::Shape& shape : shapes)
    for (const std::int64_t size : {1, 2, 3, 4, 5}) {
      CAPTURE(shape, size);
      auto test = network_of("LRN", {given(shape, 1)});
      test.node.attributes = {{"size", size}, {"alpha", 0.5}, {"beta", 0.6}, {"bias", 1.5}};
      const auto& x = test.operands[0].values;
      const auto pixels = static_cast<std::ptrdiff_t>(pixels_of(shape));
      std::vector<double> expected;
      for (std::ptrdiff_t i = 0; i < static_cast<std::ptrdiff_t>(x.size()); ++i) {
        const std::ptrdiff_t c = i / pixels % 6;
        double squares = 0;
        // from c − ⌊(size − 1)/2⌋ to c + ⌈(size − 1)/2⌉
        for (std::ptrdiff_t k = c - (size - 1) / 2; k <= c + size / 2; ++k)
          if (k >= 0 && k < 6) squares += std::pow(x[static_cast<std::size_t>(i + (k - c) * pixels)], 2);
        expected.push_back(x[static_cast<std::size_t>(i)] /
                           std::pow(1.5 + 0.5 / static_cast<double>(size) * squares, 0.6));
      }
      CHECK(largest_difference(result_of<TestType>(test), expected) <= tolerance<TestType>());
      check_adjoints(test);
    }
}

TEST_CASE("normalisations refuse what they cannot do", "[nn][network][normalization]") {
  auto batch = network_of("BatchNormalization",
                          {given({2, 6}, 1), weight({6}, 2), weight({6}, 3), weight({6}, 4), weight({5}, 5)});
  CHECK_THAT(refusal_of(batch), contains("input 4 is [5], expected [6]"));
  auto line = network_of("BatchNormalization", {given({2, 6, 7}, 1), weight({6}, 2), weight({6}, 3),
                                                weight({6}, 4), weight({6}, 5)});
  line.node.attributes["training_mode"] = std::int64_t(1);
  CHECK_THAT(refusal_of(line),
             contains("'training_mode' is 1; only maps, [N, C, H, W], are supported there"));
  CHECK_THAT(refusal_of(network_of("InstanceNormalization", {given({6}, 1), weight({6}, 2), weight({6}, 3)})),
             contains("input 0 is [6], expected [N, C, …]"));
  auto group = network_of("GroupNormalization", {given({2, 6, 3}, 1), weight({4}, 2), weight({4}, 3)});
  group.node.attributes["num_groups"] = std::int64_t(4);
  CHECK_THAT(refusal_of(group), contains("'num_groups' is 4 for 6 channels"));
  CHECK_THAT(refusal_of(network_of("LayerNormalization", {given({2, 6}, 1), weight({5}, 2)})),
             contains("a weight is [5], which does not fit rows of [6]"));
  auto lrn = network_of("LRN", {given({2, 6, 3}, 1)});
  lrn.node.attributes = {};
  CHECK_THAT(refusal_of(lrn), contains("attribute 'size' is missing"));
  auto description = network_of("LayerNormalization", {given({2, 6}, 1), weight({6}, 2)}).description();
  description.nodes.back().outputs.push_back("mean");
  CHECK_THROWS_WITH(nn::Network<float>(description), contains("result 1 is not supported"));
}
