#include <tapestry/loss/yolox_training.hpp>

#include "../support/active_tape.hpp"
#include "../support/head_adjoints.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using detect::DecodeFamily;

namespace {
using Logits = std::vector<Array<double, 4>>;
const std::size_t height = TinyHeads::input_height(), width = TinyHeads::input_width();
const loss::Truths two_images{{{0, {33, 20, 28, 22}}, {1, {10, 50, 9, 7}}}, {{2, {40, 41, 13, 11}}}};

loss::DynamicMatches matches_of(const TinyHeads& detector, const Logits& logits, const loss::Truths& truths) {
  return loss::dynamic_matches(detector.heads(), loss::to_read(logits), truths, height, width);
}

loss::YoloTrainingTerms terms_of(const TinyHeads& detector, const Logits& logits,
                                 const loss::DynamicMatches& matches,
                                 const loss::YoloxTrainingOptions& options = {}) {
  return loss::yolox_training(detector.heads(), loss::to_read(logits), matches, height, width, options);
}

Logits adjoint_of(const TinyHeads& detector, const Logits& logits, const loss::DynamicMatches& matches,
                  const loss::YoloxTrainingOptions& options = {}, double total_adjoint = 1) {
  Logits adjoint;
  for (const auto& head : logits) adjoint.push_back(xt::zeros_like(head));
  loss::yolox_training_adjoint(detector.heads(), loss::to_read(logits), matches, height, width, options,
                               total_adjoint, loss::to_add_to(adjoint));
  return adjoint;
}

const double once = std::log(2.0);
}  // namespace

TEST_CASE("yolox_training at logits 0 equals the terms worked out by hand", "[loss][yolox_training]") {
  const TinyHeads detector(DecodeFamily::yolox);
  const auto logits = detector.flat_logits();
  // The cell of x 40 to 48 and y 24 to 32 predicts 8 × 8 about its corner (40, 24): IoU 64 of 72.
  const loss::DynamicMatches matches{{{{2, 0, 3, 5}, {1, {40, 24, 9, 8}}, 0.25}}};
  const auto terms = terms_of(detector, logits, matches);
  CHECK(terms.box == Approx(1 - std::pow(64.0 / 72, 2)));
  CHECK(terms.objectness == Approx((2 * 3 + 4 * 6 + 8 * 12) * once));  // logits of 0, so for any goal
  CHECK(terms.classification == Approx(3 * once));
  CHECK(terms.total == Approx(5 * terms.box + terms.objectness + terms.classification));
  const auto adjoint = adjoint_of(detector, logits, matches);
  CHECK(adjoint[2](0, 4, 3, 5) == -0.5);
  CHECK(adjoint[2](0, 4, 0, 0) == 0.5);
  CHECK(adjoint[2](0, 5 + 1, 3, 5) == 0.25);  // ½ − the IoU that it was matched with
  CHECK(adjoint[2](0, 5 + 2, 3, 5) == 0.5);
  CHECK(adjoint[2](0, 5 + 2, 0, 0) == 0);  // background has no classes to learn
}

TEST_CASE("yolox_training of distance heads has quality for objectness", "[loss][yolox_training]") {
  const TinyHeads detector(DecodeFamily::distance);
  const auto logits = detector.flat_logits();
  const loss::DynamicMatches matches{{{{2, 0, 3, 5}, {1, {44, 28, 56, 56}}, 0.25}}};
  const auto terms = terms_of(detector, logits, matches);
  CHECK(terms.box == Approx(0).margin(1e-12));  // bins of 0 to 7 cells: 3½ cells to each side
  CHECK(terms.objectness == 0);
  const double cells = 2 * 3 + 4 * 6 + 8 * 12;
  CHECK(terms.classification == Approx((3 * cells - 1) * once / 4 + once / 16));
}

TEST_CASE("yolox_training divides by the matched candidates of all images", "[loss][yolox_training]") {
  const TinyHeads detector(DecodeFamily::yolox);
  const auto logits = detector.logits<double>(2, 1, 0, 0);
  const loss::DynamicMatch match{{2, 0, 3, 5}, {1, {40, 24, 9, 8}}, 0.25};
  loss::DynamicMatch other = match;
  other.candidate.column = 7;
  const auto terms = terms_of(detector, logits, {{match, other}, {match}});
  CHECK(terms.classification == Approx(3 * once));
  CHECK(terms.objectness == Approx(2.0 / 3 * (2 * 3 + 4 * 6 + 8 * 12) * once));
  CHECK(terms_of(detector, logits, {{}, {}}).objectness == Approx(2 * (2 * 3 + 4 * 6 + 8 * 12) * once));
  CHECK(terms_of(detector, logits, {{}, {}}).box == 0);
}

TEST_CASE("yolox_training_adjoint agrees with central differences, matches held",
          "[loss][yolox_training][gradient]") {
  const TinyHeads detector(GENERATE(DecodeFamily::yolox, DecodeFamily::distance));
  loss::YoloxTrainingOptions options;
  options.box = 3.7;
  options.objectness = 1.3;
  options.classification = 0.9;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto logits = detector.logits<double>(2, seed);
    const auto matches = matches_of(detector, logits, two_images);
    REQUIRE(matches[0].size() + matches[1].size() >= 3);
    Logits adjoint;
    for (const auto& head : logits) adjoint.push_back(xt::zeros_like(head));
    for (int half = 0; half < 2; ++half)
      loss::yolox_training_adjoint(detector.heads(), loss::to_read(logits), matches, height, width, options,
                                   0.5, loss::to_add_to(adjoint));
    check_head_adjoints(adjoint, logits, seed, 1.0,
                        [&](const Logits& at) { return terms_of(detector, at, matches, options).total; });
  }
}

