#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/class_score.hpp>

#include "../support/catch.hpp"

namespace detect = tapestry::detect;
using detect::DecodeFamily, detect::Head;

namespace {
Head head_of(std::size_t classes, bool exclusive) {
  Head head{classes, 1, 1, {{{10.0, 20.0}}}};
  head.exclusive_classes = exclusive;
  return head;
}

/// A candidate of one cell that holds something, with these logits of its classes.
std::vector<double> channels(const std::vector<double>& of_classes) {
  std::vector<double> all{0, 0, 0, 0, 3};
  all.insert(all.end(), of_classes.begin(), of_classes.end());
  return all;
}

auto reading(const std::vector<double>& values) {
  return [&values](std::size_t channel) { return values[channel]; };
}
}  // namespace

TEST_CASE("exclusive classes have the softmax of their logits", "[detect][class_score]") {
  const auto head = head_of(3, true);
  const auto values = channels({std::log(1.0), std::log(2.0), std::log(5.0)});
  const detect::ClassScores scores(head, reading(values));
  for (std::size_t k = 0; k < 3; ++k) {
    const double expected = (k == 0 ? 1.0 : k == 1 ? 2.0 : 5.0) / 8;
    CHECK(scores(k) == Approx(expected).epsilon(1e-14));
    CHECK(tapestry::nn::logistic(detect::class_logit(head, k, reading(values))) ==
          Approx(expected).epsilon(1e-14));
  }
  const auto moved = channels({700, 700 + std::log(2.0), 700 + std::log(5.0)});  // softmax does not see it
  CHECK(detect::ClassScores(head, reading(moved))(1) == Approx(0.25).epsilon(1e-12));
}

TEST_CASE("independent classes have one logistic function each", "[detect][class_score]") {
  const auto head = head_of(2, false);
  const auto values = channels({std::log(3.0), -1});
  const detect::ClassScores scores(head, reading(values));
  CHECK(scores(0) == Approx(0.75).epsilon(1e-14));
  CHECK(detect::class_logit(head, 1, reading(values)) == -1);
  std::vector<double> adjoint(7);
  const auto add = [&](std::size_t channel, double slope) { adjoint[channel] += slope; };
  detect::class_logit_adjoint(head, 1, reading(values), 2.0, add);
  scores.adjoint([](std::size_t k) { return k == 0 ? 1.0 : 0.0; }, add);
  CHECK(adjoint == std::vector<double>{0, 0, 0, 0, 0, 0.1875, 2});
}

TEST_CASE("logits of any size give finite scores and slopes", "[detect][class_score]") {
  const auto head = head_of(3, true);
  for (const double size : {1e3, 1e4, 1e300}) {
    const auto values = channels({size, -size, size});
    const detect::ClassScores scores(head, reading(values));
    CHECK(scores(0) == 0.5);
    CHECK(scores(1) == 0);
    CHECK(detect::class_logit(head, 0, reading(values)) == 0);
    CHECK(detect::class_logit(head, 1, reading(values)) == Approx(-2 * size - std::log(2.0)).epsilon(1e-15));
    std::vector<double> adjoint(8);
    const auto add = [&](std::size_t channel, double slope) { adjoint[channel] += slope; };
    detect::class_logit_adjoint(head, 0, reading(values), 1.0, add);
    CHECK(adjoint == std::vector<double>{0, 0, 0, 0, 0, 1, 0, -1});
  }
  // Where the probability rounds to 1 its logit still has the distance.
  const auto sure = channels({60, 0, 0});
  CHECK(detect::ClassScores(head, reading(sure))(0) == 1);
  CHECK(detect::class_logit(head, 0, reading(sure)) == Approx(60 - std::log(2.0)).epsilon(1e-15));
}

TEST_CASE("a single exclusive class is sure, whatever its logit", "[detect][class_score]") {
  const auto head = head_of(1, true);
  for (const double logit : {-1e4, 0.0, 7.0}) {
    const auto values = channels({logit});
    CHECK(detect::ClassScores(head, reading(values))(0) == 1);
    CHECK(detect::class_logit(head, 0, reading(values)) == std::numeric_limits<double>::infinity());
    double slope = 0;
    detect::ClassScores(head, reading(values))
        .adjoint([](std::size_t) { return 1.0; }, [&](std::size_t, double added) { slope += added; });
    CHECK(slope == 0);
  }
}

TEST_CASE("a NaN among exclusive classes leaves none", "[detect][class_score]") {
  for (std::size_t bad = 0; bad < 3; ++bad) {
    std::vector<double> of_classes{5, 1, 2};
    of_classes[bad] = std::nan("");
    const auto values = channels(of_classes);
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(std::isnan(detect::ClassScores(head_of(3, true), reading(values))(k)));
      CHECK(std::isnan(detect::class_logit(head_of(3, true), k, reading(values))));
    }
    tapestry::Array<double, 4> logits({1, 8, 1, 1});
    for (std::size_t c = 0; c < 8; ++c) logits.data()[c] = values[c];
    CHECK(detect::decode<double>({head_of(3, true)}, {logits}, 0, 0.01, 32, 32).empty());
  }
}

TEST_CASE("of exclusive classes at most one is more likely than not", "[detect][class_score]") {
  tapestry::Array<double, 4> logits({1, 8, 1, 1});
  const auto values = channels({4, 3, 2});
  for (std::size_t c = 0; c < 8; ++c) logits.data()[c] = values[c];
  const auto found = detect::decode<double>({head_of(3, true)}, {logits}, 0, 0.5, 32, 32);
  REQUIRE(found.size() == 1);
  CHECK(found[0].class_index == 0);
  CHECK(found[0].confidence ==
        Approx(1 / (1 + std::exp(-3)) / (1 + std::exp(-1) + std::exp(-2))).epsilon(1e-14));
  CHECK(detect::decode<double>({head_of(3, false)}, {logits}, 0, 0.5, 32, 32).size() == 3);
}

TEST_CASE("exclusive classes are refused of any other family than darknet", "[detect][class_score]") {
  auto head = head_of(2, true);
  head.decode = DecodeFamily::ultralytics;
  CHECK_THROWS_WITH(
      detect::require_layout("decode", head),
      "decode: a head of the decode family ultralytics has exclusive classes, expected those of the family "
      "darknet alone");
}
