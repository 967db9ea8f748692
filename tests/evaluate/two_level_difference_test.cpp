#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
const double infinity = std::numeric_limits<double>::infinity();
const double z = 1.959963984540054;                        // normal quantile at 0.975
const double t_1 = std::tan(std::numbers::pi * 0.95 / 2);  // Student's with one degree of freedom

/// Draws in views: each view, each draw and each pair has an effect.
/// \param draw_scale  of the draws' effects in standard errors of the mean over views
Array<double, 2> simulated(std::size_t draw_count, std::size_t view_count, double draw_scale, Random random) {
  Array<double, 2> differences({draw_count, view_count});
  std::vector<double> effects(view_count);
  for (double& effect : effects) {  // best confidences under noise less those under an attack: mean 3/5
    const double u = random.uniform(), v = random.chance(0.5) ? u : random.uniform();
    effect = std::pow(u, 0.25) - std::pow(v, 4.0);
  }
  for (std::size_t d = 0; d < draw_count; ++d) {
    const double of_draw = draw_scale * 0.28 / std::sqrt(static_cast<double>(view_count)) * random.normal();
    for (std::size_t v = 0; v < view_count; ++v)
      differences(d, v) = effects[v] + of_draw + 0.1 * random.normal();
  }
  return differences;
}

std::vector<double> means_over_draws(const Array<double, 2>& differences) {
  std::vector<double> means(differences.shape(1));
  for (std::size_t d = 0; d < differences.shape(0); ++d)
    for (std::size_t v = 0; v < means.size(); ++v)
      means[v] += differences(d, v) / static_cast<double>(differences.shape(0));
  return means;
}

evaluate::PairedDifference over_views(const Array<double, 2>& differences) {
  const auto means = means_over_draws(differences);
  return evaluate::paired_bootstrap(means, std::vector<double>(means.size()));
}
}  // namespace

TEST_CASE("Student's quantiles are those of tables", "[evaluate][two_level]") {
  using evaluate::detail::student_quantile;
  CHECK(student_quantile(0.975, 1) == Approx(t_1).epsilon(1e-9));
  CHECK(student_quantile(0.9, 2) == Approx(0.8 * std::sqrt(2 / (1 - 0.64))).epsilon(1e-9));  // closed form
  for (const auto& [degrees, tabled] : {std::array{2.0, 4.302653}, std::array{4.0, 2.776445},
                                        std::array{19.0, 2.093024}, std::array{30.0, 2.042272}})
    CHECK(student_quantile(0.975, degrees) == Approx(tabled).margin(5e-7));
  CHECK(student_quantile(0.975, 1e9) == Approx(z).epsilon(1e-8));
  CHECK(student_quantile(0.5, 3) == 0);
  CHECK(std::isfinite(student_quantile(1, 1)));
}

TEST_CASE("a two-level difference of two draws in two views has the interval worked out by hand",
          "[evaluate][two_level]") {
  // Views have means 1 and 3, draws ½ and 3½, and the interaction is ±½: s = 1, a = 1 − ¼ + ¼/10, b = 2¼. The
  // bootstrap of two views goes from 1 to 3, f = 2, and ν = 1 for any share.
  const auto found = evaluate::two_level_difference({{0, 1}, {2, 5}});
  const double reach = t_1 / z * std::sqrt(2 * 0.775 + z * z * 2.25);
  CHECK(found.pairs == 2);
  CHECK(found.mean == 2);
  CHECK(found.interval[0] == Approx(2 - reach).epsilon(1e-8));
  CHECK(found.interval[1] == Approx(2 + reach).epsilon(1e-8));
}

TEST_CASE("a two-level interval of shares stays within -1 to 1", "[evaluate][two_level]") {
  // As above, a tenth of it: 0.2 ± t(1)/z · √(0.0155 + z²·0.0225), which reaches to -1.9 and 2.3.
  const Array<double, 2> differences{{0, 0.1}, {0.2, 0.5}};
  const auto free = evaluate::two_level_difference(differences);
  CHECK(free.interval[0] < -1);
  CHECK(free.interval[1] > 1);
  const auto bounded = evaluate::two_level_difference(differences, {}, 1);
  CHECK(bounded.mean == free.mean);
  CHECK(bounded.interval == std::array{-1.0, 1.0});
  const Array<double, 2> near{{0.70, 0.72}, {0.74, 0.80}};  // one end only lies outside
  const auto half = evaluate::two_level_difference(near, {}, 1);
  CHECK(half.interval[0] == evaluate::two_level_difference(near).interval[0]);
  CHECK(half.interval[1] == 1);
}

