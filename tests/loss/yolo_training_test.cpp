#include <tapestry/loss/yolo_training.hpp>

#include "../support/head_adjoints.hpp"

using namespace tapestry;
using detect::DecodeFamily;

namespace {
constexpr std::size_t size = 64, classes = 2;
using Logits = std::vector<Array<double, 4>>;

std::vector<detect::Head> two_heads(DecodeFamily decode = DecodeFamily::darknet) {
  std::vector<detect::Head> heads(2);
  for (std::size_t i = 0; i < 2; ++i) {
    heads[i].classes = classes;
    heads[i].grid_height = heads[i].grid_width = i == 0 ? 4 : 8;
    heads[i].scale_x_y = i == 0 ? 1.0 : 1.1;
    heads[i].decode = decode;
  }
  heads[0].anchors = {{30, 20}, {40, 40}};
  heads[1].anchors = {{8, 8}, {14, 10}};
  return heads;
}

Logits logits_of(const std::vector<detect::Head>& heads, std::uint64_t seed, std::size_t images = 2,
                 double range = 1) {
  Logits logits;
  for (std::size_t i = 0; i < heads.size(); ++i)
    logits.push_back(
        test::random_array<double>({images, 2 * (5 + classes), heads[i].grid_height, heads[i].grid_width},
                                   seed * 10 + i, -range, range));
  return logits;
}

const loss::Truths two_images{{{0, {33, 20, 28, 22}}, {1, {10, 50, 9, 7}}}, {{1, {40, 41, 13, 11}}}};
}  // namespace

TEST_CASE("yolo_training at logits 0 equals the terms worked out by hand", "[loss][yolo_training]") {
  const auto heads = two_heads();
  const auto logits = logits_of(heads, 1, 1, 0);
  // Best anchor 30 × 20, cell (1, 2): its centre (33, 20) is 1/16 and 1/4 into the cell of 16 px.
  const loss::Truths truths{{{0, {33, 20, 28, 22}}}};
  const auto terms = loss::yolo_training(heads, loss::to_read(logits), truths, size, size);
  const double w = std::log(28.0 / 30), h = std::log(22.0 / 20), once = std::log(2.0);
  const double weight = 2 - 28 * 22.0 / (64 * 64);
  CHECK(terms.box == Approx(weight * (2 * once + (w * w + h * h) / 2)));
  CHECK(terms.classification == Approx(2 * once));
  // 2 · 16 + 2 · 64 boxes, one matched; the 40 × 40 of the same cell shares 28 · 22 of 1600, less than half.
  CHECK(terms.objectness == Approx(160 * once));
  CHECK(terms.total == Approx(terms.box + terms.objectness + terms.classification));
}

TEST_CASE("yolo_training of ultralytics heads equals the terms worked out by hand", "[loss][yolo_training]") {
  const auto heads = two_heads(DecodeFamily::ultralytics);
  const auto logits = logits_of(heads, 1, 1, 0);
  const loss::Truths truths{{{0, {33, 20, 28, 22}}}};
  const auto terms = loss::yolo_training(heads, loss::to_read(logits), truths, size, size);
  const double weight = 2 - 28 * 22.0 / (64 * 64), once = std::log(2.0);
  CHECK(terms.box == Approx(weight * 4 * once));  // at logit 0 every cross entropy is log 2
  CHECK(terms.objectness == Approx(160 * once));  // boxes at logit 0 are the anchors, as Darknet's
  Logits adjoint{xt::zeros_like(logits[0]), xt::zeros_like(logits[1])};
  loss::yolo_training_adjoint(heads, loss::to_read(logits), truths, size, size, {}, 1.0,
                              loss::to_add_to(adjoint));
  const auto slope = [&](std::size_t channel) { return adjoint[0](0, channel, 1, 2); };
  // σ wanted: x, y of 1/16 and 1/4 from the cell's corner + ½ over 2; w, h half the root of truth over anchor
  CHECK(slope(0) == Approx(weight * (0.5 - (0.0625 + 0.5) / 2)));
  CHECK(slope(1) == Approx(weight * (0.5 - (0.25 + 0.5) / 2)));
  CHECK(slope(2) == Approx(weight * (0.5 - std::sqrt(28.0 / 30) / 2)));
  CHECK(slope(3) == Approx(weight * (0.5 - std::sqrt(22.0 / 20) / 2)));
}

TEST_CASE("yolo_training wants no more of ultralytics heads than 4 anchors", "[loss][yolo_training]") {
  auto heads = two_heads(DecodeFamily::ultralytics);
  heads[0].anchors = {{4, 40}, {4, 40}};
  const auto logits = logits_of(heads, 1, 1, 0);
  Logits adjoint{xt::zeros_like(logits[0]), xt::zeros_like(logits[1])};
  loss::yolo_training_adjoint(heads, loss::to_read(logits), {{{0, {33, 20, 28, 38}}}}, size, size, {}, 1.0,
                              loss::to_add_to(adjoint));
  CHECK(adjoint[0](0, 2, 1, 2) == Approx((2 - 28 * 38.0 / (64 * 64)) * (0.5 - 1)));
}

