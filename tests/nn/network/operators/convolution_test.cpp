#include <tapestry/nn/detail/network/operators/convolution.hpp>

#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
struct Case {
  nn::Shape x, weights;
  std::int64_t group = 1;
  Integers strides{1, 1}, dilations{1, 1}, pads{0, 0, 0, 0};
};

std::vector<Case> cases() {
  return {{{1, 3, 7, 5}, {4, 3, 3, 3}},
          {{2, 3, 7, 5}, {4, 3, 3, 3}, 1, {2, 2}, {1, 1}, {1, 1, 1, 1}},
          {{1, 20, 9, 8}, {18, 20, 3, 3}, 1, {1, 1}, {1, 1}, {1, 1, 1, 1}},
          {{1, 16, 9, 11}, {16, 16, 1, 1}},
          {{2, 6, 8, 9}, {4, 3, 2, 3}, 2, {2, 1}, {1, 2}, {0, 3, 1, 2}},
          {{1, 17, 9, 10}, {17, 1, 3, 3}, 17, {2, 2}, {1, 1}, {1, 1, 1, 1}},
          {{1, 16, 9, 10}, {16, 1, 5, 3}, 16, {1, 1}, {2, 1}, {4, 1, 3, 0}},
          {{1, 4, 6, 6}, {8, 1, 3, 3}, 4, {1, 1}, {1, 1}, {0, 1, 2, 0}},
          {{1, 12, 8, 8}, {2, 12, 3, 3}, 1, {1, 1}, {1, 1}, {2, 0, 0, 2}},
          {{1, 5, 4, 6}, {3, 5, 4, 6}}};
}

OperatorNetwork network_of(const Case& c, bool computed = false) {
  return operator_network(
      "Conv", {given(c.x, 1), weight(c.weights, 2), weight({c.weights[0]}, 3)},
      {{"group", c.group}, {"strides", c.strides}, {"dilations", c.dilations}, {"pads", c.pads}}, 13,
      computed);
}

/// Σ as ONNX defines it, in plain loops over [N, C, H, W].
std::vector<double> reference(const Case& c, const OperatorNetwork& test, nn::Shape& shape) {
  const auto& w = c.weights;
  const auto extent = [&](std::size_t axis) {
    const auto at = [&](const Integers& values, std::size_t i) {
      return static_cast<std::size_t>(values[i]);
    };
    const std::size_t reach = (w[2 + axis] - 1) * at(c.dilations, axis) + 1;
    return (c.x[2 + axis] + at(c.pads, axis) + at(c.pads, axis + 2) - reach) / at(c.strides, axis) + 1;
  };
  shape = {c.x[0], w[0], extent(0), extent(1)};
  const std::size_t of_group = w[0] / static_cast<std::size_t>(c.group);
  std::vector<double> y;
  for (std::size_t n = 0; n < shape[0]; ++n)
    for (std::size_t m = 0; m < shape[1]; ++m)
      for (std::size_t i = 0; i < shape[2]; ++i)
        for (std::size_t j = 0; j < shape[3]; ++j) {
          double sum = test.operands[2].values[m];
          for (std::size_t k = 0; k < w[1]; ++k)
            for (std::size_t ty = 0; ty < w[2]; ++ty)
              for (std::size_t tx = 0; tx < w[3]; ++tx) {
                const auto row = static_cast<std::int64_t>(i) * c.strides[0] +
                                 static_cast<std::int64_t>(ty) * c.dilations[0] - c.pads[0];
                const auto column = static_cast<std::int64_t>(j) * c.strides[1] +
                                    static_cast<std::int64_t>(tx) * c.dilations[1] - c.pads[1];
                if (row < 0 || column < 0 || row >= static_cast<std::int64_t>(c.x[2]) ||
                    column >= static_cast<std::int64_t>(c.x[3]))
                  continue;
                const std::size_t channel = m / of_group * w[1] + k;
                sum +=
                    test.operands[0]
                        .values[((n * c.x[1] + channel) * c.x[2] + static_cast<std::size_t>(row)) * c.x[3] +
                                static_cast<std::size_t>(column)] *
                    test.operands[1].values[((m * w[1] + k) * w[2] + ty) * w[3] + tx];
              }
          y.push_back(sum);
        }
  return y;
}

