#include <tapestry/core/random.hpp>
#include <tapestry/evaluate/detail/rank_order.hpp>

#include <cmath>
#include <limits>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
/// Numbers of the values in ascending order, by the standard library.
std::vector<std::size_t> expected_order(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

std::vector<std::size_t> order_of(const std::vector<double>& values) {
  const evaluate::detail::RankOrder ranks(values);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < values.size(); ++i) order.push_back(ranks[i]);
  return order;
}
}  // namespace

TEST_CASE("an order by rank is that of a stable sort", "[evaluate][rank_order]") {
  Random random(3);
  for (const std::size_t count : {0U, 1U, 2U, 7U, 2048U, 5000U}) {
    for (const double scale : {1e-320, 1e-40, 1.0, 1e30, 1e300}) {
      std::vector<double> values(count);
      for (double& value : values) value = random.uniform(-1, 1) * scale;
      CAPTURE(count, scale);
      CHECK(order_of(values) == expected_order(values));
    }
  }
}

TEST_CASE("an order by rank tells doubles apart that are one float, and keeps equal ones in place",
          "[evaluate][rank_order]") {
  Random random(5);
  std::vector<double> values(3000);
  for (double& value : values) {
    value = std::floor(random.uniform(-3, 3));
    if (random.uniform(0, 1) < 0.5) value = std::nextafter(value, random.uniform(-9, 9));
  }
  CHECK(order_of(values) == expected_order(values));
  CHECK(order_of(std::vector<double>(500, 0.25)) == expected_order(std::vector<double>(500, 0.25)));
}

TEST_CASE("zeros of both signs are equal by rank, infinities the ends", "[evaluate][rank_order]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<double> values{0.0,
                                   infinity,
                                   -0.0,
                                   1e-310,
                                   -1e-310,
                                   -infinity,
                                   0.0,
                                   -0.0,
                                   std::numeric_limits<double>::max(),
                                   std::numeric_limits<double>::lowest()};
  CHECK(order_of(values) == expected_order(values));
}