TEST_CASE("a two-level difference of one draw is that of a paired bootstrap", "[evaluate][two_level]") {
  const auto differences = simulated(1, 30, 1, Random(1));
  const auto found = evaluate::two_level_difference(differences), expected = over_views(differences);
  CHECK(found.pairs == expected.pairs);
  CHECK(found.mean == expected.mean);
  CHECK(found.interval == expected.interval);
}

TEST_CASE("a two-level interval is about that over the views, and far wider where draws differ",
          "[evaluate][two_level]") {
  for (const double apart : {0.0, 0.02, 1.0}) {
    auto differences = simulated(3, 40, 0, Random(2));
    for (std::size_t v = 0; v < 40; ++v) {
      differences(0, v) -= apart;
      differences(2, v) += apart;
    }
    const auto narrow = over_views(differences).interval;
    const auto wide = evaluate::two_level_difference(differences).interval;
    CAPTURE(apart);
    if (apart > 0) {
      CHECK(wide[0] < narrow[0]);
      CHECK(wide[1] > narrow[1]);
    } else  // the interaction, 0.1 beside 0.28 of the views, is a 24th of the variance
      CHECK((wide[1] - wide[0]) / (narrow[1] - narrow[0]) == Approx(1).margin(0.1));
    // Draws one apart have a standard deviation of 1: t(2)·√⅓ = 2.48 to each side. The interaction, 0.1/√40
    // in a draw's mean, moves that by 0.03; the views add 0.01, and take as much by ν above 2. Three times
    // 0.03.
    if (apart == 1) CHECK((wide[1] - wide[0]) / 2 == Approx(4.3027 / std::sqrt(3.0)).margin(0.09));
  }
}

TEST_CASE("a two-level interval does not depend on the order of draws", "[evaluate][two_level]") {
  auto differences = simulated(4, 16, 1, Random(3));
  for (double& value : differences) value = std::round(1024 * value) / 1024;  // sums without rounding
  const auto found = evaluate::two_level_difference(differences);
  Array<double, 2> reversed(differences.shape());
  for (std::size_t d = 0; d < 4; ++d)
    for (std::size_t v = 0; v < 16; ++v) reversed(d, v) = differences(3 - d, v);
  const auto other = evaluate::two_level_difference(reversed);
  CHECK(other.mean == found.mean);
  for (const std::size_t end : {0U, 1U})
    CHECK(other.interval[end] == Approx(found.interval[end]).epsilon(1e-13));
}

TEST_CASE("a two-level interval follows from its seed, and shifts and scales with the differences",
          "[evaluate][two_level]") {
  const auto differences = simulated(3, 20, 1, Random(5));
  const auto interval = [](const Array<double, 2>& of, std::uint64_t seed) {
    return evaluate::two_level_difference(of, {500, seed}).interval;
  };
  const auto found = interval(differences, 1), other = interval(4 * differences - 1, 1);
  CHECK(interval(differences, 1) == found);
  CHECK(interval(differences, 2) != found);
  for (const std::size_t end : {0U, 1U}) CHECK(other[end] == Approx(4 * found[end] - 1).epsilon(1e-12));
}

TEST_CASE("two-level differences that are all the same have an interval without width",
          "[evaluate][two_level]") {
  const auto found = evaluate::two_level_difference(Array<double, 2>({3, 7}, 0.1));
  CHECK(found.mean == Approx(0.1));
  CHECK(found.interval == std::array{found.mean, found.mean});
}

TEST_CASE("a two-level difference of one view or none knows no interval", "[evaluate][two_level]") {
  const auto one = evaluate::two_level_difference({{0.5}, {0.75}});
  CHECK(one.pairs == 1);
  CHECK(one.mean == 0.625);
  CHECK(one.interval == std::array{-infinity, infinity});
  const auto none = evaluate::two_level_difference(Array<double, 2>({2, 0}));
  CHECK(none.pairs == 0);
  CHECK(none.mean == 0);
  CHECK(none.interval == std::array{-infinity, infinity});
}

