// Without sanitizers, under which there are no loops of vectors.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <random>
#include <span>
#include <tapestry/autodiff/replay.hpp>
#include <tapestry/autodiff/replay_lanes.hpp>
#include <type_traits>
#include <vector>

#include "../support/catch.hpp"

using tapestry::Guards;
using tapestry::Replay;
using tapestry::Replayable;
using tapestry::ReplayLanes;

namespace {
template <class T>
[[nodiscard]] bool same_bits(T a, T b) {
  using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
  return (a != a && b != b) || std::bit_cast<Bits>(a) == std::bit_cast<Bits>(b);
}

/// Compares each input's value and gradient with what Replay gives for it alone.
template <std::size_t Lanes, class T>
void check_against_replay(Replay<T>& alone, ReplayLanes<T, Lanes>& lanes, std::size_t width,
                          const std::vector<T>& inputs) {
  std::vector<T> gradients(inputs.size()), gradient(width);
  for (int again = 0; again < 2; ++again) {
    const auto values = lanes.gradients(inputs, gradients);
    REQUIRE(values.size() == inputs.size() / width);
    const auto values_alone = lanes.values(inputs);
    for (std::size_t n = 0; n < values.size(); ++n) {
      const std::span<const T> x(inputs.data() + n * width, width);
      REQUIRE(values[n]);
      CHECK(same_bits(*values[n], alone.gradient(x, gradient)));
      CHECK(same_bits(*values[n], values_alone.at(n).value()));
      for (std::size_t i = 0; i < width; ++i) {
        INFO("input " << n << ": " << x[0] << " " << x[1] << " " << x[2] << ", entry " << i);
        CHECK(same_bits(gradients[n * width + i], gradient[i]));
      }
    }
  }
}

/// The same of a function given for the scalars of both.
template <std::size_t Lanes, class T, class One, class Many>
void check_against_replay(const One& one, const Many& many, const std::vector<T>& start,
                          const std::vector<T>& inputs) {
  Replay<T> alone(one, start, Guards::ignore);
  ReplayLanes<T, Lanes> lanes(many, start, Guards::ignore);
  check_against_replay(alone, lanes, start.size(), inputs);
}

template <class T>
[[nodiscard]] bool is_near(T a, T b) {
  if (!std::isfinite(a) || !std::isfinite(b)) return same_bits(a, b);
  return std::abs(a - b) <= 16 * std::numeric_limits<T>::epsilon() * std::max(T(1), std::abs(b));
}

/// Compares eight inputs at once, which have the library's exp and its like, with each of them alone and with
/// three at once, bit by bit, and with Replay, which has those of C, but for rounding.
template <class T>
void check_counts_of_lanes(Replay<T>& by_c, ReplayLanes<T, 8>& eight, ReplayLanes<T, 3>& three,
                           std::size_t width, const std::vector<T>& inputs) {
  std::vector<T> gradients(inputs.size()), of_three(inputs.size()), gradient(width);
  const auto values = eight.gradients(inputs, gradients);
  const auto values_of_three = three.gradients(inputs, of_three);
  for (std::size_t n = 0; n < values.size(); ++n) {
    const std::span<const T> x(inputs.data() + n * width, width);
    INFO("input " << n << ": " << x[0] << " " << x[1] << " " << x[2]);
    CHECK(same_bits(values[n].value(), values_of_three[n].value()));
    CHECK(same_bits(values[n].value(), eight.gradients(x, gradient).front().value()));
    for (std::size_t i = 0; i < width; ++i) {
      CHECK(same_bits(gradients[n * width + i], of_three[n * width + i]));
      CHECK(same_bits(gradients[n * width + i], gradient[i]));
    }
    CHECK(is_near(values[n].value(), by_c.gradient(x, gradient)));
    for (std::size_t i = 0; i < width; ++i) {
      INFO("entry " << i);
      CHECK(is_near(gradients[n * width + i], gradient[i]));
    }
  }
}
template <class T, class One, class Eight, class Three>
void check_counts_of_lanes(const One& one, const Eight& of_eight, const Three& of_three,
                           const std::vector<T>& start, const std::vector<T>& inputs) {
  Replay<T> by_c(one, start, Guards::ignore);
  ReplayLanes<T, 8> eight(of_eight, start, Guards::ignore);
  ReplayLanes<T, 3> three(of_three, start, Guards::ignore);
  check_counts_of_lanes(by_c, eight, three, start.size(), inputs);
}

/// Inputs of three numbers, ordinary and extreme ones side by side.
template <class T>
[[nodiscard]] std::vector<T> hard_inputs() {
  using Limits = std::numeric_limits<T>;
  const T special[] = {0,
                       -T(0),
                       1,
                       -1,
                       T(0.5),
                       -T(2.5),
                       3,
                       40,
                       -100,
                       900,
                       2,
                       T(1e-9),
                       Limits::max(),
                       -Limits::max(),
                       Limits::min(),
                       Limits::denorm_min(),
                       Limits::infinity(),
                       -Limits::infinity(),
                       Limits::quiet_NaN()};
  std::mt19937 generator(5);
  std::uniform_real_distribution<T> ordinary(-3, 3);
  std::uniform_int_distribution<std::size_t> which(0, std::size(special) - 1);
  std::vector<T> inputs;
  for (int i = 0; i < 3 * 205; ++i)
    inputs.push_back(i % 4 == 3 ? special[which(generator)] : ordinary(generator));
  return inputs;
}

/// The function as a statement of its own, behind a factor that may be zero where the partial is not finite.
/// Functions are passed on as pointers, for which recordings and checks are compiled once.
template <class Function, class S>
[[nodiscard]] S behind_factor(const S* x) {
  const S y = Function{}(x);
  return (x[1] - x[1]) * y + x[2] * y;
}
template <class T, class... Functions>
void check_operations(const Functions&...) {
  const std::vector<T> start = {T(0.5), T(0.25), T(1.5)};
  const auto inputs = hard_inputs<T>();
  (check_against_replay<8>(&behind_factor<Functions, Replayable<T>>,
                           &behind_factor<Functions, Replayable<T, 8>>, start, inputs),
   ...);
}
template <class T, class... Functions>
void check_functions(const Functions&...) {
  const std::vector<T> start = {T(0.5), T(0.25), T(1.5)};
  const auto inputs = hard_inputs<T>();
  (check_counts_of_lanes(&behind_factor<Functions, Replayable<T>>,
                         &behind_factor<Functions, Replayable<T, 8>>,
                         &behind_factor<Functions, Replayable<T, 3>>, start, inputs),
   ...);
}
}  // namespace

