#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/yolo_training.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using loss::AdversarialLoss;

namespace {
constexpr std::size_t input_height = 64, input_width = 96;
using Logits = std::vector<Array<double, 4>>;

/// YOLOv2's head, with cells of 16 px and two anchors.
std::vector<detect::Head> one_head(std::size_t classes = 3) {
  detect::Head head{classes, 4, 6, {{{24.0, 16.0}}, {{30.0, 40.0}}}};
  head.exclusive_classes = true;
  return {head};
}

Logits random_logits(const std::vector<detect::Head>& heads, std::uint64_t seed, double size) {
  return {test::random_array<double>({2, heads[0].channel_count(), 4, 6}, seed, -size, size)};
}

loss::Predictions<double> view(const std::vector<detect::Head>& heads, const Logits& logits) {
  return {heads, loss::to_read(logits), 1, input_height, input_width};
}

/// The first anchor's box, 24 × 16 at (56, 24), of objectness o and these classes; nothing anywhere else.
Logits one_box(const std::vector<detect::Head>& heads, double o, const std::vector<double>& classes) {
  Logits logits{tapestry::filled<double, 4>({2, heads[0].channel_count(), 4, 6}, -60)};
  const loss::Candidate candidate{0, 0, 1, 3};
  const auto set = [&](std::size_t channel, double value) {
    logits[0].data()[loss::logit_index(view(heads, logits), candidate, channel)] = value;
  };
  for (std::size_t channel = 0; channel < 4; ++channel) set(channel, 0);
  set(4, o);
  for (std::size_t k = 0; k < classes.size(); ++k) set(5 + k, classes[k]);
  return logits;
}

double sigma(double x) { return 1 / (1 + std::exp(-x)); }

const loss::Target car{1, {56, 24, 24, 32}};  // half covered by that box

/// Compares a gradient with central differences of every logit.
template <class Value>
void check_differences(Logits& logits, const Array<double, 4>& gradient, Value value) {
  const double h = test::central_difference_step<double>();
  const double tolerance = 4 * test::central_difference_tolerance(value());
  for (std::size_t i = 0; i < logits[0].size(); ++i) {
    CAPTURE(i);
    CHECK(std::abs(gradient.data()[i] - test::slope_by(logits[0].data()[i], h, value)) <= tolerance);
  }
}
}  // namespace

TEST_CASE("losses of exclusive classes equal the ones worked out by hand", "[loss][exclusive_classes]") {
  const auto heads = one_head();
  const auto logits = one_box(heads, 2, {std::log(1.0), std::log(5.0), std::log(2.0)});
  const auto paper = loss::adversarial(view(heads, logits), car, AdversarialLoss::paper);
  CHECK(paper.iou == Approx(0.5).epsilon(1e-12));
  CHECK(paper.objectness == Approx(sigma(2)).epsilon(1e-12));
  CHECK(paper.classification == Approx(5.0 / 8).epsilon(1e-12));
  CHECK(loss::max_score(view(heads, logits), car) == Approx(-std::log(1 - sigma(2) * 5 / 16)).epsilon(1e-12));
  const auto coded = loss::adversarial(view(heads, logits), car, AdversarialLoss::as_coded);
  CHECK(coded.classification == 0);  // of log 5 and, by the other anchor, −60: the raw logits' mean is cut

  const loss::Target alone{1, {56, 24, 24, 16}};
  const auto terms =
      loss::yolo_training(heads, loss::to_read(logits), {{}, {alone}}, input_height, input_width);
  CHECK(terms.classification == Approx(std::log(8.0 / 5) / 2).epsilon(1e-12));  // a mean over two images
}

TEST_CASE("adversarial losses of exclusive classes agree with central differences in double",
          "[loss][exclusive_classes][gradient]") {
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::max_score, AdversarialLoss::vanish);
  const std::size_t classes = GENERATE(1U, 2U, 5U);
  const auto heads = one_head(classes);
  const loss::Target target{classes / 2, {50, 30, 26, 17}};
  const loss::AdversarialWeights weights{0.7, 1.3, 0.9, 1.1};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    auto logits = random_logits(heads, seed, 2);
    Logits adjoint{tapestry::zeros<double, 4>(logits[0].shape())};
    loss::adversarial_adjoint(view(heads, logits), target, kind, weights, 1.0, loss::to_add_to(adjoint));
    CAPTURE(loss::name_of(kind), classes, seed);
    check_differences(logits, adjoint[0],
                      [&] { return loss::adversarial(view(heads, logits), target, kind, weights).total; });
  }
}