TEST_CASE("yolo_training ignores a good box that is not the matched one", "[loss][yolo_training]") {
  const auto heads = two_heads();
  const auto logits = logits_of(heads, 1, 1, 0);
  // Anchor 40 × 40 fits. At the same place 30 × 20 has IoU .416, and 40 × 40 a cell further .403.
  const loss::Truths truths{{{0, {40, 24, 38, 38}}}};
  const double all = loss::yolo_training(heads, loss::to_read(logits), truths, size, size).objectness;
  CHECK(loss::yolo_training(heads, loss::to_read(logits), truths, size, size, {0.41, 1.0, 1, 1, 1})
            .objectness == Approx(all - std::log(2.0)));
  // With match_iou .4 it is matched as well, which at logit 0 costs the same objectness but adds a box.
  const auto both =
      loss::yolo_training(heads, loss::to_read(logits), truths, size, size, {0.41, 0.4, 1, 1, 1});
  CHECK(both.objectness == Approx(all));
  CHECK(both.classification == Approx(4 * std::log(2.0)));
}

TEST_CASE("yolo_training_adjoint agrees with central differences", "[loss][yolo_training][gradient]") {
  const auto heads = two_heads(GENERATE(DecodeFamily::darknet, DecodeFamily::ultralytics));
  const loss::YoloTrainingOptions options{0.5, 0.6, 0.7, 1.3, 0.9};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto logits = logits_of(heads, seed);
    Logits adjoint{xt::zeros_like(logits[0]), xt::zeros_like(logits[1])};
    for (int half = 0; half < 2; ++half)
      loss::yolo_training_adjoint(heads, loss::to_read(logits), two_images, size, size, options, 0.5,
                                  loss::to_add_to(adjoint));
    test::check_head_adjoints(adjoint, logits, seed, 1.0, [&](const Logits& at) {
      return loss::yolo_training(heads, loss::to_read(at), two_images, size, size, options).total;
    });
  }
}

TEST_CASE("descending yolo_training makes the boxes come out", "[loss][yolo_training]") {
  const auto heads = two_heads(GENERATE(DecodeFamily::darknet, DecodeFamily::ultralytics));
  auto logits = logits_of(heads, 3);
  for (int step = 0; step < 400; ++step) {
    Logits adjoint{xt::zeros_like(logits[0]), xt::zeros_like(logits[1])};
    loss::yolo_training_adjoint(heads, loss::to_read(logits), two_images, size, size, {}, 1.0,
                                loss::to_add_to(adjoint));
    for (std::size_t head = 0; head < heads.size(); ++head) logits[head] -= 0.5 * adjoint[head];
  }
  for (std::size_t image = 0; image < 2; ++image)
    for (const auto& truth : two_images[image]) {
      const loss::Predictions<double> predictions{heads, loss::to_read(logits), image, size, size};
      double best = 0;
      for (std::size_t head = 0; head < 2; ++head)
        loss::for_each_candidate(head, heads[head], [&](const loss::Candidate& candidate) {
          const double sure = nn::logistic(loss::logit(predictions, candidate, 4)) *
                              nn::logistic(loss::logit(predictions, candidate, 5 + truth.class_index));
          best = std::max(best, sure * detect::iou(loss::decoded_box(predictions, candidate), truth.box));
        });
      CHECK(best > 0.9);
    }
}

TEST_CASE("yolo_training leaves out truths that no cell holds", "[loss][yolo_training]") {
  const auto heads = two_heads();
  const auto logits = logits_of(heads, 4, 1);
  const auto terms =
      loss::yolo_training(heads, loss::to_read(logits),
                          {{{0, {64, 10, 9, 9}}, {0, {10, 10, 0, 9}}, {1, {-1, 5, 9, 9}}}}, size, size);
  CHECK(terms.box == 0);
  CHECK(terms.classification == 0);
  CHECK(terms.objectness > 0);
}

TEST_CASE("yolo_training refuses what does not fit together", "[loss][yolo_training]") {
  const auto heads = two_heads();
  const auto logits = logits_of(heads, 5);
  CHECK_THROWS_WITH(loss::yolo_training(heads, loss::to_read(logits), {{}}, size, size),
                    "yolo_training: truths of 1 images, expected 2");
  CHECK_THROWS_AS(loss::yolo_training(heads, loss::to_read(logits), {}, size, size), DomainError);
  CHECK_THROWS_AS(loss::yolo_training(heads, loss::to_read(logits), {{}, {{2, {1, 1, 1, 1}}}}, size, size),
                  DomainError);
  Logits one{logits[0]};
  CHECK_THROWS_AS(loss::yolo_training_adjoint(heads, loss::to_read(logits), two_images, size, size, {}, 1.0,
                                              loss::to_add_to(one)),
                  ShapeError);
  const auto scaled = two_heads(DecodeFamily::scaled);
  CHECK_THROWS_WITH(loss::yolo_training(scaled, loss::to_read(logits), two_images, size, size),
                    "yolo_training: heads of the decode family scaled (new_coords=1) give activations, but "
                    "losses need raw logits; expected darknet or ultralytics");
  const auto distances = two_heads(DecodeFamily::distance);
  CHECK_THROWS_WITH(
      loss::yolo_training(distances, loss::to_read(logits), two_images, size, size),
      "yolo_training: heads of the decode family distance have no anchors, which this loss needs; "
      "expected darknet or ultralytics");
  CHECK_THROWS_AS(loss::yolo_training_adjoint(two_heads(DecodeFamily::yolox), loss::to_read(logits),
                                              two_images, size, size, {}, 1.0, loss::to_add_to(one)),
                  DomainError);
}
