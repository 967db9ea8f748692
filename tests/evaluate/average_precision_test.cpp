#include <tapestry/evaluate/average_precision.hpp>

#include <tapestry/core/random.hpp>

#include "../support/threads.hpp"

namespace evaluate = tapestry::evaluate;
using evaluate::average_precision, evaluate::ScoredBox, evaluate::TruthBox, tapestry::detect::Box,
    tapestry::detect::box_from_corners;

namespace {
TruthBox truth(std::size_t picture, const Box& box, std::size_t class_index = 0) {
  return {picture, class_index, box, box.w * box.h};
}

const Box square = box_from_corners(10, 10, 50, 50);  // of medium area
const Box elsewhere = box_from_corners(100, 100, 140, 140);

/// COCO's measures once more, slowly and from their definition: detections are drawn one by one from those
/// left, and precision is looked for over all ranks at each recall.
class BruteForce {
 public:
  std::vector<TruthBox> truths;
  std::vector<ScoredBox> detections;

  [[nodiscard]] std::optional<double> precision(std::size_t k, double low, double high, int percent) const {
    const auto ignored = [&](const TruthBox& t) {
      return t.is_crowd || t.is_ignored || t.area < low || t.area > high;
    };
    std::vector<std::pair<double, bool>> ranked;  // confidence and whether it is a hit
    std::size_t total = 0, pictures = 0;
    for (const auto& t : truths)
      if (t.class_index == k && !ignored(t)) ++total;
    if (total == 0) return std::nullopt;
    for (const auto& d : detections) pictures = std::max(pictures, d.picture + 1);
    for (std::size_t p = 0; p < pictures; ++p) {
      std::vector<bool> used(detections.size()), taken(truths.size());
      for (int n = 0; n < 100; ++n) {
        std::size_t d = detections.size();
        for (std::size_t i = 0; i < detections.size(); ++i)
          if (!used[i] && detections[i].picture == p && detections[i].class_index == k &&
              (d == detections.size() || detections[i].confidence > detections[d].confidence))
            d = i;
        if (d == detections.size()) break;
        used[d] = true;
        const auto take = [&](bool of_ignored) {
          std::size_t best = truths.size();
          double most = percent / 100.0;
          for (std::size_t i = 0; i < truths.size(); ++i) {
            const auto& t = truths[i];
            if (t.picture != p || t.class_index != k || ignored(t) != of_ignored) continue;
            if ((taken[i] && !t.is_crowd) || share(detections[d].box, t) < most) continue;
            most = share(detections[d].box, t);
            best = i;
          }
          if (best < truths.size()) taken[best] = true;
          return best < truths.size();
        };
        const double area = detections[d].box.w * detections[d].box.h;
        if (take(false))
          ranked.emplace_back(detections[d].confidence, true);
        else if (!take(true) && area >= low && area <= high)
          ranked.emplace_back(detections[d].confidence, false);
      }
    }
    return interpolated(ranked, total);
  }

