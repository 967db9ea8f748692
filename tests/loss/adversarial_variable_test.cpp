#include <tapestry/loss/adversarial.hpp>

#include "../support/active_tape.hpp"
#include "../support/head_adjoints.hpp"
#include "../support/threads.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using namespace tapestry::test;
using loss::AdversarialLoss;

namespace {
const std::vector<loss::Target> cars{{0, {50, 30, 26, 17}}, {2, {20, 40, 30, 22}}, {1, {70, 20, 12, 12}}};
const loss::AdversarialWeights weights{0.7, 1.3, 0.9, 1.1};

template <class T>
using Logits = std::vector<Array<T, 4>>;

template <class T>
std::vector<ArrayVariable<T, 4>> inputs(Tape<T>& tape, const Logits<T>& logits) {
  std::vector<ArrayVariable<T, 4>> variables;
  for (const auto& head : logits) variables.push_back(tape.input(head));
  return variables;
}

template <class T>
Logits<T> adjoints(const std::vector<ArrayVariable<T, 4>>& variables) {
  Logits<T> all;
  for (const auto& variable : variables) all.push_back(variable.adjoint());
  return all;
}

/// Weighs every term differently, besides the total.
template <class T>
Variable<T> mixed(const loss::AdversarialTerms<Variable<T>>& terms) {
  return T(0.5) * terms.iou + T(0.25) * terms.objectness - terms.classification + T(2) * terms.max_score +
         T(3) * terms.total;
}

template <class T>
Logits<T> gradient_of_mixed(const Logits<T>& logits, AdversarialLoss kind) {
  ActiveTape<T> tape;
  const auto variables = inputs(tape, logits);
  tape.reverse(mixed(loss::adversarial(TinyHeads(), variables, cars, kind, weights)));
  return adjoints(variables);
}
}  // namespace

TEST_CASE("adversarial on the tape is the mean of the images' losses, bit for bit", "[loss][tape]") {
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::as_coded, AdversarialLoss::max_score,
                             AdversarialLoss::vanish);
  const TinyHeads detector;
  const auto logits = detector.logits<float>(cars.size(), 1);
  ActiveTape<float> tape;
  const auto variables = inputs(tape, logits);
  const auto terms = loss::adversarial(detector, variables, cars, kind, weights);
  tape.reverse(2.0F * terms.total);

  const double share = 1 / 3.0;
  double iou = 0, objectness = 0, classification = 0, max_score = 0, total = 0;
  Logits<float> expected;
  for (const auto& head : logits) expected.push_back(tapestry::zeros<float, 4>(head.shape()));
  for (std::size_t n = 0; n < cars.size(); ++n) {
    const loss::Predictions<float> predictions{detector.heads(), loss::to_read(logits), n, 64, 96};
    const auto of_image = loss::adversarial(predictions, cars[n], kind, weights);
    iou += share * static_cast<double>(of_image.iou);
    objectness += share * static_cast<double>(of_image.objectness);
    classification += share * static_cast<double>(of_image.classification);
    max_score += share * static_cast<double>(of_image.max_score);
    total += share * static_cast<double>(of_image.total);
    loss::adversarial_adjoint(predictions, cars[n], kind, weights, 2.0F * static_cast<float>(share),
                              loss::to_add_to(expected));
  }
  CHECK(terms.iou.value() == static_cast<float>(iou));
  CHECK(terms.objectness.value() == static_cast<float>(objectness));
  CHECK(terms.classification.value() == static_cast<float>(classification));
  CHECK(terms.max_score.value() == static_cast<float>(max_score));
  CHECK(terms.total.value() == static_cast<float>(total));
  for (std::size_t head = 0; head < 3; ++head) CHECK((variables[head].adjoint() == expected[head]));
}

TEMPLATE_TEST_CASE("every term of adversarial on the tape agrees with central differences",
                   "[loss][tape][gradient]", float, double) {
  using T = TestType;
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::max_score, AdversarialLoss::vanish);
  const TinyHeads detector;
  const auto logits = detector.logits<T>(cars.size(), 4);
  const auto gradient = gradient_of_mixed(logits, kind);
  check_head_adjoints(gradient, logits, 5, T(4), [&](const Logits<T>& numbers) {
    const std::vector<ArrayVariable<T, 4>> at(numbers.begin(), numbers.end());
    return mixed(loss::adversarial(detector, at, cars, kind, weights)).value();
  });
}