TEST_CASE("a two-level interval holds the true mean about as often as it states",
          "[evaluate][two_level][repeated]") {
  struct Layout {
    std::size_t draws, views;
    double draw_scale;
  };
  const std::size_t trials = 400;
  for (const auto& [draws, views, draw_scale] :
       {Layout{3, 20, 1}, Layout{5, 20, 10}, Layout{3, 80, 3}, Layout{20, 80, 3}, Layout{3, 400, 10}}) {
    std::size_t covered = 0;
    for (std::size_t trial = 0; trial < trials; ++trial) {
      const auto differences = simulated(draws, views, draw_scale, Random(6).fork(trial));
      const auto [low, high] = evaluate::two_level_difference(differences, {200, trial}).interval;
      covered += low <= 0.6 && 0.6 <= high ? 1U : 0U;
    }
    const double share = static_cast<double>(covered) / static_cast<double>(trials);
    CAPTURE(draws, views, draw_scale);
    // 0.93 to 0.97 with standard deviations of 0.0128 and 0.0085, three of each. Views alone hold it in 0.87,
    // 0.31, 0.65, 0.88 and 0.29.
    CHECK(share >= 0.892);
    CHECK(share <= 0.9955);
  }
}

namespace {
/// Pictures with a found or missed car, by a logistic model of views and draws.
struct FoundPictures {
  Array<double, 2> control, camouflage;
  std::vector<bool> of_control{}, of_camouflage{};

  FoundPictures(std::size_t draws, std::size_t views, double draw_sd, Random random)
      : control({draws, views}), camouflage({draws, views}) {
    std::vector<double> view_logits(views);
    for (double& logit : view_logits) logit = 1.5 * random.normal();
    for (std::size_t d = 0; d < draws; ++d) {
      const double of_draw = draw_sd * random.normal();
      for (std::size_t v = 0; v < views; ++v) {
        const auto is_found = [&](double logit) { return random.uniform() < 1 / (1 + std::exp(-logit)); };
        of_control.push_back(is_found(view_logits[v] + 1));
        of_camouflage.push_back(is_found(view_logits[v] - 0.5 + of_draw));
        control(d, v) = of_control.back() ? 1 : 0;
        camouflage(d, v) = of_camouflage.back() ? 1 : 0;
      }
    }
  }

  [[nodiscard]] evaluate::PairedDifference difference() const {
    return evaluate::two_level_rate_difference(
        control, camouflage, evaluate::rate_difference(of_control, of_camouflage, control.shape(0)));
  }
};
}  // namespace

TEST_CASE("intervals of shares over draws hold the truth about as often as they state",
          "[evaluate][two_level][repeated]") {
  struct Layout {
    std::size_t draws, views;
    double draw_sd, most_width;  // twice what a normal interval of the true variance has, or less
  };
  const std::size_t trials = 200;
  for (const auto& [draws, views, draw_sd, most_width] :
       {Layout{1, 6, 0, 1.1}, Layout{3, 6, 0, 1.4}, Layout{3, 80, 0, 0.35}, Layout{3, 20, 1, 1.2},
        Layout{3, 80, 1, 1}, Layout{5, 80, 0.3, 0.3}, Layout{3, 400, 1, 0.95}}) {
    const FoundPictures many(400, 2000, draw_sd, Random(1));  // the truth, to 0.005 and 0.03
    const auto mean = [](const Array<double, 2>& found) {
      double sum = 0;
      for (const double share : found) sum += share / static_cast<double>(found.size());
      return sum;
    };
    const double p = mean(many.control), q = mean(many.camouflage);
    const double odds = p / (1 - p) * (1 - q) / q;
    double both = 0;
    for (std::size_t i = 0; i < many.control.size(); ++i)
      both += many.control.data()[i] * (1 - many.camouflage.data()[i]);
    const double success = both / static_cast<double>(many.control.size()) / p;
    std::size_t covered = 0, covered_odds = 0, covered_rate = 0, covered_success = 0;
    double width = 0;
    for (std::size_t trial = 0; trial < trials; ++trial) {
      const FoundPictures found(draws, views, draw_sd, Random(8).fork(trial));
      const auto [low, high] = found.difference().interval;
      covered += low <= p - q && p - q <= high ? 1U : 0U;
      width += (high - low) / static_cast<double>(trials);
      const auto ratio = evaluate::odds_ratio(found.control, found.camouflage).interval;
      covered_odds += ratio[0] <= odds && odds <= ratio[1] ? 1U : 0U;
      const evaluate::PictureOrder order{1, 1, draws};
      const auto rate = evaluate::detection_rate(found.of_camouflage, order).interval;
      covered_rate += rate[0] <= q && q <= rate[1] ? 1U : 0U;
      const auto attack =
          evaluate::attack_success_rate(found.of_control, found.of_camouflage, order).interval;
      covered_success += attack[0] <= success && success <= attack[1] ? 1U : 0U;
    }
    CAPTURE(draws, views, draw_sd);
    // 0.93 to 0.97 with standard deviations of 0.018 and 0.012, three of each; of 6 views 0.98. Over views
    // alone, Newcombe's interval held a difference in 0.45 and Wilson's a share in 0.38, for 3 draws that
    // differ by a logit in 400 views; in 0.994 for draws that agree.
    for (const std::size_t count : {covered, covered_odds, covered_rate, covered_success}) {
      CHECK(static_cast<double>(count) / static_cast<double>(trials) >= 0.88);
      if (views > 6) CHECK(static_cast<double>(count) / static_cast<double>(trials) < 0.992);
    }
    CHECK(width <= most_width);
  }
}

