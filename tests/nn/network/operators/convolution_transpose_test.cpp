#include <tapestry/nn/detail/network/operators/convolution_transpose.hpp>

#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
struct Case {
  nn::Shape x, weights;
  std::int64_t group = 1;
  Integers strides{1, 1}, dilations{1, 1}, pads{0, 0, 0, 0}, extra{0, 0};
};

std::vector<Case> cases() {
  return {{{1, 3, 4, 5}, {3, 2, 3, 3}},
          {{2, 3, 4, 5}, {3, 4, 2, 2}, 1, {2, 2}},
          {{1, 20, 5, 4}, {20, 17, 4, 4}, 1, {2, 2}, {1, 1}, {1, 1, 1, 1}},
          {{1, 4, 5, 4}, {4, 3, 3, 2}, 2, {2, 3}, {2, 1}, {1, 0, 2, 1}, {1, 2}},
          {{1, 2, 3, 3}, {2, 2, 1, 1}, 1, {3, 2}, {1, 1}, {0, 0, 0, 0}, {2, 1}},  // zeros between the outputs
          {{1, 16, 5, 6}, {16, 1, 3, 3}, 16, {2, 2}, {1, 1}, {1, 1, 1, 1}, {1, 1}}};
}

OperatorNetwork network_of(const Case& c, bool computed = false) {
  const std::size_t channels = c.weights[1] * static_cast<std::size_t>(c.group);
  return operator_network("ConvTranspose", {given(c.x, 1), weight(c.weights, 2), weight({channels}, 3)},
                          {{"group", c.group},
                           {"strides", c.strides},
                           {"dilations", c.dilations},
                           {"pads", c.pads},
                           {"output_padding", c.extra}},
                          13, computed);
}

/// Each input spread over the outputs, in plain loops over [N, C, H, W].
std::vector<double> reference(const Case& c, const OperatorNetwork& test, nn::Shape& shape) {
  const auto& w = c.weights;
  const auto extent = [&](std::size_t a) {
    const auto in = static_cast<std::int64_t>(c.x[2 + a]), taps = static_cast<std::int64_t>(w[2 + a]);
    return static_cast<std::size_t>((in - 1) * c.strides[a] + c.extra[a] + (taps - 1) * c.dilations[a] + 1 -
                                    c.pads[a] - c.pads[a + 2]);
  };
  const auto groups = static_cast<std::size_t>(c.group);
  shape = {c.x[0], w[1] * groups, extent(0), extent(1)};
  std::vector<double> y(nn::size_of(shape));
  for (std::size_t i = 0; i < y.size(); ++i)
    y[i] = test.operands[2].values[i / (shape[2] * shape[3]) % shape[1]];
  for (std::size_t n = 0; n < c.x[0]; ++n)
    for (std::size_t k = 0; k < c.x[1]; ++k)
      for (std::size_t i = 0; i < c.x[2]; ++i)
        for (std::size_t j = 0; j < c.x[3]; ++j)
          for (std::size_t m = 0; m < w[1]; ++m)
            for (std::size_t ty = 0; ty < w[2]; ++ty)
              for (std::size_t tx = 0; tx < w[3]; ++tx) {
                const auto row = static_cast<std::int64_t>(i) * c.strides[0] +
                                 static_cast<std::int64_t>(ty) * c.dilations[0] - c.pads[0];
                const auto column = static_cast<std::int64_t>(j) * c.strides[1] +
                                    static_cast<std::int64_t>(tx) * c.dilations[1] - c.pads[1];
                if (row < 0 || column < 0 || row >= static_cast<std::int64_t>(shape[2]) ||
                    column >= static_cast<std::int64_t>(shape[3]))
                  continue;
                const std::size_t channel = k / (c.x[1] / groups) * w[1] + m;
                y[((n * shape[1] + channel) * shape[2] + static_cast<std::size_t>(row)) * shape[3] +
                  static_cast<std::size_t>(column)] +=
                    test.operands[0].values[((n * c.x[1] + k) * c.x[2] + i) * c.x[3] + j] *
                    test.operands[1].values[((k * w[1] + m) * w[2] + ty) * w[3] + tx];
              }
  return y;
}
}  // namespace

