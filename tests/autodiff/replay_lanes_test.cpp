#include <tapestry/autodiff/replay_lanes.hpp>

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "../support/catch.hpp"

using tapestry::DomainError;
using tapestry::Guards;
using tapestry::ReplayLanes;

TEST_CASE("lanes give the values and gradients of so many inputs at once", "[autodiff][replay]") {
  const auto f = [](const auto* x) { return exp2(x[0]) * x[1]; };
  ReplayLanes<double> replay(f, std::vector<double>{1, 1});
  for (const std::size_t count : {std::size_t(1), std::size_t(7), std::size_t(8), std::size_t(19)}) {
    std::vector<double> inputs;
    for (std::size_t n = 0; n < count; ++n) {
      inputs.push_back(static_cast<double>(n) / 8);
      inputs.push_back(2 - static_cast<double>(n));
    }
    std::vector<double> gradients(inputs.size());
    const auto values = replay.gradients(inputs, gradients);
    REQUIRE(values.size() == count);
    for (std::size_t n = 0; n < count; ++n) {  // by hand
      const double e = std::exp2(inputs[2 * n]);
      CHECK(values[n] == e * inputs[2 * n + 1]);
      CHECK(gradients[2 * n] == Approx(std::log(2.0) * e * inputs[2 * n + 1]).epsilon(1e-15));
      CHECK(gradients[2 * n + 1] == e);
    }
    CHECK(replay.values(inputs) == values);
  }
}

TEST_CASE("a lane whose comparison comes out otherwise has no value, and the others have theirs",
          "[autodiff][replay]") {
  const auto branch = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    const S y = x[0] * x[0];
    return y > x[1] + 1 ? S(y * x[1]) : S(x[1] - y);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ReplayLanes<double, 4> guarded(branch, std::vector<double>{2, 1});
  std::vector<double> gradients(12);
  const std::vector<double> inputs = {3,  1, 1, 1, nan, 1,
                                      -3, 1, 0, 5, 4,   2};  // the last two in a second pass
  const auto values = guarded.gradients(inputs, gradients);
  CHECK(values == std::vector<std::optional<double>>{9, {}, {}, 9, {}, 32});
  for (const std::size_t refused : std::vector<std::size_t>{2, 3, 4, 5, 8, 9})
    CHECK(std::isnan(gradients[refused]));
  CHECK(std::vector<double>{gradients[0], gradients[1], gradients[6], gradients[7], gradients[10],
                            gradients[11]} == std::vector<double>{6, 9, -6, 9, 16, 16});
  CHECK(guarded.values(inputs) == values);

  ReplayLanes<double, 4> ignoring(branch, std::vector<double>{2, 1}, Guards::ignore);
  CHECK(ignoring.values(std::vector<double>{1, 1}).front() == 1);  // of the branch taken when recorded
}

TEST_CASE("a NaN or an infinity in one lane is of no matter to the others", "[autodiff][replay]") {
  const auto f = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    const S root = sqrt(x[0]);
    return S(0 * root + x[0] * x[1] + 0 * sqrt(x[0]));
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  ReplayLanes<double, 4> replay(f, std::vector<double>{1, 1});
  std::vector<double> gradients(8);
  const auto values = replay.gradients(std::vector<double>{4, 3, nan, 3, 0, 3, 1, inf}, gradients);
  CHECK(values[0] == 12);
  CHECK(std::isnan(*values[1]));
  CHECK(values[2] == 0);
  CHECK(values[3] == inf);
  CHECK(gradients[0] == 3);
  CHECK(gradients[1] == 4);
  CHECK(std::isnan(gradients[3]));
  CHECK(gradients[4] == 3);  // a zero adjoint passes no infinite partial
  CHECK(gradients[5] == 0);
  CHECK(gradients[6] == inf);
  CHECK(gradients[7] == 1);
}

TEST_CASE("lanes of no input, of constants and of an input itself", "[autodiff][replay]") {
  ReplayLanes<double> f([](const auto* x) { return x[0] * x[1]; }, std::vector<double>{1, 2});
  std::vector<double> none;
  CHECK(f.gradients(none, none).empty());

  ReplayLanes<float> identity([](const auto* x) { return x[1]; }, std::vector<float>{1, 2});
  std::vector<float> gradients(4);
  CHECK(identity.gradients(std::vector<float>{5, 6, 7, 8}, gradients) ==
        std::vector<std::optional<float>>{6.0F, 8.0F});
  CHECK(gradients == std::vector<float>{0, 1, 0, 1});

  ReplayLanes<float> constant([](const auto*) { return 7; }, std::vector<float>{1, 2});
  CHECK(constant.gradients(std::vector<float>{5, 6, 7, 8}, gradients) ==
        std::vector<std::optional<float>>{7.0F, 7.0F});
  CHECK(gradients == std::vector<float>{0, 0, 0, 0});

  ReplayLanes<float> empty([](const auto*) { return 7; }, std::vector<float>{});
  CHECK(empty.values(std::vector<float>{}).empty());
  CHECK_THROWS_AS(empty.values(std::vector<float>{1}), DomainError);
}

TEST_CASE("lanes refuse counts that do not fit, and a throwing function ends a recording",
          "[autodiff][replay]") {
  ReplayLanes<double> f([](const auto* x) { return x[0] * x[1]; }, std::vector<double>{1, 2});
  std::vector<double> gradients(3);
  CHECK_THROWS_WITH(f.values(std::vector<double>{1, 2, 3}),
                    "ReplayLanes: 3 entries of inputs, recorded with 2 of them");
  CHECK_THROWS_WITH(f.gradients(std::vector<double>{1, 2}, gradients),
                    "ReplayLanes: 3 entries of gradients for 2 of inputs");
  const auto throws = [](const auto* x) -> std::remove_cvref_t<decltype(*x)> {
    if (x[0] > 0) throw std::runtime_error("user");
    return x[0];
  };
  CHECK_THROWS_AS((ReplayLanes<double>(throws, std::vector<double>{3})), std::runtime_error);
}