TEST_CASE("a two-level ratio of ones is a two-level difference, and of one draw a paired ratio",
          "[evaluate][two_level]") {
  const auto first = simulated(3, 30, 2, Random(9));
  const Array<double, 2> ones(first.shape(), 1.0);
  const auto ratio = evaluate::two_level_ratio(first, ones);
  const auto difference = evaluate::two_level_difference(first);
  CHECK(ratio.ratio == Approx(difference.mean).epsilon(1e-12));
  for (const std::size_t end : {0U, 1U})
    CHECK(ratio.interval[end] == Approx(difference.interval[end]).epsilon(1e-9));
  const auto one = simulated(1, 30, 0, Random(10)), other = simulated(1, 30, 0, Random(11));
  const auto paired = evaluate::paired_ratio(means_over_draws(one), means_over_draws(other));
  CHECK(evaluate::two_level_ratio(one, other) == paired);
  CHECK_THROWS_AS(evaluate::two_level_ratio(first, one), ShapeError);
}

TEST_CASE("a two-level ratio holds the share that seeds keep about as often as it states",
          "[evaluate][two_level][repeated]") {
  std::size_t covered = 0, covered_by_views = 0;
  const std::size_t trials = 300;
  for (std::size_t trial = 0; trial < trials; ++trial) {
    auto random = Random(12).fork(trial);
    const auto whole = simulated(3, 80, 1, random.fork(1));
    auto part = simulated(3, 80, 1, random.fork(1));
    for (std::size_t seed = 0; seed < 3; ++seed) {
      const double kept = 0.5 + 0.1 * random.normal();
      for (std::size_t view = 0; view < 80; ++view)
        part(seed, view) = kept * part(seed, view) + 0.1 * random.normal();
    }
    const auto holds = [](const evaluate::PairedRatio& ratio) {
      return ratio.interval[0] <= 0.5 && 0.5 <= ratio.interval[1] ? 1U : 0U;
    };
    covered += holds(evaluate::two_level_ratio(part, whole));
    covered_by_views +=
        holds(evaluate::paired_ratio(means_over_draws(part), means_over_draws(whole), {200, trial}));
  }
  CHECK(static_cast<double>(covered) / static_cast<double>(trials) >= 0.91);  // 0.95 less three times 0.0126
  CHECK(static_cast<double>(covered_by_views) / static_cast<double>(trials) < 0.6);
}

TEST_CASE("shares that are the same in all pictures keep an interval", "[evaluate][two_level]") {
  const Array<double, 2> all({3, 20}, 1.0);
  const std::vector<bool> found(60, true);
  const auto of_views = evaluate::rate_difference(found, found, 3);
  const auto of_draws = evaluate::two_level_rate_difference(all, all, of_views);
  CHECK(of_draws.interval == of_views.interval);
  CHECK(of_draws.interval[1] > 0.05);
  const Array<double, 2> one({1, 20}, 1.0);
  CHECK(evaluate::two_level_rate_difference(one, one, of_views).interval == of_views.interval);
  CHECK_THROWS_AS(evaluate::two_level_rate_difference(all, one, of_views), ShapeError);
  // Every view is found in one of its two photographs: the views count once, without a width of 0.
  const auto even =
      evaluate::odds_ratio(Array<double, 2>({1, 20}, 0.5), Array<double, 2>({1, 20}, 0.5), 2, 2);
  CHECK(even.ratio == 1);
  CHECK(even.interval[1] > 2);
  CHECK(std::isfinite(even.interval[1]));
}