TEST_CASE("as_coded does not ask whether classes are exclusive", "[loss][exclusive_classes][gradient]") {
  const auto exclusive = one_head();
  auto independent = exclusive;
  independent[0].exclusive_classes = false;
  const auto logits = random_logits(exclusive, 4, 3);
  Logits adjoint{tapestry::zeros<double, 4>(logits[0].shape())}, other = adjoint;
  const auto run = [&](const std::vector<detect::Head>& heads, Logits& into) {
    loss::adversarial_adjoint(view(heads, logits), car, AdversarialLoss::as_coded, {}, 1.0,
                              loss::to_add_to(into));
    return loss::adversarial(view(heads, logits), car, AdversarialLoss::as_coded).total;
  };
  CHECK(run(exclusive, adjoint) == run(independent, other));
  for (std::size_t i = 0; i < adjoint[0].size(); ++i) CHECK(adjoint[0].data()[i] == other[0].data()[i]);
}

TEST_CASE("the training loss of exclusive classes agrees with central differences in double",
          "[loss][exclusive_classes][gradient]") {
  const std::size_t classes = GENERATE(1U, 4U);
  const auto heads = one_head(classes);
  auto logits = random_logits(heads, 5, 2);
  const loss::Truths truths{{{0, {20, 20, 30, 20}}},
                            {{classes - 1, {50, 30, 26, 17}}, {0, {80, 50, 30, 40}}}};
  loss::YoloTrainingOptions options;
  options.classification = 1.7;
  Logits adjoint{tapestry::zeros<double, 4>(logits[0].shape())};
  loss::yolo_training_adjoint<double>(heads, loss::to_read(logits), truths, input_height, input_width,
                                      options, 1.0, loss::to_add_to(adjoint));
  check_differences(logits, adjoint[0], [&] {
    return loss::yolo_training(heads, loss::to_read(logits), truths, input_height, input_width, options)
        .total;
  });
}

TEST_CASE("the responsible candidate of exclusive classes is the best of all", "[loss][exclusive_classes]") {
  const auto heads = one_head();
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const auto logits = random_logits(heads, seed, 8);
    const auto predictions = view(heads, logits);
    double best = 0;
    loss::for_each_candidate(0, heads[0], [&](const loss::Candidate& candidate) {
      best = std::max(best, loss::examine_candidate(predictions, candidate, car).score());
    });
    const auto found = loss::responsible(predictions, car);
    CHECK((found ? found->score() : 0) == best);
  }
}

TEST_CASE("max_score still pulls where an exclusive class is utterly sure", "[loss][exclusive_classes]") {
  const auto heads = one_head();
  const auto logits = one_box(heads, 800, {0, 100, 40});
  const loss::Target target{1, {56, 24, 24, 16}};
  CHECK(loss::max_score(view(heads, logits), target) == Approx(60).epsilon(1e-12));
  Logits adjoint{tapestry::zeros<double, 4>(logits[0].shape())};
  loss::max_score_adjoint(view(heads, logits), target, 1.0, loss::to_add_to(adjoint));
  const auto at = [&](std::size_t channel) {
    return adjoint[0].data()[loss::logit_index(view(heads, logits), {0, 0, 1, 3}, channel)];
  };
  CHECK(at(6) == Approx(1).epsilon(1e-12));
  CHECK(at(7) == Approx(-1).epsilon(1e-12));  // the rival's raising hides the target as well
}

TEST_CASE("a NaN anywhere makes a loss of exclusive classes NaN", "[loss][exclusive_classes]") {
  const auto heads = one_head();
  for (std::size_t channel = 0; channel < 8; ++channel) {
    auto logits = random_logits(heads, 6, 6);
    logits[0].data()[loss::logit_index(view(heads, logits), {0, 1, 3, 0}, channel)] = std::nan("");
    CAPTURE(channel);
    for (const auto kind : {AdversarialLoss::paper, AdversarialLoss::max_score})
      CHECK(std::isnan(loss::adversarial(view(heads, logits), car, kind).total));
  }
}
