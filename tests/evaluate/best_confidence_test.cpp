#include <tapestry/evaluate/detection_rate.hpp>

#include "../support/catch.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
using Logits = std::vector<Array<float, 4>>;

loss::Predictions<float> predictions(const TinyHeads& heads, const Logits& logits, std::size_t image) {
  return {heads.heads(), loss::to_read(logits), image, TinyHeads::input_height(), TinyHeads::input_width()};
}

/// The same through every detection of the picture.
double by_decoding(const TinyHeads& heads, const Logits& logits, std::size_t image,
                   const loss::Target& target, double iou_threshold) {
  double best = 0;
  for (const detect::Detection& found :
       detect::decode(heads.heads(), logits, image, 0, TinyHeads::input_height(), TinyHeads::input_width()))
    if (found.class_index == target.class_index && detect::iou(found.box, target.box) >= iou_threshold)
      best = std::max(best, found.confidence);
  return best;
}

/// Logits without any confidence of a candidate.
Logits silent(const TinyHeads& heads) {
  auto logits = heads.logits<float>(1, 1, 0, 0);
  for (auto& head : logits) std::fill(head.storage().begin(), head.storage().end(), -20.0F);
  return logits;
}
}  // namespace

TEST_CASE("the best confidence is that of one candidate worked out by hand", "[evaluate][best_confidence]") {
  // Coarsest head, first anchor of 40 × 30, cell (1, 2): logits of 0 put the box's centre at 2.5 and 1.5
  // cells of 32 pixels, with the anchor's extents. Objectness σ(1), class 2 σ(−1).
  const TinyHeads heads;
  auto logits = silent(heads);
  for (std::size_t channel = 0; channel < 4; ++channel) logits[0](0, channel, 1, 2) = 0;
  logits[0](0, 4, 1, 2) = 1;
  logits[0](0, 7, 1, 2) = -1;
  const auto sigmoid = [](double x) { return 1 / (1 + std::exp(-x)); };
  const double expected = sigmoid(1) * sigmoid(-1);
  const auto best = [&](std::size_t class_index, const detect::Box& box, double iou_threshold = 0.5) {
    return evaluate::best_confidence(predictions(heads, logits, 0), {class_index, box}, iou_threshold);
  };
  CHECK(best(2, {80, 48, 40, 30}) == Approx(expected).epsilon(1e-6));
  CHECK(best(2, {80, 48, 40, 15}) == Approx(expected).epsilon(1e-6));  // an IoU of one half counts
  CHECK(best(2, {80, 48, 40, 14.9}) < 1e-12);
  CHECK(best(2, {80, 48, 40, 14.9}, 0.4) == Approx(expected).epsilon(1e-6));
  CHECK(best(1, {80, 48, 40, 30}) < 1e-8);  // of another class: σ(1) · σ(−20)
  CHECK(best(2, {80, 48, 0, 0}) == 0);
}

TEST_CASE("the best confidence is the largest among all detections", "[evaluate][best_confidence]") {
  const auto family =
      GENERATE(detect::DecodeFamily::darknet, detect::DecodeFamily::ultralytics, detect::DecodeFamily::scaled,
               detect::DecodeFamily::yolox, detect::DecodeFamily::distance);
  const TinyHeads heads(family);
  const bool activations = family == detect::DecodeFamily::scaled;
  std::size_t counted = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto logits = heads.logits<float>(2, seed, activations ? 0.0 : -3.0, activations ? 1.0 : 2.0);
    for (std::size_t image = 0; image < 2; ++image)
      for (const loss::Target& target :
           {loss::Target{0, {40, 30, 30, 25}}, {1, {20, 50, 12, 10}}, {2, {90, 5, 50, 40}}})
        for (const double threshold : {0.3, 0.5, 0.7}) {
          const double expected = by_decoding(heads, logits, image, target, threshold);
          CHECK(evaluate::best_confidence(predictions(heads, logits, image), target, threshold) == expected);
          counted += expected > 0 ? 1U : 0U;
        }
  }
  CHECK(counted > 10);
}

TEST_CASE("candidates that are not numbers do not count", "[evaluate][best_confidence]") {
  const TinyHeads heads;
  auto logits = heads.logits<float>(1, 3, -3, 2);
  const loss::Target target{0, {40, 30, 30, 25}};
  for (std::size_t row = 0; row < 8; ++row)
    for (std::size_t column = 0; column < 12; ++column)
      logits[2](0, (row + column) % 5, row, column) = std::numeric_limits<float>::quiet_NaN();
  CHECK(evaluate::best_confidence(predictions(heads, logits, 0), target) ==
        by_decoding(heads, logits, 0, target, 0.5));
}

TEST_CASE("the best confidence needs logits that fit the heads", "[evaluate][best_confidence][error]") {
  const TinyHeads heads;
  auto logits = heads.logits<float>(1, 1);
  const loss::Target target{0, {40, 30, 30, 25}};
  CHECK_THROWS_WITH(evaluate::best_confidence(predictions(heads, logits, 1), target),
                    "best_candidate: image 1 of a batch of 1");
  CHECK_THROWS_WITH(evaluate::best_confidence(predictions(heads, logits, 0), {3, target.box}),
                    "best_candidate: class 3 of a network with 3 classes");
  std::swap(logits[0], logits[1]);
  CHECK_THROWS_AS(evaluate::best_confidence(predictions(heads, logits, 0), target), ShapeError);
  logits.pop_back();
  CHECK_THROWS_WITH(evaluate::best_confidence(predictions(heads, logits, 0), target),
                    "best_candidate: logits of 2 heads, expected 3");
}
