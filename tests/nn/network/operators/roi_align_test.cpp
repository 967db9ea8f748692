#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "../../../support/operator_case.hpp"
#include "../../../support/operator_network.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;
constexpr std::size_t channels = 2, height = 6, width = 7, size = 3;

/// A picture that is linear in its place: bilinear samples of it are exact.
TestOperand ramp() {
  TestOperand x = given({1, channels, height, width}, 1);
  for (std::size_t i = 0; i < x.values.size(); ++i) {
    const auto row = static_cast<double>(i / width % height), column = static_cast<double>(i % width);
    x.values[i] = (i < height * width ? 0.25 : -0.5) * row + 0.125 * column + 1;
  }
  return x;
}

OperatorNetwork network_of(const TestOperand& x, const Numbers& boxes, const Numbers& images,
                           std::map<std::string, nn::Attribute> attributes) {
  OperatorNetwork test;
  attributes["output_height"] = attributes["output_width"] = static_cast<std::int64_t>(size);
  test.node.operation = "RoiAlign";
  test.node.attributes = std::move(attributes);
  TestOperand of_boxes{TestOperand::Kind::given, {boxes.size() / 4, 4}, boxes};
  test.operands = {x, of_boxes, numbers(images)};
  test.opset = 16;
  return test;
}
}  // namespace

TEST_CASE("boxes within a linear picture take its values at their cells' middles", "[nn][network][roi]") {
  const TestOperand x = ramp();
  const Numbers boxes{1, 1.5, 5.5, 4.5, 2, 2, 2.5, 5};
  for (const std::int64_t samples : {0, 1, 3}) {
    const auto test = network_of(x, boxes, {0, 0}, {{"sampling_ratio", samples}});
    Numbers expected;
    for (std::size_t box = 0; box < 2; ++box)
      for (std::size_t c = 0; c < channels; ++c)
        for (std::size_t i = 0; i < size * size; ++i) {
          const double* const b = &boxes[4 * box];
          const double across = b[0] - 0.5 + (b[2] - b[0]) * (static_cast<double>(i % size) + 0.5) / size;
          const double down = b[1] - 0.5 + (b[3] - b[1]) * (static_cast<double>(i / size) + 0.5) / size;
          expected.push_back((c == 0 ? 0.25 : -0.5) * down + 0.125 * across + 1);
        }
    CHECK(largest_difference(result_of<double>(test), expected) <= 1e-14);
    CHECK(largest_difference(result_of<float>(test), expected) <= 2e-6);
    check_adjoints(test);
  }
}

TEST_CASE("boxes scale, are a pixel large at least in the old form, and may take the largest",
          "[nn][network][roi]") {
  const TestOperand x = ramp();
  const auto old =
      network_of(x, {4, 4, 4.5, 4.5}, {0},
                 {{"coordinate_transformation_mode", std::string("output_half_pixel")},
                  {"spatial_scale", 0.5},
                  {"sampling_ratio", std::int64_t(1)}});  // from (2, 2), one pixel instead of a quarter
  Numbers expected;
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < size * size; ++i)
      expected.push_back((c == 0 ? 0.25 : -0.5) * (2 + (static_cast<double>(i / size) + 0.5) / size) +
                         0.125 * (2 + (static_cast<double>(i % size) + 0.5) / size) + 1);
  CHECK(largest_difference(result_of<double>(old), expected) <= 1e-14);
  check_adjoints(old);
  TestOperand drawn = given({1, channels, height, width}, 9, 0.5, 2);
  check_adjoints(network_of(drawn, {0.7, 0.6, 5.9, 4.7}, {0}, {{"mode", std::string("avg")}}));
  auto largest = network_of(drawn, {0.7, 0.6, 5.9, 4.7}, {0}, {{"mode", std::string("max")}});
  largest.operands[1].kind = TestOperand::Kind::constant;
  check_adjoints(largest);
}

TEST_CASE("boxes that are not finite, empty or beside the picture give zeros and no gradient",
          "[nn][network][roi]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), far = 1e9;
  for (const Numbers& box : {Numbers{nan, 1, 3, 3}, Numbers{1, 1, 3, std::numeric_limits<double>::infinity()},
                             Numbers{far, far, far + 4, far + 4}, Numbers{3, 3, 1, 1}}) {
    CAPTURE(box);
    const auto test = network_of(ramp(), box, {0}, {{"sampling_ratio", std::int64_t(0)}});
    const Numbers zeros(channels * size * size);
    CHECK(result_of<double>(test) == zeros);
    const auto network = test.network<double>();
    Objective objective;
    for (const Numbers& gradient : gradients_of(test, network, objective))
      CHECK(std::ranges::all_of(gradient, [](double value) { return value == 0; }));
  }
}

TEST_CASE("RoiAlign refuses operands and modes that it does not know", "[nn][network][roi]") {
  const auto complaint = [](std::vector<nn::Shape> shapes, std::map<std::string, nn::Attribute> attributes) {
    OperatorCase given{"RoiAlign", std::move(shapes), std::move(attributes)};
    given.constants[2] = integers({0, 0});
    return complaint_of(given);
  };
  CHECK(complaint({{1, 2, 4, 4}, {2, 4}}, {}).empty());
  CHECK_THAT(complaint({{1, 2, 4, 4}, {3, 4}}, {}), contains("expected [N, C, H, W], [boxes, 4]"));
  CHECK_THAT(complaint({{1, 2, 4, 4}, {2, 4}}, {{"mode", std::string("sum")}}),
             contains("mode is 'sum', expected avg or max"));
  CHECK_THAT(complaint({{1, 2, 4, 4}, {2, 4}}, {{"output_height", std::int64_t(0)}}),
             contains("'output_height' is out of range: 0"));
}