TEST_CASE("lanes have the bits of a replay of each input alone, for every operation of C",
          "[autodiff][replay]") {
  const auto check = [](const auto&... functions) { check_operations<double>(functions...); };
  check([](const auto* x) { return x[0] + x[1]; }, [](const auto* x) { return x[0] - x[1]; },
        [](const auto* x) { return x[0] * x[1]; }, [](const auto* x) { return x[0] / x[1]; },
        [](const auto* x) { return -x[0]; }, [](const auto* x) { return x[0] * x[0] + x[1] * x[0]; },
        [](const auto* x) { return 1 / (2 - 3 * x[0]) + 4; });
  check([](const auto* x) { return exp2(x[0]); }, [](const auto* x) { return exp10(x[0]); },
        [](const auto* x) { return expm1(x[0]); }, [](const auto* x) { return log2(x[0]); },
        [](const auto* x) { return log10(x[0]); });
  check([](const auto* x) { return sin(x[0]); }, [](const auto* x) { return cos(x[0]); },
        [](const auto* x) { return tan(x[0]); }, [](const auto* x) { return asin(x[0]); },
        [](const auto* x) { return acos(x[0]); }, [](const auto* x) { return atan(x[0]); },
        [](const auto* x) { return atan2(x[0], x[1]); }, [](const auto* x) { return sinh(x[0]); },
        [](const auto* x) { return cosh(x[0]); }, [](const auto* x) { return asinh(x[0]); },
        [](const auto* x) { return acosh(x[0]); }, [](const auto* x) { return atanh(x[0]); });
  check([](const auto* x) { return sqrt(x[0]); }, [](const auto* x) { return cbrt(x[0]); },
        [](const auto* x) { return square(x[0]); }, [](const auto* x) { return pow(x[0], x[1]); },
        [](const auto* x) { return pow(x[0], 3); }, [](const auto* x) { return hypot(x[0], x[1]); },
        [](const auto* x) { return hypot(x[0], x[1], x[2]); }, [](const auto* x) { return ldexp(x[0], 3); },
        [](const auto* x) { return fma(x[0], x[1], x[2]); },
        [](const auto* x) { return lerp(x[0], x[1], x[2]); });
  check([](const auto* x) { return abs(x[0]); }, [](const auto* x) { return max(x[0], x[1]); },
        [](const auto* x) { return min(x[0], x[1]); }, [](const auto* x) { return fmax(x[0], x[1]); },
        [](const auto* x) { return fmin(x[0], x[1]); }, [](const auto* x) { return clamp(x[0], -1, 1); },
        [](const auto* x) { return fdim(x[0], x[1]); }, [](const auto* x) { return fmod(x[0], x[1]); },
        [](const auto* x) { return remainder(x[0], x[1]); },
        [](const auto* x) { return copysign(x[0], x[1]); });
  check([](const auto* x) { return erf(x[0]); }, [](const auto* x) { return erfc(x[0]); },
        [](const auto* x) { return tgamma(x[0]); }, [](const auto* x) { return lgamma(x[0]); },
        [](const auto* x) { return digamma(x[0]); });
}

