#include <tapestry/camouflage/objective_terms.hpp>

#include <numeric>
#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

namespace camouflage = tapestry::camouflage;
using Losses = std::vector<double>;

namespace {
double sum_of(const Losses& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// CVaR by its definition as a minimum, which one of the losses attains.
double value_at_risk(const Losses& losses, double share) {
  double least = std::numeric_limits<double>::infinity();
  for (const double z : losses) {
    double beyond = 0;
    for (const double loss : losses) beyond += std::max(0.0, loss - z);
    least = std::min(least, z + beyond / (share * static_cast<double>(losses.size())));
  }
  return least;
}
}  // namespace

TEST_CASE("the worst share of views counts, the last of them in part", "[camouflage][worst_views]") {
  const Losses losses{1, 4, 2, 3};
  CHECK(camouflage::worst_view_weights(losses, 0.5) == Losses{0, 0.5, 0, 0.5});
  CHECK(camouflage::worst_view_weights(losses, 0.375) == Losses{0, 1 / 1.5, 0, 0.5 / 1.5});
  CHECK(camouflage::worst_view_weights(losses, 1) == Losses{0.25, 0.25, 0.25, 0.25});
  CHECK(camouflage::worst_view_weights(losses, 1e-9) == Losses{0, 1, 0, 0});
  CHECK(camouflage::worst_view_weights(Losses{7}, 0.3) == Losses{1});
}

TEST_CASE("of equal losses the earlier counts first", "[camouflage][worst_views]") {
  CHECK(camouflage::worst_view_weights(Losses{2, 5, 2, 2}, 0.5) == Losses{0.5, 0.5, 0, 0});
  CHECK(camouflage::worst_view_weights(Losses{3, 3, 3, 3}, 0.25) == Losses{1, 0, 0, 0});
  CHECK(camouflage::worst_view_weights(Losses{-0.0, 0.0}, 0.5) == Losses{1, 0});
  constexpr double infinity = std::numeric_limits<double>::infinity();
  CHECK(camouflage::worst_view_weights(Losses{1, infinity, -infinity}, 1.0 / 3) == Losses{0, 1, 0});
}

TEST_CASE("the weighted losses are the conditional value at risk", "[camouflage][worst_views]") {
  tapestry::Random random(3);
  for (std::size_t n = 1; n <= 9; ++n)
    for (int draw = 0; draw < 20; ++draw) {
      Losses losses(n);
      for (double& loss : losses) loss = std::round(8 * random.normal()) / 4;  // with ties
      const double share = random.uniform(1.0 / static_cast<double>(n), 1);
      const auto weights = camouflage::worst_view_weights(losses, share);
      CHECK(sum_of(weights) == Approx(1).epsilon(1e-14));
      CHECK(std::inner_product(weights.begin(), weights.end(), losses.begin(), 0.0) ==
            Approx(value_at_risk(losses, share)).epsilon(1e-12).margin(1e-12));
    }
}

TEST_CASE("shares and losses that are none are refused", "[camouflage][worst_views]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double share : {0.0, -0.5, 1.5, nan})
    CHECK_THROWS_WITH(camouflage::worst_view_weights(Losses{1, 2}, share),
                      contains("worst_view_weights: the share is"));
  CHECK_THROWS_WITH(camouflage::worst_view_weights(Losses{}, 1), "worst_view_weights: no losses");
  CHECK_THROWS_WITH(camouflage::worst_view_weights(Losses{1, nan}, 1),
                    "worst_view_weights: a loss is not a number");
}
