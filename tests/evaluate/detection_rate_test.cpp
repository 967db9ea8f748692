#include <tapestry/evaluate/detection_rate.hpp>

#include "../support/catch.hpp"

namespace evaluate = tapestry::evaluate;
namespace detect = tapestry::detect;

namespace {

detect::Detection detection(std::size_t class_index, const detect::Box& box) {
  detect::Detection made{};
  made.class_index = class_index;
  made.confidence = 0.9;
  made.box = box;
  return made;
}

const tapestry::loss::Target car{2, {10, 10, 4, 4}};

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
  const auto none = evaluate::detection_rate({});
  CHECK(none.p_at_50 == 0);
  CHECK(none.interval == std::array<double, 2>{0.0, 1.0});
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
  const auto once = tapestry::evaluate::wilson_interval(64, 80),
             four = tapestry::evaluate::wilson_interval(256, 320, 4);
  CHECK(once[0] == Approx(four[0]));
  CHECK(once[1] == Approx(four[1]));
  const std::vector<bool> found{true, true, false, true}, hidden{true, false, false, false};
  CHECK(tapestry::evaluate::detection_rate(found, 2).interval ==
        tapestry::evaluate::wilson_interval(3, 4, 2));
  CHECK(tapestry::evaluate::attack_success_rate(found, hidden, 2).interval ==
        tapestry::evaluate::wilson_interval(2, 3, 2));
}