 private:
  [[nodiscard]] static double share(const Box& d, const TruthBox& t) {
    const double w =
        std::min(d.cx + d.w / 2, t.box.cx + t.box.w / 2) - std::max(d.cx - d.w / 2, t.box.cx - t.box.w / 2);
    const double h =
        std::min(d.cy + d.h / 2, t.box.cy + t.box.h / 2) - std::max(d.cy - d.h / 2, t.box.cy - t.box.h / 2);
    const double shared = std::max(0.0, w) * std::max(0.0, h);
    return shared / (t.is_crowd ? d.w * d.h : d.w * d.h + t.box.w * t.box.h - shared);
  }
  [[nodiscard]] static double interpolated(std::vector<std::pair<double, bool>> ranked, std::size_t total) {
    std::sort(ranked.rbegin(), ranked.rend());
    double sum = 0;
    for (std::size_t r = 0; r <= 100; ++r) {
      double best = 0, hits = 0, seen = 0;
      for (const auto& [confidence, is_hit] : ranked) {
        hits += is_hit ? 1 : 0;
        ++seen;
        if (hits / static_cast<double>(total) >= 0.01 * static_cast<double>(r))
          best = std::max(best, hits / seen);
      }
      sum += best;
    }
    return sum / 101;
  }
};

/// Crowded pictures of few classes, many detections near the truths.
BruteForce random_case(std::uint64_t seed) {
  tapestry::Random random(seed);
  const auto number = [&](double low, double high) { return random.uniform(low, high); };
  BruteForce result;
  for (std::size_t p = 0; p < 6; ++p)
    for (std::size_t i = 0; i < 9; ++i) {
      const Box box{number(0, 200), number(0, 200), number(5, 150), number(5, 150)};
      TruthBox t = truth(p, box, i % 3);
      t.area *= number(0.5, 1);  // that of an outline
      t.is_crowd = number(0, 1) < 0.15;
      t.is_ignored = number(0, 1) < 0.15;
      result.truths.push_back(t);
      for (std::size_t n = 0; n < 3; ++n) {
        const Box near{box.cx + number(-9, 9), box.cy + number(-9, 9), box.w * number(0.7, 1.4),
                       box.h * number(0.7, 1.4)};
        result.detections.push_back({p, i % 3, near, number(0, 1)});
      }
    }
  return result;
}

void check_same(const std::optional<double>& a, const std::optional<double>& b) {
  REQUIRE(a.has_value() == b.has_value());
  if (a) CHECK(*a == Approx(*b).epsilon(1e-12));
}

bool is_same(const evaluate::PrecisionSummary& a, const evaluate::PrecisionSummary& b) {
  return a.ap == b.ap && a.ap50 == b.ap50 && a.ap75 == b.ap75 && a.ap_small == b.ap_small &&
         a.ap_medium == b.ap_medium && a.ap_large == b.ap_large && a.recall == b.recall;
}
}  // namespace

TEST_CASE("one truth that is found has an average precision of one", "[evaluate][average_precision]") {
  const auto result = average_precision({truth(0, square)}, {{0, 0, square, 0.9}}, 1);
  CHECK(result.mean.ap == 1.0);
  CHECK(result.mean.ap50 == 1.0);
  CHECK(result.mean.ap75 == 1.0);
  CHECK(result.mean.ap_medium == 1.0);
  CHECK(result.mean.recall == 1.0);
  CHECK_FALSE(result.mean.ap_small);
  CHECK_FALSE(result.mean.ap_large);
  CHECK(result.classes[0].truths == 1);
  CHECK(result.classes[0].detections == 1);
}

TEST_CASE("of two detections of one truth the second is a miss", "[evaluate][average_precision]") {
  const std::vector<TruthBox> truths{truth(0, square), truth(1, square)};
  // Ranks: hit, miss, hit. Precision 1 up to a recall of 1/2 (51 of 101 recalls), then 2/3.
  const auto result =
      average_precision(truths, {{0, 0, square, 0.9}, {0, 0, square, 0.8}, {1, 0, square, 0.7}}, 1);
  CHECK(*result.mean.ap50 == Approx((51 + 50 * 2.0 / 3) / 101).epsilon(1e-14));
  // The wrong place first: precision 1/2 at every recall.
  CHECK(average_precision({truth(0, square)}, {{0, 0, elsewhere, 0.9}, {0, 0, square, 0.8}}, 1).mean.ap50 ==
        0.5);
  // Half of the truths, found at once: recalls 0 to 1/2.
  const auto half = average_precision(truths, {{0, 0, square, 0.9}}, 1);
  CHECK(*half.mean.ap50 == Approx(51.0 / 101).epsilon(1e-14));
  CHECK(half.mean.recall == 0.5);
}

TEST_CASE("an overlap counts at the thresholds that it meets", "[evaluate][average_precision]") {
  // IoU 40·30 / 40·40 = 0.75, met exactly: .50 to .75 are six thresholds of ten.
  const auto result =
      average_precision({truth(0, square)}, {{0, 0, box_from_corners(10, 10, 50, 40), 0.9}}, 1);
  CHECK(result.mean.ap50 == 1.0);
  CHECK(result.mean.ap75 == 1.0);
  CHECK(*result.mean.ap == Approx(0.6).epsilon(1e-14));
  CHECK(*result.mean.recall == Approx(0.6).epsilon(1e-14));
}