TEST_CASE("an odds ratio and its interval equal hand values", "[evaluate][two_level]") {
  // Found in 12 of 16 views and in 4 of them: odds of 3 and 1/3. Sums of squares are 3, the sum for the
  // differences (twelve of 1 − c) is 4·¼ + 8·¼ + 4·¼ = 4; V = 3/240 twice, V₁₂ = 4/240, r = ⅓.
  Array<double, 2> control({1, 16}, 0.0), camouflage({1, 16}, 0.0);
  for (std::size_t view = 0; view < 12; ++view) control(0, view) = 1;
  for (std::size_t view = 0; view < 4; ++view) camouflage(0, view) = 1;
  const auto found = evaluate::odds_ratio(control, camouflage);
  CHECK(found.ratio == Approx(9));
  // Of one draw it is Wilson's interval, with Student's quantile and p·q / V = 15 trials: the roots x of
  // (p − x)² = t²·x·(1 − x) / 15. It is as long in log odds to both sides.
  const double square = 2.131450 * 2.131450 / 15, root = std::sqrt(square * (square / 4 + 3.0 / 16));
  const double low = (0.75 + square / 2 - root) / (1 + square),
               high = (0.75 + square / 2 + root) / (1 + square);
  const double half = std::log(high / (1 - high) * (1 - low) / low) / 2;
  const double reach = std::sqrt(2 * half * half * (1 - 1.0 / 3));
  CHECK(found.interval[0] == Approx(9 * std::exp(-reach)).epsilon(1e-5));
  CHECK(found.interval[1] == Approx(9 * std::exp(reach)).epsilon(1e-5));
  // All and none of four pictures are half a picture from the ends: (4.5/0.5)².
  CHECK(evaluate::odds_ratio({{1, 1, 1, 1}}, {{0, 0, 0, 0}}).ratio == Approx(81));
  CHECK(evaluate::odds_ratio({{1, 1}}, {{0, 0}}, 2, 2).ratio == Approx(81));
  CHECK(evaluate::odds_ratio({{1}}, {{0}}).interval == std::array{0.0, infinity});
  CHECK_THROWS_AS(evaluate::odds_ratio({{1, 0}}, {{1}}), ShapeError);
  // Draws that differ widen it.
  const auto same = evaluate::odds_ratio({{1, 1, 1, 0}, {1, 1, 0, 1}, {0, 1, 1, 1}},
                                         {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 0, 1}});
  const auto apart = evaluate::odds_ratio({{1, 1, 1, 0}, {1, 1, 0, 1}, {0, 1, 1, 1}},
                                          {{1, 1, 1, 0}, {0, 0, 0, 0}, {0, 0, 0, 0}});
  CHECK(same.ratio == Approx(apart.ratio));
  CHECK(apart.interval[1] > same.interval[1]);
}

TEST_CASE("odds of pictures are those of the sample, however many a view has", "[evaluate][two_level]") {
  // 719 of 720 pictures in 80 views, of three draws of three seeds, against 218 of 240.
  Array<double, 2> control({3, 80}, 1.0), camouflage({3, 80}, 1.0);
  control(1, 7) = 2.0 / 3;
  for (std::size_t miss = 0; miss < 22; ++miss) camouflage(miss % 3, miss) = 0;
  const auto odds = evaluate::odds_ratio(control, camouflage, 3, 1);
  CHECK(odds.ratio == Approx(719.0 / 1 * 22 / 218));  // 72.6; with half a view 14.1 [4.2, 49.7]
  CHECK(odds.interval[0] > 1);
  CHECK(odds.interval[0] < odds.ratio);
  CHECK(odds.interval[1] == infinity);  // the car is missed in one view
  control(0, 20) = control(2, 33) = 2.0 / 3;
  CHECK(std::isfinite(evaluate::odds_ratio(control, camouflage, 3, 1).interval[1]));
  Array<double, 2> rounded({2, 80}, 0.0);  // found in all of seven pictures
  for (double& share : rounded)
    for (int picture = 0; picture < 7; ++picture) share += 1.0 / 7;
  rounded(1, 3) = 1;
  const auto all = evaluate::odds_ratio(rounded, Array<double, 2>({2, 80}, 0.5), 7, 2);
  CHECK(all.ratio == Approx((2 * 80 * 7 + 0.5) / 0.5));
  CHECK(all.interval[1] == infinity);
  const auto reversed = evaluate::odds_ratio(camouflage, control, 1, 3);
  CHECK(reversed.interval[1] == Approx(1 / evaluate::odds_ratio(control, camouflage, 3, 1).interval[0]));
}