/// Rounding of sums of products below 1, Winograd's transforms included.
template <class T>
double tolerance_of(const Case& c) {
  return 40 * static_cast<double>(c.weights[1] * c.weights[2] * c.weights[3] + 1) *
         static_cast<double>(std::numeric_limits<T>::epsilon());
}
}  // namespace

TEST_CASE("Conv equals its definition, and its adjoints agree with central differences",
          "[nn][network][convolution][gradient]") {
  for (const Case& c : cases())
    for (const bool computed : {false, true}) {
      CAPTURE(c.x, c.weights, computed);
      const auto test = network_of(c, computed);
      nn::Shape shape;
      const auto expected = reference(c, test, shape);
      CHECK(test.network<float>().output_shape(0) == shape);
      CHECK(test.network<double>().output_shape(0) == shape);
      CHECK(largest_difference(result_of<float>(test), expected) <= tolerance_of<float>(c));
      CHECK(largest_difference(result_of<double>(test), expected) <= tolerance_of<double>(c));
      check_adjoints(test);
    }
}

TEST_CASE("auto_pad stands for the padding that it says", "[nn][network][convolution]") {
  const auto results = [](const nn::Shape& x, const char* auto_pad, const Integers& pads) {
    Case c{x, {4, 3, 3, 2}, 1, {2, 3}, {2, 1}, pads};
    OperatorNetwork test = network_of(c);
    const auto expected = result_of<double>(test);
    test.node.attributes.erase("pads");
    test.node.attributes["auto_pad"] = std::string(auto_pad);
    return std::pair(result_of<double>(test), expected);
  };
  // 8 rows, stride 2, reach 5: 4 outputs need 11, 3 zeros; 8 columns, stride 3, 2 taps: 3 outputs need 8
  for (const auto& [found, expected] :
       {results({1, 3, 8, 8}, "SAME_UPPER", {1, 0, 2, 0}), results({1, 3, 8, 8}, "SAME_LOWER", {2, 0, 1, 0}),
        results({1, 3, 8, 7}, "SAME_UPPER", {1, 0, 2, 1}), results({1, 3, 8, 7}, "SAME_LOWER", {2, 1, 1, 0}),
        results({1, 3, 8, 8}, "VALID", {0, 0, 0, 0}), results({1, 3, 8, 8}, "NOTSET", {0, 0, 0, 0})})
    CHECK(found == expected);
}

TEST_CASE("FusedConv is Conv, the addend and the activation one after another",
          "[nn][network][convolution][gradient]") {
  const auto name = GENERATE(as<std::string>(), "", "Relu", "LeakyRelu", "Sigmoid", "Swish", "Mish",
                             "HardSwish", "HardSigmoid", "Clip");
  const auto channels = GENERATE(std::size_t(16), std::size_t(18));  // with bits from the kernel, and without
  const auto how = GENERATE(0, 1, 2);                                // no addend, before, after
  CAPTURE(name, channels, how);
  const double a = name == "Clip" ? -0.25 : 0.25, b = 0.5;
  Case c{{2, 5, 4, 6}, {channels, 5, 3, 3}, 1, {1, 1}, {1, 1}, {1, 1, 1, 1}};
  OperatorNetwork test = network_of(c);
  const auto sums = result_of<double>(test);
  test.node.operation = "FusedConv";
  test.node.attributes.insert({{"activation", name},
                               {"activation_a", a},
                               {"activation_b", b},
                               {"adds_first", std::int64_t(how == 1 ? 1 : 0)}});
  const TestOperand addend = given({2, channels, 4, 6}, 9);
  test.operands.insert(test.operands.begin() + 1, how == 0 ? TestOperand{} : addend);
  const auto activate = [&](double x) {
    const double flat = std::min(std::max(a * x + b, 0.0), 1.0);
    if (name == "Relu") return std::max(x, 0.0);
    if (name == "LeakyRelu") return x > 0 ? x : a * x;
    if (name == "Sigmoid") return 1 / (1 + std::exp(-x));
    if (name == "Swish") return x / (1 + std::exp(-x));
    if (name == "Mish") return x * std::tanh(std::log1p(std::exp(x)));
    if (name == "HardSigmoid") return flat;
    if (name == "HardSwish") return x * flat;
    return name == "Clip" ? std::min(std::max(x, a), b) : x;
  };
  std::vector<double> expected(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i)
    expected[i] = activate(sums[i] + (how == 1 ? addend.values[i] : 0)) + (how == 2 ? addend.values[i] : 0);
  CHECK(largest_difference(result_of<double>(test), expected) <= 1e-14);
  CHECK(largest_difference(result_of<float>(test), expected) <= 2 * tolerance_of<float>(c));
  check_adjoints(test);
}

