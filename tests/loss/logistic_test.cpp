#include <tapestry/loss/detail/logistic.hpp>

#include "../support/catch.hpp"

namespace loss = tapestry::loss;

TEST_CASE("logistic_slope keeps its digits at both ends", "[loss][logistic]") {
  CHECK(loss::logistic_slope(0.0) == 0.25);
  CHECK(loss::logistic_slope(100.0) == Approx(std::exp(-100.0)).epsilon(1e-14));
  CHECK(loss::logistic_slope(-100.0) == Approx(std::exp(-100.0)).epsilon(1e-14));
  CHECK(loss::logistic_slope(-1e6) == 0.0);
  CHECK(std::isnan(loss::logistic_slope(std::nan(""))));
}

TEST_CASE("binary_cross_entropy is the softplus of the miss", "[loss][logistic]") {
  CHECK(loss::binary_cross_entropy(0.0, 1.0) == Approx(std::log(2.0)));
  CHECK(loss::binary_cross_entropy(100.0, 0.0) == Approx(100.0).epsilon(1e-15));
  CHECK(loss::binary_cross_entropy(100.0, 1.0) == Approx(std::exp(-100.0)).epsilon(1e-14));
  CHECK(loss::binary_cross_entropy(-1e4, 1.0) == 1e4);
  CHECK(std::isnan(loss::binary_cross_entropy(std::nan(""), 0.0)));
}

TEST_CASE("logistic slopes agree with central differences", "[loss][logistic][gradient]") {
  const double h = 1e-5;  // ε^(1/3), so that the differences are good to h² ≈ 1e−10
  for (const double x : {-7.0, -1.5, 0.0, 0.3, 4.0}) {
    CHECK(loss::logistic_slope(x) ==
          Approx((tapestry::nn::logistic(x + h) - tapestry::nn::logistic(x - h)) / (2 * h)).margin(1e-10));
    for (const double wanted : {0.0, 0.3, 1.0})
      CHECK(loss::binary_cross_entropy_slope(x, wanted) ==
            Approx((loss::binary_cross_entropy(x + h, wanted) - loss::binary_cross_entropy(x - h, wanted)) /
                   (2 * h))
                .margin(1e-9));
  }
}
