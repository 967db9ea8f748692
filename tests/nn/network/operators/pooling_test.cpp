#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;
using Integers = std::vector<std::int64_t>;

namespace {
struct Case {
  nn::Shape x;
  Integers taps, strides{1, 1}, dilations{1, 1}, pads{0, 0, 0, 0};
  std::int64_t ceil_mode = 0;
};

std::vector<Case> cases() {
  return {{{1, 3, 5, 6}, {2, 2}},
          {{2, 17, 7, 8}, {3, 3}, {2, 2}, {1, 1}, {1, 1, 1, 1}},
          {{1, 16, 9, 8}, {5, 5}, {1, 1}, {1, 1}, {2, 2, 2, 2}},
          {{1, 5, 6, 7}, {3, 9}, {1, 2}, {1, 1}, {0, 4, 1, 4}},
          {{1, 4, 8, 9}, {3, 2}, {2, 1}, {2, 3}, {1, 1, 2, 0}},
          {{1, 3, 6, 6}, {3, 3}, {2, 2}, {1, 1}, {0, 0, 0, 0}, 1},
          {{1, 3, 5, 7}, {2, 3}, {3, 2}, {1, 1}, {1, 1, 0, 1}, 1}};
}

OperatorNetwork network_of(const char* operation, const Case& c) {
  auto test = operator_network(operation, {given(c.x, 1)},
                               {{"kernel_shape", c.taps}, {"strides", c.strides}, {"pads", c.pads}});
  if (c.dilations != Integers{1, 1}) test.node.attributes["dilations"] = c.dilations;
  if (c.ceil_mode != 0) test.node.attributes["ceil_mode"] = c.ceil_mode;
  return test;
}

/// Folds each window: fold(values, how many taps lie in the picture or its zeros).
template <class Fold>
std::vector<double> reference(const Case& c, const std::vector<double>& x, Fold fold) {
  const auto extent = [&](std::size_t a) {
    const std::int64_t in = static_cast<std::int64_t>(c.x[2 + a]);
    const std::int64_t room = in + c.pads[a] + c.pads[a + 2] - (c.taps[a] - 1) * c.dilations[a] - 1;
    std::int64_t out = (c.ceil_mode != 0 ? room + c.strides[a] - 1 : room) / c.strides[a] + 1;
    if (c.ceil_mode != 0 && (out - 1) * c.strides[a] >= in + c.pads[a]) --out;
    return out;
  };
  std::vector<double> y;
  const auto height = static_cast<std::int64_t>(c.x[2]), width = static_cast<std::int64_t>(c.x[3]);
  for (std::size_t plane = 0; plane < c.x[0] * c.x[1]; ++plane)
    for (std::int64_t i = 0; i < extent(0); ++i)
      for (std::int64_t j = 0; j < extent(1); ++j) {
        std::vector<double> values;
        std::size_t counted = 0;
        for (std::int64_t ty = 0; ty < c.taps[0]; ++ty)
          for (std::int64_t tx = 0; tx < c.taps[1]; ++tx) {
            const std::int64_t row = i * c.strides[0] + ty * c.dilations[0] - c.pads[0];
            const std::int64_t column = j * c.strides[1] + tx * c.dilations[1] - c.pads[1];
            if (row < height + c.pads[2] && column < width + c.pads[3]) ++counted;
            if (row < 0 || column < 0 || row >= height || column >= width) continue;
            values.push_back(x[plane * c.x[2] * c.x[3] + static_cast<std::size_t>(row * width + column)]);
          }
        y.push_back(fold(values, counted));
      }
  return y;
}

double sum_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum;
}
}  // namespace

TEMPLATE_TEST_CASE("poolings equal their definitions", "[nn][network][pooling]", float, double) {
  for (const Case& c : cases()) {
    CAPTURE(c.x, c.taps, c.ceil_mode);
    OperatorNetwork test = network_of("MaxPool", c);
    const auto x = test.operands[0].values;
    const auto largest = [](const auto& values, std::size_t) {
      return *std::max_element(values.begin(), values.end());
    };
    CHECK(largest_difference(result_of<TestType>(test), reference(c, x, largest)) == 0);
    // Rounding of sums of up to 27 values below 1.
    const double tolerance = 30 * static_cast<double>(std::numeric_limits<TestType>::epsilon());
    test = network_of("AveragePool", c);
    const auto mean = [](const auto& values, std::size_t) {
      return sum_of(values) / static_cast<double>(values.size());
    };
    CHECK(largest_difference(result_of<TestType>(test), reference(c, x, mean)) <= tolerance);
    test.node.attributes["count_include_pad"] = std::int64_t(1);
    const auto padded = [](const auto& values, std::size_t count) {
      return sum_of(values) / static_cast<double>(count);
    };
    CHECK(largest_difference(result_of<TestType>(test), reference(c, x, padded)) <= tolerance);
    test = network_of("LpPool", c);
    test.node.attributes["p"] = std::int64_t(3);
    const auto norm = [](const auto& values, std::size_t) {
      double sum = 0;
      for (const double value : values) sum += std::abs(value * value * value);
      return std::cbrt(sum);
    };
    CHECK(largest_difference(result_of<TestType>(test), reference(c, x, norm)) <= tolerance);
  }
}