TEST_CASE("a crowd takes any number of detections and counts for nothing", "[evaluate][average_precision]") {
  TruthBox crowd = truth(0, box_from_corners(90, 90, 400, 400));
  crowd.is_crowd = true;
  const std::vector<ScoredBox> inside{{0, 0, elsewhere, 0.95}, {0, 0, elsewhere, 0.94}, {0, 0, square, 0.9}};
  CHECK(average_precision({truth(0, square), crowd}, inside, 1).mean.ap50 == 1.0);
  CHECK_FALSE(average_precision({crowd}, inside, 1).mean.ap50);
  TruthBox difficult = truth(0, elsewhere);  // takes one; the other is a miss, ahead of the hit
  difficult.is_ignored = true;
  CHECK(average_precision({truth(0, square), difficult}, inside, 1).mean.ap50 == 0.5);
}

TEST_CASE("a detection takes a truth that counts before one that is ignored",
          "[evaluate][average_precision]") {
  TruthBox ignored = truth(0, square);  // overlaps more
  ignored.is_ignored = true;
  const Box near = box_from_corners(10, 10, 50, 45);
  CHECK(average_precision({ignored, truth(0, near)}, {{0, 0, square, 0.9}}, 1).mean.ap50 == 1.0);
}

TEST_CASE("equal confidences go by picture, then as given", "[evaluate][average_precision]") {
  const std::vector<TruthBox> truths{truth(1, square)};
  CHECK(average_precision(truths, {{1, 0, square, 0.5}, {0, 0, square, 0.5}}, 1).mean.ap50 == 0.5);
  CHECK(average_precision(truths, {{1, 0, elsewhere, 0.5}, {1, 0, square, 0.5}}, 1).mean.ap50 == 0.5);
  CHECK(average_precision(truths, {{1, 0, square, 0.5}, {1, 0, elsewhere, 0.5}}, 1).mean.ap50 == 1.0);
}

TEST_CASE("without truths there is no precision, without detections none is left",
          "[evaluate][average_precision]") {
  CHECK_FALSE(average_precision({}, {}, 0).mean.ap);
  CHECK_FALSE(average_precision({}, {{0, 0, square, 0.5}}, 1).mean.ap);
  CHECK(average_precision({truth(0, square)}, {}, 1).mean.ap == 0.0);
  CHECK(average_precision({truth(0, square)}, {}, 1).mean.recall == 0.0);
  // A class that is never present is in no mean; a picture without truths has misses.
  const auto result = average_precision({truth(0, square)},
                                        {{0, 0, square, 0.5}, {7, 0, square, 0.6}, {0, 1, square, 0.5}}, 2);
  CHECK(result.mean.ap50 == 0.5);
  CHECK_FALSE(result.classes[1].summary.ap50);
  CHECK(result.classes[1].detections == 1);
}

TEST_CASE("only the hundred most confident detections of a class in a picture count",
          "[evaluate][average_precision]") {
  std::vector<ScoredBox> detections(99, {0, 0, elsewhere, 0.9});
  detections.push_back({0, 0, square, 0.5});
  CHECK(*average_precision({truth(0, square)}, detections, 1).mean.ap50 == Approx(0.01).epsilon(1e-14));
  detections.push_back({0, 0, elsewhere, 0.9});
  CHECK(average_precision({truth(0, square)}, detections, 1).mean.ap50 == 0.0);
}

TEST_CASE("truths and detections belong to ranges of area", "[evaluate][average_precision]") {
  const Box small = box_from_corners(0, 0, 20, 20), large = box_from_corners(100, 100, 300, 300);
  const std::vector<TruthBox> truths{truth(0, small), truth(0, large)};
  const auto result = average_precision(truths, {{0, 0, elsewhere, 0.9}, {0, 0, large, 0.8}}, 1);
  CHECK(result.mean.ap_small == 0.0);  // the large ones are no misses here
  CHECK_FALSE(result.mean.ap_medium);
  CHECK(result.mean.ap_large == 1.0);
  CHECK(*result.mean.ap == Approx(51 * 0.5 / 101).epsilon(1e-14));
  // The area is the outline's: 1024 belongs to two ranges.
  const TruthBox outline{0, 0, square, 32.0 * 32};
  CHECK(average_precision({outline}, {{0, 0, square, 0.9}}, 1).mean.ap_small == 1.0);
  CHECK(average_precision({outline}, {{0, 0, square, 0.9}}, 1).mean.ap_medium == 1.0);
}

