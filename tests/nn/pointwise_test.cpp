#include <tapestry/nn/pointwise.hpp>

#include "../support/catch.hpp"
#include "../support/random_buffer.hpp"

namespace nn = tapestry::nn;

TEMPLATE_TEST_CASE("signs kept as bits scale the adjoint of leaky, whatever the count", "[nn][pointwise]",
                   float, double) {
  using Limits = std::numeric_limits<TestType>;
  for (const auto set : tapestry::instruction_sets())
    for (const std::size_t count : {1U, 3U, 16U, 63U, 64U, 65U, 200U, 256U}) {
      const auto kernels = nn::kernels_of<TestType>(set);
      auto values = tapestry::test::random_buffer<TestType>(count, 1);
      const TestType edges[] = {// of both signs
                                0, -TestType(0), Limits::infinity(), -Limits::infinity(),
                                // of one
                                Limits::quiet_NaN(), Limits::denorm_min()};
      for (std::size_t i = 0; i < count && i < 6; ++i) values.data()[count - 1 - i] = edges[i];
      std::vector<std::uint8_t> bits((count + 7) / 8, std::uint8_t(255));
      std::vector<TestType> adjoint(count, 4);
      kernels.positive_bits(values.data(), bits.data(), count);
      kernels.leaky_adjoint(bits.data(), TestType(0.25), adjoint.data(), adjoint.data(), count);
      bool is_right = true;
      for (std::size_t i = 0; i < count; ++i)
        is_right = is_right && adjoint[i] == (values.data()[i] > 0 ? TestType(4) : TestType(1));
      CAPTURE(set, count);
      CHECK(is_right);
    }
}

TEST_CASE("signs of many values are the same bits for any number of threads", "[nn][pointwise]") {
  const auto values = tapestry::test::random_buffer<float>(200001, 1);
  std::vector<std::uint8_t> bits(200001 / 8 + 1);
  nn::positive_bits(values.data(), bits.data(), 200001);
  bool is_right = true;
  for (std::size_t i = 0; i < 200001; ++i)
    is_right = is_right && (bits[i / 8] >> i % 8 & 1) == static_cast<int>(values.data()[i] > 0);
  CHECK(is_right);
}

TEST_CASE("kernels are those of the instruction set that the environment names", "[nn][instruction_set]") {
  const char* const name = std::getenv("TAPESTRY_INSTRUCTION_SET");
  const auto set = name == nullptr ? tapestry::best_instruction_set() : tapestry::instruction_set_named(name);
  constexpr std::size_t bytes[] = {16, 32, 64, 16};
  CHECK(nn::kernels<float>().lanes == bytes[static_cast<int>(set)] / sizeof(float));
}
