#include <tapestry/evaluate/paired_bootstrap.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
std::vector<double> zeros_like(const std::vector<double>& values) {
  return std::vector<double>(values.size(), 0.0);
}

/// Factor by which intervals of few pairs are wider than a bootstrap's.
double widening(double pairs, double t) { return std::sqrt(pairs / (pairs - 1)) * t / 1.959963984540054; }

/// Compares both ends of an interval, relatively or, with a margin, absolutely.
void check_interval(const std::array<double, 2>& found, double low, double high, double epsilon = 1e-5,
                    double margin = 0) {
  CHECK(found[0] == Approx(low).epsilon(epsilon).margin(margin));
  CHECK(found[1] == Approx(high).epsilon(epsilon).margin(margin));
}

/// Share of 'trials' whose interval, made from random numbers of its own, holds the truth.
template <class Draw>
double coverage(std::size_t trials, std::uint64_t seed, double truth, Draw interval_of) {
  std::size_t covered = 0;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    Random random = Random(seed).fork(trial);
    const std::array<double, 2> interval = interval_of(random, trial);
    covered += interval[0] <= truth && truth <= interval[1] ? 1U : 0U;
  }
  return static_cast<double>(covered) / static_cast<double>(trials);
}
}  // namespace

TEST_CASE("the normal quantile is the inverse of the distribution function", "[evaluate][paired_bootstrap]") {
  CHECK(evaluate::detail::normal_quantile(0.5) == Approx(0).margin(1e-15));
  CHECK(evaluate::detail::normal_quantile(0.975) == Approx(1.959963984540054).epsilon(1e-14));
  for (const double x : {-8.0, -2.5, -0.1, 0.3, 1.0, 4.0})
    CHECK(evaluate::detail::normal_quantile(evaluate::detail::normal_probability(x)) ==
          Approx(x).epsilon(1e-11));
}

TEST_CASE("acceleration and corrected probabilities equal hand values", "[evaluate][paired_bootstrap]") {
  // Deviations −¼ three times and ¾: Σd² = ¾ and Σd³ = ⅜.
  const double a = 0.375 / (6 * std::pow(0.75, 1.5));
  CHECK(evaluate::detail::acceleration({0, 0, 0, 1}, 0.25) == Approx(a).epsilon(1e-14));
  CHECK(evaluate::detail::acceleration({0, 0, 0}, 0) == 0);
  CHECK(evaluate::detail::corrected_probability(-1.96, 0, 0) == evaluate::detail::normal_probability(-1.96));
  const double shifted = 0.1 + 1.96;
  CHECK(evaluate::detail::corrected_probability(1.96, 0.1, a) ==
        evaluate::detail::normal_probability(0.1 + shifted / (1 - a * shifted)));
}

TEST_CASE("a paired bootstrap reads its interval from the distribution of means",
          "[evaluate][paired_bootstrap]") {
  // Two pairs, differences 0 and 1: resampled means are 0, ½ and 1 with probability ¼, ½ and ¼, no skewness.
  // 95 % goes from one end to the other, ½ from the mean; at 30 % both ends, 0.35 and 0.65, are within those
  // of ½. With one degree of freedom t is tan(0.95·π/2).
  const double reach = 0.5 * widening(2, std::tan(0.95 * std::numbers::pi / 2));
  check_interval(evaluate::paired_bootstrap({1, 3}, {1, 2}).interval, 0.5 - reach, 0.5 + reach);
  const auto narrow = evaluate::paired_bootstrap({1, 3}, {1, 2}, {2000, 1, 0.3});
  CHECK(narrow.interval == std::array<double, 2>{0.5, 0.5});
  CHECK(narrow.mean == 0.5);
  CHECK(narrow.pairs == 2);
}

TEST_CASE("a paired bootstrap of many normal differences has the normal interval",
          "[evaluate][paired_bootstrap]") {
  Random random(1);
  std::vector<double> first(500), second(500);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const double common = 5 * random.normal();  // pairs take it out
    first[i] = common + random.normal();
    second[i] = common + 0.4;
  }
  const auto found = evaluate::paired_bootstrap(first, second, {20000, 3});
  double squares = 0;
  for (std::size_t i = 0; i < first.size(); ++i) squares += std::pow(first[i] - second[i] - found.mean, 2);
  const double error = std::sqrt(squares) / 500;  // of the mean, with the divisor n as resampling has
  // The quantile of 20000 draws at 0.025 is uncertain by √(0.025 · 0.975 / 20000) / φ(1.96) = 0.019 errors;
  // skewness of 500 normal numbers, 0.11, moves it by less.
  check_interval(found.interval, found.mean - 1.96 * error, found.mean + 1.96 * error, 0, 0.1 * error);
  CHECK(found.mean == Approx(-0.4).margin(4 * error));
}

