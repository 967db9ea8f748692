#include <tapestry/core/finite.hpp>

#include <vector>

#include "../support/catch.hpp"

using Limits = std::numeric_limits<float>;

TEST_CASE("only NaN and the infinities are not finite", "[core][finite]") {
  for (const float value : {0.0F, -0.0F, Limits::denorm_min(), Limits::max(), Limits::lowest()})
    CHECK(tapestry::is_finite(value));
  for (const float value : {Limits::infinity(), -Limits::infinity(), Limits::quiet_NaN(),
                            -Limits::quiet_NaN(), Limits::signaling_NaN()})
    CHECK(!tapestry::is_finite(value));
}

TEST_CASE("one value that is not finite is found wherever it stands among others", "[core][finite]") {
  std::vector<float> values(37, Limits::max());
  CHECK(tapestry::are_finite(values));
  CHECK(tapestry::are_finite({}));
  for (float& value : values) {
    value = -Limits::infinity();
    CHECK(!tapestry::are_finite(values));
    value = Limits::lowest();
  }
  CHECK(tapestry::are_finite(values));
}
