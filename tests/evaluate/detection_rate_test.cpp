#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/two_level_difference.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
detect::Detection detection(std::size_t class_index, const detect::Box& box) {
  detect::Detection made{};
  made.class_index = class_index;
  made.confidence = 0.9;
  made.box = box;
  return made;
}

const loss::Target car{2, {10, 10, 4, 4}};
}  // namespace

TEST_CASE("a target is found by its class with an overlap of one half", "[evaluate]") {
  CHECK(evaluate::is_found({detection(2, {10, 10, 4, 4})}, car));
  CHECK(evaluate::is_found({detection(2, {10, 10, 4, 2})}, car));  // exactly one half
  CHECK_FALSE(evaluate::is_found({detection(2, {10, 10, 4, 1.99})}, car));
  CHECK_FALSE(evaluate::is_found({detection(1, {10, 10, 4, 4})}, car));
  CHECK(evaluate::is_found({detection(1, {10, 10, 4, 4}), detection(2, {10, 10, 4, 3})}, car));
  CHECK_FALSE(evaluate::is_found({}, car));
  CHECK(evaluate::is_found({detection(2, {10, 10, 4, 1.99})}, car, 0.4));
}

TEST_CASE("the Wilson interval equals tabulated values", "[evaluate]") {
  // Newcombe, Statistics in Medicine 17 (1998), table I, method 3.
  const auto check = [](std::size_t hits, std::size_t trials, double low, double high) {
    const auto interval = evaluate::wilson_interval(hits, trials);
    CHECK(interval[0] == Approx(low).margin(5e-5));
    CHECK(interval[1] == Approx(high).margin(5e-5));
  };
  check(81, 263, 0.2553, 0.3662);
  check(15, 148, 0.0624, 0.1605);
  check(0, 20, 0.0, 0.1611);
  check(1, 29, 0.0061, 0.1718);
  check(20, 20, 1 - 0.1611, 1.0);
  check(0, 0, 0.0, 1.0);
}

TEST_CASE("P@0.5 is the share of views in which the target was found", "[evaluate]") {
  const auto rate = evaluate::detection_rate({true, false, true, true});
  CHECK(rate.views == 4);
  CHECK(rate.detected == 3);
  CHECK(rate.p_at_50 == 0.75);
  CHECK(rate.interval == evaluate::wilson_interval(3, 4));
  CHECK(evaluate::detection_rate({}).p_at_50 == 0);
  CHECK(evaluate::detection_rate({}).interval == std::array<double, 2>{0.0, 1.0});
}

TEST_CASE("ASR counts only views that were found clean", "[evaluate]") {
  const auto success =
      evaluate::attack_success_rate({true, true, false, true, false}, {false, true, false, false, true});
  CHECK(success.views == 3);
  CHECK(success.hidden == 2);
  CHECK(success.rate == Approx(2.0 / 3));
  CHECK(success.interval == evaluate::wilson_interval(2, 3));
  const auto none = evaluate::attack_success_rate({false, false}, {false, true});
  CHECK(none.views == 0);
  CHECK(none.rate == 0);
  CHECK(none.interval == std::array<double, 2>{0.0, 1.0});
  CHECK_THROWS_WITH(evaluate::attack_success_rate({true}, {}),
                    "attack_success_rate: adversarial_found has 0 views, expected 1");
}

TEST_CASE("photographs of a view count as one in the interval", "[evaluate]") {
  const auto once = evaluate::wilson_interval(64, 80), four = evaluate::wilson_interval(256, 320, 4);
  CHECK(once[0] == Approx(four[0]));
  CHECK(once[1] == Approx(four[1]));
  const std::vector<bool> found{true, true, false, true}, hidden{true, false, false, false};
  CHECK(evaluate::detection_rate(found, {2}).interval == evaluate::wilson_interval(3, 4, 2));
  CHECK(evaluate::attack_success_rate(found, hidden, {2}).interval == evaluate::wilson_interval(2, 3, 2));
}

namespace {
const double t_1 = std::tan(std::numbers::pi * 0.95 / 2);  // Student's quantile, one degree of freedom

/// Wilson's interval ends at the share p whose own error reaches the estimate.
void check_wilson_end(double end, double estimate, double variance, double t) {
  const double trials = estimate * (1 - estimate) / variance;
  CHECK((estimate - end) * (estimate - end) == Approx(t * t * end * (1 - end) / trials).epsilon(1e-7));
}
}  // namespace

TEST_CASE("P@0.5 of two seeds in two views has the interval worked out by hand", "[evaluate]") {
  // Found in 3 of 4 pictures: views, seeds and the interaction have a variance of 1/16 each. A tenth of the
  // interaction counts for the views, which add nothing themselves; with two of each, ν = 1.
  const std::vector<bool> found{true, true, true, false};
  const double variance = 1.0 / 16 + 1.0 / 16 / 10;
  for (const evaluate::PictureOrder order :
       {evaluate::PictureOrder{1, 1, 2}, evaluate::PictureOrder{1, 2, 1}}) {
    const auto rate = evaluate::detection_rate(found, order);
    CHECK(rate.p_at_50 == 0.75);
    CHECK(rate.interval[0] < rate.interval[1]);
    for (const double end : rate.interval) check_wilson_end(end, 0.75, variance, t_1);
  }
}

