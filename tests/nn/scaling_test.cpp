#include <tapestry/nn/scaling.hpp>

#include <cstddef>
#include <vector>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace nn = tapestry::nn;
using nn::FactorOf;
using tapestry::test::random_array;

namespace {
constexpr std::size_t images = 2, pixels = 7, channels = 130;  // more than two blocks of channels

tapestry::Array<double, 3> random_factors(FactorOf kind, std::uint64_t seed) {
  return random_array<double>(
      {images, kind == FactorOf::channels ? 1 : pixels, kind == FactorOf::pixels ? 1 : channels}, seed, -1,
      1);
}

FactorOf any_kind() { return GENERATE(FactorOf::values, FactorOf::channels, FactorOf::pixels); }
}  // namespace

TEST_CASE("scaling multiplies by hand", "[nn][scaling]") {
  const std::vector<float> in{1, 2, 3, 4, 5, 6};  // 3 pixels of 2 channels
  std::vector<float> out(6);
  const auto scaled = [&](FactorOf kind, const std::vector<float>& factors) {
    nn::scale<float>(kind, 1, 3, 2, in.data(), factors.data(), out.data());
    return out;
  };
  CHECK(scaled(FactorOf::channels, {2, -1}) == std::vector<float>{2, -2, 6, -4, 10, -6});
  CHECK(scaled(FactorOf::pixels, {2, 0, -1}) == std::vector<float>{2, 4, 0, 0, -5, -6});
  CHECK(scaled(FactorOf::values, {1, 2, 3, 4, 5, 6}) == std::vector<float>{1, 4, 9, 16, 25, 36});
}

TEST_CASE("scale_adjoint adds the transposes of both linear maps", "[nn][scaling][gradient]") {
  const auto kind = any_kind();
  const auto in = random_array<double>({images, pixels, channels}, 1, -1, 1);
  const auto factors = random_factors(kind, 2);
  const auto out_adjoint = random_array<double>({images, pixels, channels}, 3, -1, 1);
  auto in_adjoint = tapestry::zeros<double, 3>(in.shape());
  auto factors_adjoint = tapestry::zeros<double, 3>(factors.shape());
  for (int half = 0; half < 2; ++half)
    nn::scale_adjoint(kind, images, pixels, channels, in.data(), factors.data(), out_adjoint.data(),
                      in_adjoint.data(), factors_adjoint.data());
  const auto scaled = [&](const auto& values, const auto& by) {
    auto out = in;
    nn::scale(kind, images, pixels, channels, values.data(), by.data(), out.data());
    return tapestry::test::dot(out, out_adjoint);
  };
  const auto in_direction = random_array<double>({images, pixels, channels}, 4, -1, 1);
  const auto factors_direction = random_factors(kind, 5);
  CHECK(tapestry::test::dot(in_adjoint, in_direction) / 2 ==
        Approx(scaled(in_direction, factors)).epsilon(1e-12));
  CHECK(tapestry::test::dot(factors_adjoint, factors_direction) / 2 ==
        Approx(scaled(in, factors_direction)).epsilon(1e-12));
}

TEST_CASE("the adjoint of values by themselves is twice the value", "[nn][scaling][gradient]") {
  const std::vector<double> in{3, -2, 0.5}, ones{1, 1, 1};
  std::vector<double> adjoint(3);
  nn::scale_adjoint<double>(FactorOf::values, 1, 3, 1, in.data(), in.data(), ones.data(), adjoint.data(),
                            adjoint.data());
  CHECK(adjoint == std::vector<double>{6, -4, 1});
}