TEST_CASE("a paired bootstrap agrees with SciPy's BCa interval", "[evaluate][paired_bootstrap]") {
  // scipy.stats.bootstrap 1.10, method "BCa", 10⁶ resamples and more; its digits and those of 4·10⁵ draws
  // here are uncertain by about 0.0005.
  const std::vector<double> even{0.9, 0.8, 0.1, 0.0, 0.75, 0.31, -0.05, 0.62, 0.44, 0.97, 0.02, 0.5};
  // Ours are wider by √(R/(R − 1))·t/z, t(11) = 2.200985 and t(26) = 2.055529.
  auto found = evaluate::paired_bootstrap(even, zeros_like(even), {400000, 1});
  const auto narrowed = [&](std::size_t end, double by) {
    return found.mean + (found.interval[end] - found.mean) / by;
  };
  CHECK(narrowed(0, widening(12, 2.200985)) == Approx(0.24583).margin(0.003));
  CHECK(narrowed(1, widening(12, 2.200985)) == Approx(0.64333).margin(0.003));
  std::vector<double> tied(17, 0.0);
  tied.insert(tied.end(), {1, 1, 1, 1, 1, -1, 0.2, 0.1, 0.05, 0.35});
  found = evaluate::paired_bootstrap(tied, zeros_like(tied), {400000, 1});
  CHECK(narrowed(0, widening(27, 2.055529)) == Approx(0.01667).margin(0.003));
  CHECK(narrowed(1, widening(27, 2.055529)) == Approx(0.35370).margin(0.003));
}

TEST_CASE("the interval of a paired bootstrap covers the true mean about as often as it says",
          "[evaluate][paired_bootstrap][repeated]") {
  // Best confidences of 60 views that a noise leaves at u^(1/4) and an attack at u⁴, with u and v that have
  // half of their share in common: bounded, skewed, paired. Their means are 4/5 and 1/5.
  const double share = coverage(600, 5, 0.6, [](Random& random, std::size_t trial) {
    std::vector<double> first(60), second(60);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double u = random.uniform(), v = random.chance(0.5) ? u : random.uniform();
      first[i] = std::pow(u, 0.25);
      second[i] = std::pow(v, 4.0);
    }
    return evaluate::paired_bootstrap(first, second, {1000, trial}).interval;
  });
  // 0.95 with a standard deviation of 0.009; four of them below, as bootstraps of few pairs cover less.
  CHECK(share >= 0.914);
  CHECK(share <= 0.986);
}

TEST_CASE("the interval of a paired bootstrap of six views covers the true mean about as often as it says",
          "[evaluate][paired_bootstrap]") {
  // Shares p of two logistic models, differences of 0 to 1 and skewed: the six views of a small simulator.
  const auto share = [](double x) { return 1 / (1 + std::exp(-x)); };
  const auto difference = [&](Random& random) {
    const double view = 1.5 * random.normal();
    return share(view + 1) - share(view - 0.5);
  };
  Random many(3);
  double truth = 0;
  for (int i = 0; i < 200000; ++i) truth += difference(many) / 200000;
  const double found = coverage(500, 7, truth, [&](Random& random, std::size_t trial) {
    std::vector<double> differences(6);
    for (double& value : differences) value = difference(random);
    return evaluate::paired_bootstrap(differences, zeros_like(differences), {400, trial}).interval;
  });
  CHECK(found >= 0.89);  // the bootstrap alone: 0.84
  CHECK(found <= 0.98);
}

TEST_CASE("a paired bootstrap of rates holds its ties", "[evaluate][paired_bootstrap]") {
  // Found or not, in 40 views: 30 times lost, 10 times no change. A mean moves by √(¾ · ¼ / 40) = 0.068.
  std::vector<double> first(40, 1.0), second(40, 0.0);
  std::fill_n(second.begin(), 10, 1.0);
  const auto found = evaluate::paired_bootstrap(first, second);
  CHECK(found.mean == 0.75);
  check_interval(found.interval, 0.75 - 1.96 * 0.068, 0.75 + 1.96 * 0.068, 0, 0.05);
  const auto same = evaluate::paired_bootstrap(std::vector<double>(7, 0.3), std::vector<double>(7, 0.2));
  CHECK(same.interval[0] == same.interval[1]);
  CHECK(same.interval[0] == Approx(0.1));
}