TEST_CASE("the sample's own odds and difference lie inside their intervals", "[evaluate][two_level]") {
  Random random(13);
  for (std::size_t trial = 0; trial < 400; ++trial) {
    const std::size_t draws = 1 + random.index(5), views = 2 + random.index(30),
                      pictures = 1 + random.index(3);
    const double logit = random.uniform(-1, 7), other = random.uniform(-1, 7), spread = random.uniform(0, 3);
    Array<double, 2> control({draws, views}, 0.0), camouflage({draws, views}, 0.0);
    std::array<double, 2> found{};
    for (std::size_t i = 0; i < control.size(); ++i)
      for (std::size_t picture = 0; picture < pictures; ++picture) {
        const double of_view = spread * random.normal();
        const double one = random.uniform() < 1 / (1 + std::exp(-logit - of_view)) ? 1 : 0,
                     two = random.uniform() < 1 / (1 + std::exp(-other - of_view)) ? 1 : 0;
        found[0] += one, found[1] += two;
        control.data()[i] += one / static_cast<double>(pictures);
        camouflage.data()[i] += two / static_cast<double>(pictures);
      }
    const auto all = static_cast<double>(control.size() * pictures);
    const double odds =
        found[0] * (all - found[1]) / ((all - found[0]) * found[1]);  // 0/0 where both are all
    const auto ratio = evaluate::odds_ratio(control, camouflage, pictures, pictures);
    CAPTURE(trial, draws, views, pictures, found[0], found[1], all);
    CHECK(ratio.interval[0] <= ratio.ratio);
    CHECK(ratio.ratio <= ratio.interval[1]);
    if (std::isfinite(odds) && odds > 0) CHECK(ratio.ratio == Approx(odds));
    if (!std::isnan(odds)) CHECK(ratio.interval[0] <= odds * (1 + 1e-9));
    if (!std::isnan(odds)) CHECK(odds <= ratio.interval[1] * (1 + 1e-9));
    const auto difference = evaluate::two_level_rate_difference(control, camouflage, {});
    CHECK(difference.interval[0] <= (found[0] - found[1]) / all + 1e-12);
    CHECK(difference.interval[1] >= (found[0] - found[1]) / all - 1e-12);
    if (std::isfinite(difference.interval[0])) CHECK(difference.interval[0] >= -1 - 1e-12);
    if (std::isfinite(difference.interval[1])) CHECK(difference.interval[1] <= 1 + 1e-12);
  }
}

TEST_CASE("a two-level difference refuses what does not fit", "[evaluate][two_level][error]") {
  CHECK_THROWS_AS(evaluate::two_level_difference(Array<double, 2>({0, 5})), ShapeError);
  CHECK_THROWS_WITH(evaluate::two_level_difference(Array<double, 2>({0, 5})),
                    "two_level_difference: differences is [0, 5], expected one draw or more");
  CHECK_THROWS_AS(evaluate::two_level_difference({{1, 2}, {3, infinity}}), NumericError);
  CHECK_THROWS_WITH(evaluate::two_level_difference({{1, 2}, {3, std::numeric_limits<double>::quiet_NaN()}}),
                    "two_level_difference: draw 1 of view 1 is not finite");
  CHECK_THROWS_WITH(evaluate::two_level_difference({{1e300, 2}, {3, 4}}),
                    "two_level_difference: the variance is not finite");
  CHECK_THROWS_AS(evaluate::two_level_difference({{1, 2}}, {0}), DomainError);
  CHECK_THROWS_WITH(evaluate::two_level_difference({{1, 2}}, {0}),
                    "two_level_difference: resamples is 0, expected at least 1");
  CHECK_THROWS_WITH(evaluate::two_level_difference({{1, 2}}, {10, 1, 1.0}),
                    "two_level_difference: level is 1.000000, not in (0, 1)");
}
