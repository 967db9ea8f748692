#include <tapestry/nn/activation.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../support/catch.hpp"

namespace nn = tapestry::nn;
using nn::Activation;

namespace {
constexpr auto all = nn::activations;
}

TEST_CASE("activations equal their formulas", "[nn][activation]") {
  for (const double x : {-30.0, -3.0, -0.5, 0.0, 0.25, 2.0, 25.0}) {
    CHECK(nn::activate(Activation::leaky, x) == (x > 0 ? x : 0.1 * x));
    CHECK(nn::activate(Activation::relu, x) == (x > 0 ? x : 0.0));
    CHECK(nn::activate(Activation::logistic, x) == Approx(1 / (1 + std::exp(-x))).epsilon(1e-14));
    CHECK(nn::activate(Activation::swish, x) == Approx(x / (1 + std::exp(-x))).epsilon(1e-14));
    CHECK(nn::activate(Activation::mish, x) == Approx(x * std::tanh(std::log1p(std::exp(x)))).epsilon(1e-13));
    CHECK(nn::activate(Activation::relu6, x) == std::min(std::max(x, 0.0), 6.0));
    CHECK(nn::activate(Activation::elu, x) == Approx(x > 0 ? x : std::exp(x) - 1).epsilon(1e-14));
    CHECK(nn::activate(Activation::tanh, x) ==
          Approx(1 - 2 / (std::exp(2 * x) + 1)).epsilon(1e-13).margin(1e-16));
  }
  for (const auto& [x, expected] :
       {std::pair(-3.0, 0.0), {-2, 0}, {-1, -0.5}, {-0.5, -0.375}, {0, 0}, {3, 3}})
    CHECK(nn::activate(Activation::hard_mish, x) == expected);  // x·min(2, max(0, x + 2))/2
}

TEST_CASE("activation slopes agree with central differences", "[nn][activation][gradient]") {
  const double h = std::cbrt(std::numeric_limits<double>::epsilon());
  for (const Activation activation : all)
    for (const double x : {-30.0, -3.0, -0.5, 0.25, 2.0, 19.0, 25.0}) {
      const double difference = (nn::activate(activation, x + h) - nn::activate(activation, x - h)) / (2 * h);
      // Truncation h²/6·f''' and rounding ε|f|/h, both about ε^(2/3) of |x|.
      CHECK(std::abs(nn::activation_slope(activation, x) - difference) <=
            4 * h * h * std::max(1.0, std::abs(x)));
    }
}

TEST_CASE("activations stay finite for huge arguments and keep NaN", "[nn][activation]") {
  for (const Activation activation : all) {
    for (const double x : {-1e4, -100.0, 100.0, 1e4}) {
      CHECK(std::isfinite(nn::activate(activation, x)));
      CHECK(std::isfinite(nn::activation_slope(activation, x)));
    }
    CHECK(std::isnan(nn::activate(activation, std::numeric_limits<float>::quiet_NaN())));
  }
  CHECK(nn::activation_slope(Activation::leaky, 0.0) == 0.1);
  CHECK(nn::activation_slope(Activation::relu, 0.0) == 0.0);
  CHECK(nn::activation_slope(Activation::relu6, 0.0) == 0.0);
  CHECK(nn::activation_slope(Activation::relu6, 6.0) == 0.0);
  CHECK(nn::activation_slope(Activation::hard_mish, -2.0) == 0.0);
  CHECK(nn::activation_slope(Activation::elu, 0.0) == 1.0);
  CHECK(nn::activation_slope(Activation::tanh, 20.0) == Approx(4 * std::exp(-40.0)).epsilon(1e-12));
}