TEST_CASE("ConvTranspose equals its definition, and its adjoints agree with central differences",
          "[nn][network][convolution][gradient]") {
  for (const Case& c : cases())
    for (const bool computed : {false, true}) {
      CAPTURE(c.x, c.weights, computed);
      const auto test = network_of(c, computed);
      nn::Shape shape;
      const auto expected = reference(c, test, shape);
      CHECK(test.network<float>().output_shape(0) == shape);
      CHECK(test.network<double>().output_shape(0) == shape);
      // Roundings of sums of products below 1, Winograd's transforms included.
      const double roundings = 40 * static_cast<double>(c.weights[0] * c.weights[2] * c.weights[3] + 1);
      CHECK(largest_difference(result_of<float>(test), expected) <= roundings * 0x1p-23);
      CHECK(largest_difference(result_of<double>(test), expected) <= roundings * 0x1p-52);
      check_adjoints(test);
    }
}

TEST_CASE("ConvTranspose cuts or fills to the shape that is asked for", "[nn][network][convolution]") {
  // Whole extents are 2·2 + 3 = 7 and 3·2 + 3 = 9.
  const auto result = [](const Integers& shape, const char* auto_pad, const Integers& pads) {
    Case c{{1, 2, 3, 4}, {2, 2, 3, 3}, 1, {2, 2}, {1, 1}, pads};
    OperatorNetwork test = network_of(c);
    if (auto_pad[0] != 0) {
      test.node.attributes.erase("pads");
      test.node.attributes["auto_pad"] = std::string(auto_pad);
      if (!shape.empty()) test.node.attributes["output_shape"] = shape;
    }
    return result_of<double>(test);
  };
  CHECK(result({6, 6}, "NOTSET", {}) == result({}, "", {1, 2, 0, 1}));
  CHECK(result({1, 2, 6, 6}, "SAME_LOWER", {}) == result({}, "", {1, 2, 0, 1}));
  CHECK(result({6, 6}, "SAME_UPPER", {}) == result({}, "", {0, 1, 1, 2}));
  CHECK(result({}, "SAME_UPPER", {}) == result({}, "", {0, 0, 1, 1}));
  CHECK(result({}, "SAME_LOWER", {}) == result({}, "", {1, 1, 0, 0}));
  CHECK(result({}, "VALID", {}) == result({}, "", {0, 0, 0, 0}));
  OperatorNetwork test = network_of({{1, 2, 3, 4}, {2, 2, 3, 3}, 1, {2, 2}});
  test.node.attributes["output_shape"] = Integers{8, 9};
  CHECK(test.network<float>().output_shape(0) == nn::Shape{1, 2, 8, 9});
}

TEST_CASE("ConvTranspose refuses what does not fit", "[nn][network][convolution]") {
  const auto refusal = [](const Case& c) { return refusal_of(network_of(c)); };
  CHECK_THAT(refusal({{1, 3, 7}, {3, 4, 3}}), contains("has 2 numbers, expected 1"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {4, 3, 3, 3}}),
             contains("weights [4, 3, 3, 3] in 1 groups do not fit 3 channels"));
  CHECK_THAT(refusal({{1, 3, 7, 7}, {3, 1, 3, 3}, 2}), contains("in 2 groups do not fit"));
  CHECK_THAT(refusal({{1, 3, 1, 1}, {3, 2, 2, 2}, 1, {1, 1}, {1, 1}, {1, 1, 1, 1}}),
             contains("nothing is left inside the padding"));
  OperatorNetwork test = network_of(cases()[0]);
  test.node.attributes["output_shape"] = Integers{8};
  CHECK_THAT(refusal_of(test), contains("'output_shape' is not of two axes"));
  CHECK_THAT(
      refusal({{1, 3, 4, 4}, {3, 2, 3, 3}, 1, {2, 3}, {1, 2}, {0, 0, 0, 0}, {1, 3}}),
      contains("attribute 'output_padding' is 3, expected less than the stride or the dilation, 3 and 2"));
  CHECK(refusal({{1, 3, 4, 4}, {3, 2, 3, 3}, 1, {1, 1}, {2, 1}, {0, 0, 0, 0}, {1, 0}}).empty());
  test = network_of(cases()[0]);
  test.operands[2] = weight({3}, 1);
  CHECK_THAT(refusal_of(test), contains("the bias is [3], expected [2]"));
}
