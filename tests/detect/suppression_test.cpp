#include <tapestry/detect/suppression.hpp>

#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

using namespace tapestry::detect;

namespace {
/// The definition: every detection is compared with every one kept.
std::vector<Detection> suppressed_by_definition(std::vector<Detection> detections, double iou_threshold,
                                                bool per_class, const SuppressionMeasure& measure) {
  std::sort(detections.begin(), detections.end(), [](const Detection& a, const Detection& b) {
    return std::tuple(-a.confidence, a.head, a.candidate, a.class_index) <
           std::tuple(-b.confidence, b.head, b.candidate, b.class_index);
  });
  std::vector<Detection> kept;
  for (const Detection& candidate : detections)
    if (std::none_of(kept.begin(), kept.end(), [&](const Detection& better) {
          return (!per_class || better.class_index == candidate.class_index) &&
                 measure(better.box, candidate.box) > iou_threshold;
        }))
      kept.push_back(candidate);
  return kept;
}

/// `count` detections of three classes and three heads, of confidences that repeat often.
template <class DrawBox>
std::vector<Detection> random_detections(std::size_t count, std::uint64_t seed, DrawBox draw_box) {
  tapestry::Random random(seed);
  std::vector<Detection> detections(count);
  for (std::size_t i = 0; i < count; ++i) {
    detections[i].class_index = random.index(3);
    detections[i].confidence = static_cast<double>(random.index(20)) / 20;
    detections[i].box = draw_box(random);
    detections[i].head = random.index(3);
    detections[i].candidate = i;
  }
  random.shuffle(detections);
  return detections;
}

/// The candidates of detections, in order.
std::vector<std::size_t> candidates_of(const std::vector<Detection>& detections) {
  std::vector<std::size_t> candidates;
  for (const Detection& detection : detections) candidates.push_back(detection.candidate);
  return candidates;
}
}  // namespace

TEST_CASE("suppression keeps the most confident of overlapping boxes", "[detect][suppression]") {
  const Detection best{0, 0.9, 1, {10, 10, 4, 4}, 0, 0};
  const Detection near{0, 0.8, 1, {10.5, 10, 4, 4}, 0, 1};
  const Detection other_class{1, 0.7, 1, {10, 10, 4, 4}, 0, 2}, far{0, 0.6, 1, {30, 10, 4, 4}, 1, 0};
  const auto kept = suppress({far, other_class, near, best}, 0.45);
  REQUIRE(kept.size() == 3);
  CHECK(kept[0].candidate == 0);
  CHECK(kept[1].class_index == 1);
  CHECK(kept[2].head == 1);
  CHECK(suppress({far, other_class, near, best}, 0.45, false).size() == 2);
  CHECK(suppress({}, 0.45).empty());
}

TEST_CASE("equal confidences are ordered by head and candidate", "[detect][suppression]") {
  const Detection a{0, 0.5, 1, {10, 10, 4, 4}, 0, 7}, b{0, 0.5, 1, {10, 10, 4, 4}, 1, 3};
  CHECK(suppress({a, b}, 0.45)[0].head == 0);
  CHECK(suppress({b, a}, 0.45)[0].head == 0);
}

TEST_CASE("the distance of centres is taken off the overlap", "[detect][suppression]") {
  const Box a{2, 2, 4, 4}, b{4, 2, 4, 4};  // half of each is shared: IoU 1/3, d = 2, c² = 6² + 4²
  CHECK(SuppressionMeasure{}(a, b) == iou(a, b));
  CHECK(SuppressionMeasure{1}(a, b) == Approx(1.0 / 3 - 4.0 / 52).epsilon(1e-14));
  CHECK(SuppressionMeasure{0.5}(b, a) == Approx(1.0 / 3 - 2 / std::sqrt(52.0)).epsilon(1e-14));
  CHECK(SuppressionMeasure{0.6}(a, a) == 1);
  CHECK(SuppressionMeasure{0.6}(a, Box{9, 2, 4, 4}) == 0);  // apart
  CHECK(SuppressionMeasure{0.6}(a, Box{2, 2, 0, 4}) == 0);  // without area
  CHECK(SuppressionMeasure{1}(Box{0, 0, 1e150, 1e150}, Box{0, 0, 1e149, 1e150}) == Approx(0.1));
  CHECK(SuppressionMeasure{1}(a, Box{2, 2, 1, 1}) == iou(a, Box{2, 2, 1, 1}));  // of one centre

  const Detection best{0, 0.9, 1, a, 0, 0}, near{0, 0.8, 1, b, 0, 1};
  CHECK(suppress({best, near}, 0.3).size() == 1);
  CHECK(suppress({best, near}, 0.3, true, {1.0}).size() == 2);
  CHECK(suppress({best, near}, 0.25, true, {1.0}).size() == 1);
  for (const double exponent : {0.0, -1.0, std::nan("")})
    CHECK_THROWS_AS(suppress({best}, 0.3, true, {exponent}), tapestry::DomainError);
}