TEST_CASE("adversarial recorded twice on one tape gives the sum of both gradients", "[loss][tape]") {
  const auto logits = TinyHeads().logits<double>(3, 6);
  const std::vector<loss::Target> others{cars[1], cars[2], cars[0]};
  const auto gradient = [&](bool first, bool second) {
    ActiveTape<double> tape;
    const auto variables = inputs(tape, logits);
    Variable<double> root = 0;
    const auto one = loss::adversarial(TinyHeads(), variables, cars);
    const auto two = loss::adversarial(TinyHeads(), variables, others, AdversarialLoss::max_score);
    if (first) root += one.total;
    if (second) root += two.total;
    tape.reverse(root);
    return adjoints(variables);
  };
  const auto first = gradient(true, false), second = gradient(false, true), both = gradient(true, true);
  for (std::size_t head = 0; head < 3; ++head)
    for (std::size_t i = 0; i < both[head].size(); ++i)
      REQUIRE(both[head].data()[i] ==
              Approx(first[head].data()[i] + second[head].data()[i]).epsilon(1e-14).margin(1e-18));
}

TEST_CASE("adversarial on the tape keeps the logits that it was given", "[loss][tape]") {
  const auto logits = TinyHeads().logits<double>(3, 7);
  const auto expected = gradient_of_mixed(logits, AdversarialLoss::paper);
  ActiveTape<double> tape;
  auto variables = inputs(tape, logits);
  const auto kept = variables;
  Variable<double> root;
  {
    const TinyHeads gone_before_the_reverse_sweep;
    root = mixed(
        loss::adversarial(gone_before_the_reverse_sweep, variables, cars, AdversarialLoss::paper, weights));
  }
  variables.clear();
  tape.reverse(root);
  for (std::size_t head = 0; head < 3; ++head) CHECK((kept[head].adjoint() == expected[head]));
}

TEST_CASE("a head of passive logits costs and gets nothing", "[loss][tape]") {
  const TinyHeads detector;
  const auto logits = detector.logits<double>(3, 8);
  ActiveTape<double> tape;
  std::vector<ArrayVariable<double, 4>> variables(logits.begin(), logits.end());
  CHECK_FALSE(loss::adversarial(detector, variables, cars).total.is_active());
  CHECK(tape.statement_count() == 0);

  variables[2] = tape.input(logits[2]);
  tape.reverse(mixed(loss::adversarial(detector, variables, cars, AdversarialLoss::paper, weights)));
  CHECK((variables[2].adjoint() == gradient_of_mixed(logits, AdversarialLoss::paper)[2]));
}

TEST_CASE("adversarial on the tape gives the same bits with one thread and with two", "[loss][tape]") {
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::as_coded, AdversarialLoss::max_score,
                             AdversarialLoss::vanish);
  const auto logits = TinyHeads().logits<float>(3, 9);
  same_by_threads({1, 2}, [&] { return gradient_of_mixed(logits, kind); });
}

TEST_CASE("adversarial on the tape refuses what does not fit together", "[loss][tape][error]") {
  const auto logits = TinyHeads().logits<double>(2, 10);
  std::vector<ArrayVariable<double, 4>> variables(logits.begin(), logits.end());
  const TinyHeads detector;
  CHECK_THROWS_WITH(loss::adversarial(detector, variables, cars),
                    "adversarial: targets of 3 images, expected 2");
  CHECK_THROWS_AS(loss::adversarial(detector, variables, cars), ShapeError);
  CHECK_THROWS_WITH(loss::adversarial(detector, variables, {}), "adversarial: an empty batch");
  const std::vector<loss::Target> unknown{{0, {1, 1, 1, 1}}, {3, {1, 1, 1, 1}}};
  CHECK_THROWS_WITH(loss::adversarial(detector, variables, unknown), "adversarial: class 3 of 3");
  const std::vector<loss::Target> two(cars.begin(), cars.begin() + 2);
  CHECK_THROWS_AS(loss::adversarial(TinyHeads(detect::DecodeFamily::scaled), variables, two), DomainError);
  variables.pop_back();
  CHECK_THROWS_WITH(loss::adversarial(detector, variables, two),
                    "adversarial: logits of 2 heads, expected 3");
}
