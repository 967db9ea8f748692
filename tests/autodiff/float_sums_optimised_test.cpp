#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
constexpr float epsilon = std::numeric_limits<float>::epsilon();
}

TEST_CASE("a sum of 10^8 terms in float is right to the last bit or two, and so are its derivatives",
          "[autodiff][hard]") {
  const std::size_t n = 10000;
  ActiveTape<float> tape;
  const auto x = tape.input(tapestry::test::random_array<float>({n, 1}, 1, 0.5, 1));
  const auto y = tape.input(tapestry::test::random_array<float>({1, n}, 2, -0.25, 1));
  const Variable<float> total = sum(broadcast(x, {n, n}) * broadcast(y, {n, n}));  // Σ x · Σ y
  tape.reverse(total);
  double x_sum = 0, y_sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    x_sum += static_cast<double>(x.value().data()[i]);
    y_sum += static_cast<double>(y.value().data()[i]);
  }
  // Each product is rounded to float by at most ε/2 · |x·y|; the signs of y make Σ |x·y| at most 1.5 Σ x·y.
  CHECK(std::abs(static_cast<double>(total.value()) / (x_sum * y_sum) - 1) <=
        1.5 * static_cast<double>(epsilon));
  // Adjoints are floats that are added to: of x 40 times, after sums of 256 in double; of y n times.
  const double rounding = static_cast<double>(epsilon) / 2;
  for (const std::size_t i : {std::size_t(0), n / 3, n - 1}) {
    CHECK(std::abs(static_cast<double>(x.adjoint().data()[i]) / y_sum - 1) <= 40 * rounding);
    CHECK(std::abs(static_cast<double>(y.adjoint().data()[i]) / x_sum - 1) <=
          static_cast<double>(n) * rounding);
  }
}

TEST_CASE("where a running sum of floats stands still, sum() goes on", "[autodiff][hard]") {
  const std::size_t n = 100000000;
  ActiveTape<float> tape;
  const auto x = tape.input(Array<float, 1>{1});
  const Variable<float> total = sum(broadcast(x, {n}));
  tape.reverse(total);
  CHECK(total.value() == 1e8F);
  CHECK(x.adjoint()(0) == 1e8F);
  float running = 0;
  for (std::size_t i = 0; i < n; ++i) running += 1;
  CHECK(running == 16777216.0F);  // 2^24: what this test is about
}