TEST_CASE("a paired bootstrap follows from its seed", "[evaluate][paired_bootstrap]") {
  const std::vector<double> values{0.113, 0.707, 0.41, 0.92, 0.051, 0.33, 0.644, 0.271};
  const auto interval = [&](std::uint64_t seed) {
    return evaluate::paired_bootstrap(values, zeros_like(values), {500, seed}).interval;
  };
  CHECK(interval(1) == interval(1));
  CHECK(interval(1) != interval(2));
}

TEST_CASE("a paired bootstrap of one pair or none knows no interval", "[evaluate][paired_bootstrap]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto one = evaluate::paired_bootstrap({0.9}, {0.2});
  CHECK(one.mean == Approx(0.7));
  CHECK(one.interval == std::array<double, 2>{-infinity, infinity});
  const auto none = evaluate::paired_bootstrap({}, {});
  CHECK(none.pairs == 0);
  CHECK(none.mean == 0);
  CHECK(none.interval == std::array<double, 2>{-infinity, infinity});
}

TEST_CASE("a ratio of paired means has the interval of the mean where it is one",
          "[evaluate][paired_bootstrap]") {
  const std::vector<double> values{0.113, 0.707, 0.41, 0.92, 0.051, 0.33, 0.644, 0.271};
  const auto mean = evaluate::paired_bootstrap(values, zeros_like(values));
  const auto ratio = evaluate::paired_ratio(values, std::vector<double>(values.size(), 1.0));
  CHECK(ratio.ratio == Approx(mean.mean).epsilon(1e-14));
  check_interval(ratio.interval, mean.interval[0], mean.interval[1], 1e-12);
}

TEST_CASE("what pairs have in common does not widen the interval of their ratio",
          "[evaluate][paired_bootstrap]") {
  std::vector<double> second(40), first(40), apart(40);
  Random random(6);
  for (std::size_t i = 0; i < second.size(); ++i) {
    second[i] = random.uniform();
    first[i] = 0.75 * second[i];
    apart[i] = 0.75 * random.uniform();
  }
  const auto known = evaluate::paired_ratio(first, second);
  CHECK(known.ratio == Approx(0.75));
  check_interval(known.interval, 0.75, 0.75);
  const auto unknown = evaluate::paired_ratio(apart, second);
  CHECK(unknown.interval[0] < unknown.ratio - 0.1);
  CHECK(unknown.interval[1] > unknown.ratio + 0.1);
}

TEST_CASE("a ratio's interval covers the true ratio about as often as it says",
          "[evaluate][paired_bootstrap][repeated]") {
  // 60 views; the second numbers have an effect of u², the first half of it and noise: means ⅓ and ⅙.
  const double share = coverage(600, 7, 0.5, [](Random& random, std::size_t trial) {
    std::vector<double> first(60), second(60);
    for (std::size_t i = 0; i < first.size(); ++i) {
      const double u = random.uniform();
      second[i] = u * u;
      first[i] = 0.5 * second[i] + 0.2 * random.normal();
    }
    return evaluate::paired_ratio(first, second, {1000, trial}).interval;
  });
  CHECK(share >= 0.914);
  CHECK(share <= 0.986);
}

TEST_CASE("the ratio to a mean that may be none has no upper end, and to none is refused",
          "[evaluate][paired_bootstrap][error]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto unsure = evaluate::paired_ratio({1, 1, 1, 1}, {1, -1, 1, -0.5});
  CHECK(unsure.ratio == 8);
  CHECK(unsure.interval[1] == infinity);
  CHECK(std::isfinite(unsure.interval[0]));
  CHECK(evaluate::paired_ratio({1}, {2}) == evaluate::PairedRatio{0.5, {-infinity, infinity}});
  CHECK_THROWS_WITH(evaluate::paired_ratio({1, 2}, {1, -1}),
                    "paired_ratio: the second numbers do not have a sum above 0");
  CHECK_THROWS_AS(evaluate::paired_ratio({}, {}), DomainError);
  CHECK_THROWS_WITH(evaluate::paired_ratio({1e308, 1e308}, {1, 1}), "paired_ratio: the ratio is not finite");
  CHECK_THROWS_AS(evaluate::paired_ratio({1, 2}, {1}), ShapeError);
  CHECK_THROWS_AS(evaluate::paired_ratio({1, infinity}, {1, 1}), NumericError);
}