TEST_CASE("poolings' adjoints agree with central differences", "[nn][network][pooling][gradient]") {
  const auto operation = GENERATE(as<std::string>(), "MaxPool", "AveragePool", "LpPool");
  for (const Case& c : cases()) {
    CAPTURE(operation, c.x, c.taps, c.ceil_mode);
    OperatorNetwork test = network_of(operation.c_str(), c);
    check_adjoints(test);
    if (operation != "AveragePool") continue;
    test.node.attributes["count_include_pad"] = std::int64_t(1);
    check_adjoints(test);
  }
}

TEMPLATE_TEST_CASE("global poolings fold a whole picture", "[nn][network][pooling][gradient]", float,
                   double) {
  for (const char* operation : {"GlobalMaxPool", "GlobalAveragePool", "GlobalLpPool"}) {
    CAPTURE(operation);
    const auto test = operator_network(operation, {given({2, 19, 13, 11}, 4)});
    const auto network = test.network<TestType>();
    CHECK(network.output_shape(0) == nn::Shape{2, 19, 1, 1});
    const auto y = result_of<TestType>(test);
    for (std::size_t plane = 0; plane < 38; ++plane) {
      const double* x = test.operands[0].values.data() + plane * 143;
      double sum = 0, squares = 0;
      for (std::size_t i = 0; i < 143; ++i) sum += x[i], squares += x[i] * x[i];
      const double expected = operation[6] == 'M'   ? *std::max_element(x, x + 143)
                              : operation[6] == 'A' ? sum / 143
                                                    : std::sqrt(squares);
      CHECK(static_cast<double>(y[plane]) ==
            Approx(expected).margin(64 * static_cast<double>(std::numeric_limits<TestType>::epsilon())));
    }
    check_adjoints(test);
  }
}

TEST_CASE("max-pooling gives the adjoint to the first of equal values and shows NaN",
          "[nn][network][pooling]") {
  OperatorNetwork test = network_of("MaxPool", {{1, 1, 1, 4}, {1, 3}});
  test.operands[0].values = {2, 2, 1, std::numeric_limits<double>::quiet_NaN()};
  const auto y = result_of<double>(test);
  CHECK(y[0] == 2);
  CHECK(std::isnan(y[1]));
  const auto network = test.network<double>();
  Objective ignored;
  const auto gradient = gradients_of(test, network, ignored);
  CHECK(gradient[0][0] != 0);
  CHECK(gradient[0][1] == 0);
}

TEST_CASE("poolings refuse what they cannot do", "[nn][network][pooling]") {
  CHECK_THAT(refusal_of(network_of("MaxPool", {{1, 3, 5}, {2, 2}})), contains("has 2 numbers, expected 1"));
  CHECK_THAT(refusal_of(network_of("MaxPool", {{1, 3, 5, 5}, {2}})), contains("'kernel_shape' has 1 values"));
  CHECK_THAT(refusal_of(network_of("AveragePool", {{1, 3, 5, 5}, {6, 2}})),
             contains("does not fit into 5 rows"));
  CHECK_THAT(refusal_of(network_of("MaxPool", {{1, 3, 1, 5}, {2, 2}, {1, 1}, {2, 1}, {1, 0, 1, 0}})),
             contains("a window lies outside the picture"));
  OperatorNetwork test = network_of("LpPool", {{1, 3, 5, 5}, {2, 2}});
  test.node.attributes["p"] = std::int64_t(0);
  CHECK_THAT(refusal_of(test), contains("attribute 'p' is out of range: 0, expected 1 to 2147483647"));
  test = network_of("MaxPool", {{1, 3, 5, 5}, {2, 2}});
  test.node.attributes.erase("kernel_shape");
  CHECK_THAT(refusal_of(test), contains("there is no 'kernel_shape'"));
  auto description = network_of("MaxPool", {{1, 3, 5, 5}, {2, 2}}).description();
  description.nodes.back().outputs.push_back("indices");
  CHECK_THROWS_WITH(nn::Network<float>(description), contains("result 1 is not supported"));
}
