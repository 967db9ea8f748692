#include <tapestry/loss/yolo_training.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
const loss::Truths two_images{{{0, {33, 20, 28, 22}}, {1, {10, 50, 9, 7}}}, {{2, {40, 41, 13, 11}}}};
}  // namespace

TEST_CASE("the training loss on the tape is yolo_training() and its adjoint", "[loss][gradient]") {
  const TinyHeads detector;
  const auto values = detector.logits<double>(2, 1);
  loss::YoloTrainingOptions options;
  options.box = 2;
  options.classification = 0.5;
  ActiveTape<double> tape;
  std::vector<ArrayVariable<double, 4>> logits;
  for (const auto& head : values) logits.push_back(tape.input(head));
  const auto terms = loss::yolo_training(detector, logits, two_images, options);
  const auto expected =
      loss::yolo_training(detector.heads(), loss::to_read(values), two_images, 64, 96, options);
  CHECK(terms.box.value() == expected.box);
  CHECK(terms.objectness.value() == expected.objectness);
  CHECK(terms.classification.value() == expected.classification);
  CHECK(terms.total.value() == expected.total);

  tape.reverse(
      Variable<double>(terms.total + 3 * terms.objectness));  // a user's own weight besides the total
  options.objectness += 3;
  std::vector<Array<double, 4>> adjoint;
  for (const auto& head : values) adjoint.push_back(xt::zeros_like(head));
  loss::yolo_training_adjoint(detector.heads(), loss::to_read(values), two_images, 64, 96, options, 1.0,
                              loss::to_add_to(adjoint));
  for (std::size_t h = 0; h < logits.size(); ++h) CHECK((logits[h].adjoint() == adjoint[h]));
}

TEST_CASE("the training loss on the tape refuses a batch without as many truths", "[loss][yolo_training]") {
  const TinyHeads detector;
  std::vector<ArrayVariable<double, 4>> logits;
  for (const auto& head : detector.logits<double>(3, 1)) logits.emplace_back(head);
  CHECK_THROWS_AS(loss::yolo_training(detector, logits, two_images), ShapeError);
  CHECK_THROWS_AS(loss::yolo_training(detector, logits, {}), DomainError);
}