TEST_CASE("seeds that agree by chance know a share as well as so many pictures, and no better",
          "[evaluate]") {
  std::vector<bool> found(160, true);
  Array<double, 2> with({2, 80}, 1.0);
  found[3] = found[80 + 7] = false, with(0, 3) = with(1, 7) = 0;  // of two seeds, each misses one view of 80
  const double p = 158.0 / 160, t = evaluate::detail::student_quantile(0.975, 79);
  const auto two = evaluate::detection_rate(found, {1, 1, 2}).interval,
             one = evaluate::wilson_interval(79, 80);
  for (const double end : two) check_wilson_end(end, p, p * (1 - p) / 159, t);
  CHECK(two[1] - two[0] < one[1] - one[0]);
  CHECK(evaluate::two_level_rate_difference(with, Array<double, 2>({2, 80}, 0.0), {160, p, {0, 1}})
            .interval[0] < two[0]);
}

TEST_CASE("the order of pictures is seeds, views, photographs, draws", "[evaluate]") {
  const evaluate::PictureOrder two_seeds{2, 2, 2};
  CHECK(two_seeds.pictures_a_view() == 8);
  // Two seeds, two views, two photographs of two draws: the views' shares are ½ and ½, and ¼ and 0. Each draw
  // belongs to one of several seeds.
  std::vector<bool> found(16, false);
  for (const std::size_t i : {1U, 3U, 5U, 7U, 8U}) found[i] = true;
  // Means 3/8 and ¼ of views, ½ and ⅛ of seeds, an interaction of 1/16.
  const double of_views = 2 * std::pow(1.0 / 16, 2) / 2, of_seeds = 2 * std::pow(3.0 / 16, 2) / 2,
               of_rest = 4 * std::pow(1.0 / 16, 2) / 4;
  REQUIRE(of_views == of_rest);
  for (const double end : evaluate::detection_rate(found, two_seeds).interval)
    check_wilson_end(end, 5.0 / 16, of_rest / 10 + of_seeds, t_1);
  // As pictures of one seed in four views they are 0 and 1, 0 and 1, ½ and 0, 0 and 0 of the draws.
  const double a =
      (2 * std::pow(0.5 - 5.0 / 16, 2) + std::pow(0.25 - 5.0 / 16, 2) + std::pow(5.0 / 16, 2)) / 3 / 4;
  const double b = 2 * std::pow(3.0 / 16, 2) / 2;  // means ⅛ and ½
  double rest = 0;
  for (const auto& [first, second] : {std::pair(0.0, 1.0), {0.0, 1.0}, {0.5, 0.0}, {0.0, 0.0}})
    rest += 2 * std::pow((second - first) / 2 - 3.0 / 16, 2);
  const double interaction = rest / 3 / 8, views = std::max(0.0, a - interaction) + interaction / 10;
  const double t = evaluate::detail::student_quantile(0.975, (views + b) / (views / 3 + b));
  for (const double end : evaluate::detection_rate(found, {2, 2, 1}).interval)
    check_wilson_end(end, 5.0 / 16, views + b, t);
}

TEST_CASE("ASR over seeds leaves out views that were never found clean", "[evaluate]") {
  const std::vector<bool> clean{true, true, false, true, true, false},  // of two seeds, three views
      painted{false, true, true, false, false, false}, without{true, true, true, true},
      kept{false, true, false, false};
  const evaluate::PictureOrder two_seeds{1, 1, 2};
  const auto success = evaluate::attack_success_rate(clean, painted, two_seeds);
  CHECK(success.views == 4);
  CHECK(success.hidden == 3);
  CHECK(success.interval == evaluate::attack_success_rate(without, kept, two_seeds).interval);
  CHECK(success.interval[0] == Approx(1 - evaluate::detection_rate(kept, two_seeds).interval[1]));
}

TEST_CASE("seeds and draws that do not differ leave the interval over views", "[evaluate]") {
  const std::vector<bool> same{true, false, true, true, false, true}, all(6, true);
  CHECK(evaluate::detection_rate(same, {1, 1, 2}).interval == evaluate::wilson_interval(4, 6, 2));
  CHECK(evaluate::detection_rate(all, {1, 3, 1}).interval == evaluate::wilson_interval(6, 6, 3));
  CHECK(evaluate::attack_success_rate(all, std::vector<bool>(6, false), {1, 3, 1}).interval ==
        evaluate::wilson_interval(6, 6, 3));
  CHECK(evaluate::detection_rate({true, false}, {1, 2, 1}).interval == evaluate::wilson_interval(1, 2, 2));
}

TEST_CASE("pictures that are not as many of each view are refused", "[evaluate][error]") {
  CHECK_THROWS_WITH(evaluate::detection_rate({true, false, true}, {1, 1, 2}),
                    "detection_rate: 3 pictures are not 2 of each view");
  CHECK_THROWS_WITH(evaluate::detection_rate({true, false, true}, {1, 2, 1}),
                    "detection_rate: 3 pictures are not 2 of each view");
}