TEMPLATE_TEST_CASE("lanes have the bits of a replay where several operations are one statement",
                   "[autodiff][replay]", float, double) {
  check_operations<TestType>(
      [](const auto* x) { return (x[1] - x[1]) * sqrt(x[0]) + x[2] / x[0]; },
      [](const auto* x) { return (x[1] - x[1]) * exp2(x[0] * x[1]) - sinh(x[2] * x[0] - 1); },
      [](const auto* x) { return max((x[1] - x[1]) * log2(x[0]), 1 / x[2]) * pow(x[0], x[1]); });
}

TEMPLATE_TEST_CASE("the bits of exp and its like are those of one lane, and near those of C, at every number",
                   "[autodiff][replay]", float, double) {
  check_functions<TestType>(
      [](const auto* x) { return exp(x[0]); }, [](const auto* x) { return log(x[0]); },
      [](const auto* x) { return log1p(x[0]); }, [](const auto* x) { return tanh(x[0]); },
      [](const auto* x) { return sigmoid(x[0]); }, [](const auto* x) { return softplus(x[0]); },
      [](const auto* x) { return logsumexp(x[0], x[1]); });
  check_functions<TestType>(  // partial derivatives computed again, kept, and those of C beside
      [](const auto* x) { return (x[1] - x[1]) * exp(x[0] - x[1]) - tanh(x[2] * 1e-3 - 1); },
      [](const auto* x) { return 1 / (1 + exp(-x[0])); },
      [](const auto* x) { return max((x[1] - x[1]) * log(x[0]), 1 / x[2]) + sin(x[1]) * sigmoid(x[1]); });
}

TEST_CASE("a comparison of exp comes out in lanes as when they were recorded", "[autodiff][replay]") {
  const auto f = [](const auto* x) {
    using S = std::remove_cvref_t<decltype(*x)>;
    const S y = exp(x[0]);
    return y > std::exp(x[0].value()) ? S(2 * y) : y == std::exp(x[0].value()) ? S(3 * y) : y;
  };
  for (int i = 0; i < 200; ++i) {  // of which some differ from C by a rounding
    const std::vector<double> start = {0.01 * i};
    CHECK(ReplayLanes<double>(f, start).values(start).front());
  }
}

TEST_CASE("lanes have the bits of a replay in a computation of many windows", "[autodiff][replay]") {
  const auto of = [](const auto& with_exp) {
    return [&](const auto* x) {
      using S = std::remove_cvref_t<decltype(*x)>;
      const S early = x[0] * x[1];  // read throughout
      const S constant = 0.75;
      S a = x[1], b = x[2] / 2, total = 0;
      for (int i = 0; i < 9000; ++i) {
        a = constant * b - 0.5 * a * early;
        b = 0.25 * b + a * x[2] / (1 + square(a));
        if (i % 100 == 0) a = atan(a) + exp2(-b * b);
        if (i % 100 == 50) a = with_exp(a, b);
        total += max(a, b) * x[i % 3];
      }
      return total + early;
    };
  };
  const auto without = [](const auto& a, const auto&) { return a; };
  const auto with = [](const auto& a, const auto& b) {
    return std::remove_cvref_t<decltype(a)>(tanh(a) + exp(-b * b) - 1);
  };
  const auto f = of(without);
  std::vector<double> inputs;
  std::mt19937 generator(6);
  for (int i = 0; i < 3 * 21; ++i) inputs.push_back(std::uniform_real_distribution<double>(-1, 1)(generator));
  check_against_replay<8>(f, f, std::vector<double>{0.5, 0.25, 0.75}, inputs);
  check_counts_of_lanes(of(with), of(with), of(with), std::vector<double>{0.5, 0.25, 0.75}, inputs);
  inputs[3 * 4] = std::numeric_limits<double>::quiet_NaN();
  inputs[3 * 10 + 1] = std::numeric_limits<double>::infinity();
  check_against_replay<16>(f, f, std::vector<double>{0.5, 0.25, 0.75}, inputs);
}

TEST_CASE("lanes have the bits of a replay where results are computed again on the way backwards",
          "[autodiff][replay]") {
  const auto f = [](const auto* x) {  // many statements of one kind side by side
    using S = std::remove_cvref_t<decltype(*x)>;
    S total = 0;
    for (int i = 0; i < 3000; ++i) {
      const S a = x[i % 3] * x[0] + 0.001 * i;
      const S b = a * x[1] - x[2];
      const S c = sqrt(1 + b * b);
      total += c * a - b;
    }
    return total;
  };
  std::vector<double> inputs;
  std::mt19937 generator(8);
  for (int i = 0; i < 3 * 11; ++i) inputs.push_back(std::uniform_real_distribution<double>(-1, 1)(generator));
  check_against_replay<8>(f, f, std::vector<double>{0.5, 0.25, 0.75}, inputs);
}
