#include <tapestry/nn/network/staged_network.hpp>

#include "../../../support/operator_case.hpp"

namespace nn = tapestry::nn;
using namespace tapestry::test;

namespace {
using Numbers = std::vector<double>;

nn::Constant zero_point(double value, std::int32_t file_type) {
  return {{}, nn::ElementType::integer, Numbers{value}, file_type};
}

OperatorCase quantised(std::int32_t file_type, double zero) {
  OperatorCase given{"QuantizeLinear", {{6}}};
  given.constants[1] = {{}, nn::ElementType::floating, Numbers{0.5}};
  given.constants[2] = zero_point(zero, file_type);
  return given;
}
const Numbers numbers_around{-1000, -0.75, -0.25, 0.25, 0.6, 1000};
}  // namespace

TEST_CASE("QuantizeLinear rounds halves to even and keeps within the integers of the file",
          "[nn][network][quantised]") {
  CHECK(results_of(quantised(2, 10), {numbers_around}) == Numbers{0, 8, 10, 10, 11, 255});
  CHECK(results_of(quantised(3, 10), {numbers_around}) == Numbers{-128, 8, 10, 10, 11, 127});
  CHECK(results_of(quantised(5, 0), {{-1e6, -1, 0, 1, 2, 1e6}}) == Numbers{-32768, -2, 0, 2, 4, 32767});
  OperatorCase stated = quantised(0, 0);
  stated.attributes["output_dtype"] = std::int64_t(3);
  CHECK(results_of(stated, {numbers_around}) == Numbers{-128, -2, 0, 0, 1, 127});
  CHECK_THAT(complaint_of(quantised(17, 0)), contains("integers of ONNX's type 17 are not supported"));
}

TEST_CASE("the gradient of rounding goes straight through, and stops beyond the range",
          "[nn][network][quantised]") {
  OperatorRun run(description_of(quantised(2, 10)));
  for (std::size_t i = 0; i < 6; ++i) run.inputs[0].data()[i] = numbers_around[i];
  run.forward(nn::Mode::input_gradient);
  const Numbers gradient = run.gradient(1).front();
  for (std::size_t i = 0; i < 6; ++i) {
    const double inside = i == 0 || i == 5 ? 0 : 2;  // 1 / scale
    CHECK(gradient[i] == Approx(1 + inside * std::cos(1.0 + static_cast<double>(i))));
  }
}

TEST_CASE("DequantizeLinear has a scale for each place along an axis", "[nn][network][quantised]") {
  OperatorCase given{"DequantizeLinear", {{2, 3}}};
  given.constants[1] = numbers({3}, {0.5, 2, 4});
  given.constants[2] = {{3}, nn::ElementType::integer, Numbers{1, 0, 2}, 2};
  CHECK(results_of(given, {{3, 1, 2, 1, 5, 4}}, nn::ElementType::integer) == Numbers{1, 2, 0, 0, 10, 8});
  given.attributes["axis"] = std::int64_t(0);
  CHECK_FALSE(complaint_of(given).empty());  // three scales for an axis of two
  given.attributes["block_size"] = std::int64_t(2);
  CHECK_THAT(complaint_of(given), contains("'block_size' is not supported"));
}

TEST_CASE("filters of a smaller picture reach as far as its pixels are large", "[nn][network][resize]") {
  for (const bool is_cubic : {false, true}) {
    OperatorCase given{"Resize", {{1, 1, 1, 12}}, {{"antialias", std::int64_t(1)}}, {}, 18};
    given.attributes["mode"] = std::string(is_cubic ? "cubic" : "linear");
    given.attributes["exclude_outside"] = std::int64_t(1);
    given.constants[1] = numbers({0}, {});
    given.constants[2] = numbers({4}, {1, 1, 1, 0.25});
    Numbers x(12), expected;
    for (std::size_t i = 0; i < 12; ++i) x[i] = std::sin(1.7 * static_cast<double>(i));
    for (std::size_t o = 0; o < 3; ++o) {
      const double centre = (static_cast<double>(o) + 0.5) * 4 - 0.5;
      double sum = 0, weights = 0;
      for (std::size_t i = 0; i < 12; ++i) {
        const double d = std::abs(static_cast<double>(i) - centre) / 4, a = -0.75;
        double weight = d < 1 ? 1 - d : 0;
        if (is_cubic) {
          weight = d < 2 ? a * (d * d * d - 5 * d * d + 8 * d - 4) : 0;
          if (d < 1) weight = (a + 2) * d * d * d - (a + 3) * d * d + 1;
        }
        sum += weight * x[i];
        weights += weight;
      }
      expected.push_back(sum / weights);
    }
    const Numbers found = results_of(given, {x});
    for (std::size_t o = 0; o < 3; ++o) CHECK(found[o] == Approx(expected[o]).epsilon(1e-12));
    check_operator(given);
  }
}