TEST_CASE("average precision agrees with a slow evaluation of its definition",
          "[evaluate][average_precision][repeated]") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    INFO("seed " << seed);
    const BruteForce slow = random_case(seed);
    const auto fast = average_precision(slow.truths, slow.detections, 3);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& summary = fast.classes[k].summary;
      const auto mean = [&](double low, double high) -> std::optional<double> {
        double sum = 0;
        for (int percent = 50; percent < 100; percent += 5) {
          const auto at = slow.precision(k, low, high, percent);
          if (!at) return std::nullopt;
          sum += *at / 10;
        }
        return sum;
      };
      check_same(summary.ap50, slow.precision(k, 0, 1e10, 50));
      check_same(summary.ap75, slow.precision(k, 0, 1e10, 75));
      check_same(summary.ap, mean(0, 1e10));
      check_same(summary.ap_small, mean(0, 1024));
      check_same(summary.ap_medium, mean(1024, 9216));
      check_same(summary.ap_large, mean(9216, 1e10));
    }
  }
}

TEST_CASE("the order of truths and detections, and the number of threads, do not matter",
          "[evaluate][average_precision]") {  // T16
  auto shuffled = random_case(5);
  const auto expected = average_precision(shuffled.truths, shuffled.detections, 3);
  tapestry::Random random(9);
  for (int round = 0; round < 5; ++round) {
    random.shuffle(shuffled.truths);
    random.shuffle(shuffled.detections);
    const tapestry::test::Threads cap(1 + round % 2);
    const auto result = average_precision(shuffled.truths, shuffled.detections, 3);
    CHECK(is_same(result.mean, expected.mean));
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(is_same(result.classes[k].summary, expected.classes[k].summary));
  }
}

TEST_CASE("the precision of one target a picture is that of its boxes", "[evaluate][average_precision]") {
  // Of four pictures two have a box of IoU .82, one is missed, and one has the surest box of all elsewhere.
  const std::vector<std::vector<evaluate::BoxOnTarget>> pictures{
      {{0.9F, 0.82F}, {0.2F, 0.3F}}, {{0.8F, 0.82F}}, {}, {{0.95F, 0}}};
  const double steps = 51.0 / 101;  // recalls up to 2 of 4, each with the precision 2 of 3
  const auto precision = evaluate::target_precision(pictures);
  CHECK(std::abs(precision.ap50.value() - steps * 2 / 3) < 1e-14);
  CHECK(std::abs(precision.ap.value() - 0.7 * steps * 2 / 3) < 1e-14);  // at .50 to .80
  std::vector<TruthBox> truths;
  std::vector<ScoredBox> detections;
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    truths.push_back(truth(i, square));
    for (const auto& [confidence, iou] : pictures[i])
      detections.push_back({i, 0, box_from_corners(10, 10, 50, 10 + 40 * double(iou)), double(confidence)});
  }
  CHECK(average_precision(truths, detections, 1).mean.ap == precision.ap);
  CHECK(evaluate::target_precision({{}}).ap50 == 0.0);
  CHECK_FALSE(evaluate::target_precision({}).ap50.has_value());
}

TEST_CASE("boxes, classes and confidences that make no sense are refused", "[evaluate][average_precision]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_WITH(average_precision({truth(0, square, 2)}, {}, 2),
                    "average_precision: truth 0 is of class 2, expected less than 2");
  CHECK_THROWS_AS(average_precision({}, {{0, 2, square, 0.5}}, 2), tapestry::DomainError);
  CHECK_THROWS_AS(average_precision({truth(0, {0, 0, -1, 1})}, {}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(average_precision({{0, 0, square, nan}}, {}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(average_precision({}, {{0, 0, {nan, 0, 1, 1}, 0.5}}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(average_precision({}, {{0, 0, square, nan}}, 1), tapestry::NumericError);
}