TEST_CASE("an addend that is the input, too, gets both adjoints", "[nn][network][convolution][gradient]") {
  OperatorNetwork test = network_of({{1, 4, 5, 5}, {4, 4, 3, 3}, 1, {1, 1}, {1, 1}, {1, 1, 1, 1}});
  test.node.operation = "FusedConv";
  test.operands.insert(test.operands.begin() + 1, TestOperand{});
  auto description = test.description();
  for (nn::Node& node : description.nodes)
    if (node.operation == "FusedConv") node.inputs[1] = node.inputs[0];
  const nn::Network<double> network(description), apart(test.description());
  Objective ignored;
  const auto both = gradients_of(test, network, ignored), one = gradients_of(test, apart, ignored);
  const auto u = random_values(100, 77), v = random_values(100, 78);
  for (std::size_t i = 0; i < 100; ++i) CHECK(both[0][i] == Approx(one[0][i] + u[i] + v[i]).margin(1e-13));
}

TEST_CASE("Conv refuses what does not fit", "[nn][network][convolution]") {
  const auto refusal = [](const Case& c) { return refusal_of(network_of(c)); };
  CHECK(refusal({{1, 3, 7}, {4, 3, 3}}) ==
        "test.onnx: 2 nodes cannot be run: Conv \"y\" (opset 13): attribute 'dilations' has 2 numbers, "
        "expected 1; Conv \"z\" (opset 13): attribute 'dilations' has 2 numbers, expected 1");
  CHECK_THAT(refusal({{1, 3, 7, 7, 7}, {4, 3, 3, 3, 3}}),
             contains("attribute 'strides' has 2 numbers, expected 3"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 3, 3}}), contains("the weights are [4, 3, 3], expected four axes"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 2, 3, 3}}),
             contains("weights [4, 2, 3, 3] in 1 groups do not fit 3 channels"));
  CHECK_THAT(refusal({{1, 4, 7, 7}, {5, 2, 3, 3}, 2}), contains("in 2 groups do not fit 4 channels"));
  CHECK_THAT(refusal({{1, 4, 7, 7}, {4, 4, 3, 3}, 0}), contains("'group' is out of range: 0"));
  CHECK_THAT(refusal({{1, 3, 2, 7}, {4, 3, 3, 3}}), contains("a window of 3 does not fit into 2 rows"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 3, 3, 3}, 1, {0, 1}}), contains("'strides' is out of range: 0"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 3, 3, 3}, 1, {1}}), contains("'strides' has 1 values, expected 2"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 3, 3, 3}, 1, {1, 1}, {1, 1}, {-1, 0, 0, 0}}),
             contains("'pads' is out of range: -1"));
  CHECK_THAT(refusal({{1, 3, 0, 7}, {4, 3, 3, 3}}), contains("input 0 is empty"));
  OperatorNetwork test = network_of(cases()[0]);
  test.node.attributes["auto_pad"] = std::string("SAME");
  CHECK_THAT(refusal_of(test), contains("attribute 'auto_pad' is 'SAME'"));
  test = network_of(cases()[0]);
  test.node.attributes["kernel_shape"] = Integers{3, 2};
  CHECK_THAT(refusal_of(test), contains("'kernel_shape' is [3, 2], but the weights have [3, 3]"));
  test = network_of(cases()[0]);
  test.operands[2] = weight({5}, 1);
  CHECK_THAT(refusal_of(test), contains("the bias is [5], expected [4]"));
}