TEST_CASE("suppression equals its definition on boxes of every kind", "[detect][suppression][repeated]") {
  using tapestry::Random;
  const std::pair<const char*, Box (*)(Random&)> kinds[] = {
      {"small",
       [](Random& r) {
         return Box{r.uniform(0, 400), r.uniform(0, 400), 20, 15};
       }},
      {"of all sizes",
       [](Random& r) {
         return Box{r.uniform(0, 400), r.uniform(0, 400), std::exp(r.uniform(0, 6)),
                    std::exp(r.uniform(0, 6))};
       }},
      {"touching, and many alike",
       [](Random& r) {
         const auto whole = [&](std::size_t count) { return static_cast<double>(r.index(count)); };
         return Box{4 * whole(20), 4 * whole(20), 4 * whole(4), 4 * whole(4)};  // some without area
       }},
      {"in a row",
       [](Random& r) {
         return Box{r.uniform(0, 1e4), 5, r.uniform(0, 20), 10};
       }},
      {"of sides from -10",
       [](Random& r) {
         return Box{r.uniform(0, 90), r.uniform(0, 90), r.uniform(-10, 30), r.uniform(-10, 30)};
       }},
      {"some far out or huge",
       [](Random& r) {
         const double far = r.chance(0.1) ? 1e18 : r.chance(0.1) ? -1e9 : 100;
         const double side = r.chance(0.1) ? 5e21 : r.chance(0.1) ? 1e150 : 30;
         return Box{far + r.uniform(0, 100), r.uniform(0, 100), side, r.uniform(0, 30)};
       }},
      {"narrower than the step of their coordinates",
       [](Random& r) {
         return Box{1e16 + std::floor(r.uniform(0, 40)), r.uniform(0, 9), r.uniform(0, 9), r.uniform(0, 9)};
       }},
  };
  for (const auto& [name, draw_box] : kinds)
    for (const std::size_t count : {1U, 20U, 800U}) {
      const auto detections = random_detections(count, count, draw_box);
      for (const double threshold : {0.0, 0.1, 0.45, 0.9, 1.0})
        for (const bool per_class : {true, false})
          for (const auto& measure : {SuppressionMeasure{}, SuppressionMeasure{0.6}}) {
            CAPTURE(name, count, threshold, per_class, measure.distance_exponent.has_value());
            CHECK(candidates_of(suppress(detections, threshold, per_class, measure)) ==
                  candidates_of(suppressed_by_definition(detections, threshold, per_class, measure)));
          }
    }
}

TEST_CASE("what suppression keeps above a confidence does not depend on what lies below",
          "[detect][suppression]") {
  const auto detections = random_detections(500, 1, [](tapestry::Random& random) {
    return Box{random.uniform(0, 90), random.uniform(0, 90), 30, 20};
  });
  const auto is_low = [](const Detection& detection) { return detection.confidence <= 0.5; };
  auto high = detections, kept = suppress(detections, 0.45);
  std::erase_if(high, is_low);
  std::erase_if(kept, is_low);
  CHECK(candidates_of(suppress(high, 0.45)) == candidates_of(kept));
}

TEST_CASE("suppression copes with as many detections as random weights give", "[detect][suppression]") {
  constexpr std::size_t side = 150;
  std::vector<Detection> detections;  // at each of 22,500 places a strong box and two that it suppresses
  for (std::size_t place = 0; place < side * side; ++place)
    for (std::size_t i = 0; i < 3; ++i) {
      const Box box{10 * static_cast<double>(place % side) + static_cast<double>(i),
                    10 * static_cast<double>(place / side), 9, 9};
      detections.push_back({0, 0.9 - 0.1 * static_cast<double>(i), 1, box, 0, 3 * place + i});
    }
  const auto kept = suppress(detections, 0.45);
  REQUIRE(kept.size() == side * side);  // every pair would be 10⁹ comparisons
  for (std::size_t place = 0; place < kept.size(); ++place)
    if (kept[place].candidate != 3 * place)
      FAIL("place " << place << " keeps another box than its strongest");
}

TEST_CASE("suppression refuses a threshold that no overlap can be", "[detect][suppression]") {
  for (const double threshold : {-0.1, 1.5, std::nan("")})
    CHECK_THROWS_AS(suppress({}, threshold), tapestry::DomainError);
}