TEST_CASE("descending yolox_training makes the boxes come out", "[loss][yolox_training]") {
  const TinyHeads detector(GENERATE(DecodeFamily::yolox, DecodeFamily::distance));
  auto logits = detector.logits<double>(2, 3);
  for (int step = 0; step < 600; ++step) {
    const auto adjoint = adjoint_of(detector, logits, matches_of(detector, logits, two_images));
    for (std::size_t head = 0; head < logits.size(); ++head)
      logits[head] -= 0.01 * xt::sign(adjoint[head]);  // steps of one length, as Adam's
  }
  for (std::size_t image = 0; image < 2; ++image)
    for (const auto& truth : two_images[image]) {
      const loss::Predictions<double> predictions{detector.heads(), loss::to_read(logits), image, height,
                                                  width};
      double best = 0, surest_other = 0;
      for (std::size_t head = 0; head < logits.size(); ++head)
        loss::for_each_candidate(head, detector.heads()[head], [&](const loss::Candidate& candidate) {
          const auto& of = detector.heads()[head];
          const auto share = [&](std::size_t channel) {
            return nn::logistic(loss::logit(predictions, candidate, channel));
          };
          double confidence = share(of.class_channel(truth.class_index));
          if (const auto objectness = of.objectness_channel()) confidence *= share(*objectness);
          const double iou = detect::iou(loss::decoded_box(predictions, candidate), truth.box);
          if (confidence > 0.5) best = std::max(best, iou);
          if (iou == 0) surest_other = std::max(surest_other, confidence);
        });
      CHECK(best > 0.8);
      CHECK(surest_other < 0.3);
    }
}

TEST_CASE("yolox_training of saturated logits is finite, and so is its slope", "[loss][yolox_training]") {
  const TinyHeads detector(GENERATE(DecodeFamily::yolox, DecodeFamily::distance));
  auto logits = detector.flat_logits();
  for (auto& head : logits)
    for (std::size_t i = 0; i < head.size(); ++i) head.data()[i] = i % 2 == 0 ? 1e4 : -1e4;
  const auto matches = matches_of(detector, logits, {{{1, {40, 24, 20, 20}}}});
  REQUIRE_FALSE(matches.front().empty());
  CHECK(std::isfinite(terms_of(detector, logits, matches).total));
  for (const auto& head : adjoint_of(detector, logits, matches))
    for (const double slope : head) CHECK(std::isfinite(slope));
}

TEST_CASE("yolox_training refuses what it cannot teach", "[loss][yolox_training]") {
  const TinyHeads detector(DecodeFamily::yolox), anchored;
  const auto logits = detector.flat_logits();
  CHECK_THROWS_AS(terms_of(detector, logits, {}), DomainError);
  CHECK_THROWS_AS(terms_of(detector, detector.logits<double>(2, 1), {{}}), ShapeError);
  CHECK_THROWS_AS(terms_of(anchored, anchored.logits<double>(1, 1), {{}}), DomainError);
  const loss::DynamicMatch sound{{0, 0, 1, 1}, {1, {20, 20, 9, 9}}, 0.5};
  auto outside = sound, of_another_class = sound, before = sound;
  outside.candidate.column = 99;
  of_another_class.truth.class_index = 99;
  before.candidate.row = 0;
  CHECK_NOTHROW(terms_of(detector, logits, loss::DynamicMatches{{sound}}));
  for (const auto& matches : {std::vector{outside}, std::vector{of_another_class}, std::vector{sound, before},
                              std::vector{sound, sound}})
    CHECK_THROWS_AS(terms_of(detector, logits, loss::DynamicMatches{matches}), DomainError);
  Logits small{Array<double, 4>(logits[0])};
  CHECK_THROWS_AS(loss::yolox_training_adjoint(detector.heads(), loss::to_read(logits), {{}}, height, width,
                                               {}, 1.0, loss::to_add_to(small)),
                  ShapeError);
}

TEST_CASE("the loss on the tape is yolox_training() and its adjoint", "[loss][yolox_training][gradient]") {
  const TinyHeads detector(DecodeFamily::yolox);
  const auto values = detector.logits<double>(2, 1);
  loss::YoloxTrainingOptions options;
  options.classification = 0.5;
  ActiveTape<double> tape;
  std::vector<ArrayVariable<double, 4>> logits;
  for (const auto& head : values) logits.push_back(tape.input(head));
  const auto terms = loss::yolox_training(detector, logits, two_images, options);
  const auto matches = matches_of(detector, values, two_images);
  const auto expected = terms_of(detector, values, matches, options);
  CHECK(terms.box.value() == expected.box);
  CHECK(terms.objectness.value() == expected.objectness);
  CHECK(terms.classification.value() == expected.classification);
  CHECK(terms.total.value() == expected.total);
  tape.reverse(Variable<double>(terms.total + 3 * terms.objectness));
  options.objectness += 3;
  const auto adjoint = adjoint_of(detector, values, matches, options);
  for (std::size_t h = 0; h < logits.size(); ++h) CHECK((logits[h].adjoint() == adjoint[h]));
  CHECK_THROWS_AS(loss::yolox_training(detector, logits, {{}}), ShapeError);
}