TEST_CASE("a paired bootstrap refuses what does not fit", "[evaluate][paired_bootstrap][error]") {
  CHECK_THROWS_WITH(evaluate::paired_bootstrap({1, 2}, {1}),
                    "paired_bootstrap: second has 1 numbers, expected 2");
  CHECK_THROWS_AS(evaluate::paired_bootstrap({1, 2}, {1}), ShapeError);
  CHECK_THROWS_WITH(evaluate::paired_bootstrap({1, std::numeric_limits<double>::quiet_NaN()}, {1, 2}),
                    "paired_bootstrap: pair 1 has a number that is not finite");
  CHECK_THROWS_WITH(evaluate::paired_bootstrap({1}, {1}, {0}),
                    "paired_bootstrap: resamples is 0, expected at least 1");
  CHECK_THROWS_WITH(evaluate::paired_bootstrap({1}, {1}, {10, 1, 1.0}),
                    "paired_bootstrap: level is 1.000000, not in (0, 1)");
}

namespace {
/// Outcomes of pairs: both, the first alone, the second alone, neither.
std::array<std::vector<bool>, 2> pairs_of(const std::array<std::size_t, 4>& counts) {
  std::array<std::vector<bool>, 2> pairs;
  for (std::size_t k = 0; k < 4; ++k) {
    pairs[0].insert(pairs[0].end(), counts[k], k < 2);
    pairs[1].insert(pairs[1].end(), counts[k], k % 2 == 0);
  }
  return pairs;
}
}  // namespace

TEST_CASE("the difference of two rates has Newcombe's interval", "[evaluate][paired_bootstrap]") {
  // Computed by the paper's formulas in another language.
  const auto check = [](const std::array<std::size_t, 4>& counts, double mean, double low, double high) {
    const auto [first, second] = pairs_of(counts);
    const auto found = evaluate::rate_difference(first, second);
    CHECK(found.pairs == first.size());
    CHECK(found.mean == Approx(mean).margin(1e-12));
    check_interval(found.interval, low, high, 1e-9);
  };
  check({20, 12, 2, 16}, 0.2, 0.056156424841748265, 0.3292069954001405);
  check({14, 5, 0, 22}, 5.0 / 41, 0.01148324138303325, 0.2264926843512112);
  check({0, 0, 0, 20}, 0, -0.16112515805281938, 0.16112515805281938);  // nothing differs: not [0, 0]
  check({0, 20, 0, 0}, 1, 0.7721346162421944, 1);
  const auto [first, second] = pairs_of({20, 12, 2, 16});
  std::array<std::vector<bool>, 2> twice;
  for (std::size_t i = 0; i < first.size(); ++i) {
    twice[0].insert(twice[0].end(), 2, first[i]);
    twice[1].insert(twice[1].end(), 2, second[i]);
  }
  const auto of_views = evaluate::rate_difference(twice[0], twice[1], 2);
  CHECK(of_views.pairs == 50);
  CHECK(of_views.interval[0] == Approx(0.056156424841748265));
  CHECK(std::isinf(evaluate::rate_difference({}, {}).interval[1]));
  CHECK_THROWS_WITH(evaluate::rate_difference({true}, {}),
                    "rate_difference: second has 0 pictures, expected 1");
}

TEST_CASE("the interval of two rates' difference holds the truth as often as it says",
          "[evaluate][paired_bootstrap][repeated]") {
  for (const std::size_t views : {20U, 80U, 400U})
    for (const auto& [both, first_alone, second_alone] :
         {std::array{0.05, 0.3, 0.02}, std::array{0.4, 0.2, 0.1}, std::array{0.1, 0.8, 0.01}}) {
      const std::array ends{both, both + first_alone, both + first_alone + second_alone};
      const auto interval_of = [&](Random& random, std::size_t) {
        std::array<std::size_t, 4> counts{};
        for (std::size_t i = 0; i < views; ++i) {
          const double u = random.uniform();
          ++counts[u < ends[0] ? 0U : u < ends[1] ? 1U : u < ends[2] ? 2U : 3U];
        }
        const auto [first, second] = pairs_of(counts);
        return evaluate::rate_difference(first, second).interval;
      };
      const double share = coverage(3000, 7, first_alone - second_alone, interval_of);
      CAPTURE(views, both, first_alone, second_alone, share);
      CHECK(share >= 0.93);
      CHECK(share <= 0.975);
    }
}
