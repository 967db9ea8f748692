#include <tapestry/core/random.hpp>
#include <tapestry/evaluate/detail/rank_order.hpp>

#include <algorithm>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
/// Numbers of the values in ascending order, by the standard library.
std::vector<std::size_t> expected_order(const std::vector<float>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return values[a] < values[b]; });
  return order;
}

std::vector<std::size_t> order_of(const std::vector<float>& values) {
  const evaluate::detail::RankOrder ranks(values.data(), values.size());
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < values.size(); ++i) order.push_back(ranks[i]);
  return order;
}
}  // namespace

TEST_CASE("an order by rank is that of a stable sort", "[evaluate][rank_order]") {
  Random random(3);
  for (const std::size_t count : {0U, 1U, 2U, 7U, 2048U, 5000U}) {
    for (const double scale : {1e-44, 1e-40, 1.0, 1e30, 1e38}) {
      std::vector<float> values(count);
      for (float& value : values) value = static_cast<float>(random.uniform(-1, 1) * scale);
      CAPTURE(count, scale);
      CHECK(order_of(values) == expected_order(values));
    }
  }
}

TEST_CASE("an order by rank tells neighbours apart, and keeps equal ones in place",
          "[evaluate][rank_order]") {
  Random random(5);
  std::vector<float> values(3000);
  for (float& value : values) {
    value = static_cast<float>(std::floor(random.uniform(-3, 3)));
    if (random.uniform(0, 1) < 0.5) value = std::nextafter(value, random.uniform(0, 1) < 0.5 ? -9.0F : 9.0F);
  }
  CHECK(order_of(values) == expected_order(values));
  CHECK(order_of(std::vector<float>(500, 0.25F)) == expected_order(std::vector<float>(500, 0.25F)));
}

TEST_CASE("zeros of both signs are equal by rank, infinities the ends", "[evaluate][rank_order]") {
  using Limits = std::numeric_limits<float>;
  const std::vector<float> values{0.0F,
                                  Limits::infinity(),
                                  -0.0F,
                                  Limits::denorm_min(),
                                  -Limits::denorm_min(),
                                  -Limits::infinity(),
                                  0.0F,
                                  -0.0F,
                                  Limits::max(),
                                  Limits::lowest()};
  CHECK(order_of(values) == expected_order(values));
}
