#include <tapestry/loss/adversarial.hpp>

#include "../support/head_adjoints.hpp"
#include "../support/tiny_heads.hpp"

using namespace tapestry;
using detect::DecodeFamily, loss::AdversarialLoss;

namespace {
constexpr std::size_t input_height = 64, input_width = 96, classes = 3;
constexpr std::size_t objectness = 4, of_class_0 = 5;  // channels of a candidate of heads with anchors
const std::vector<AdversarialLoss> all_kinds{AdversarialLoss::paper, AdversarialLoss::as_coded,
                                             AdversarialLoss::max_score, AdversarialLoss::vanish};

std::vector<detect::Head> three_heads(DecodeFamily decode = DecodeFamily::darknet) {
  return test::TinyHeads(decode).heads();
}

template <class T>
using Logits = std::vector<Array<T, 4>>;

template <class T>
Logits<T> random_logits(std::uint64_t seed, double size = 1, DecodeFamily decode = DecodeFamily::darknet) {
  return test::TinyHeads(decode).logits<T>(2, seed, -size, size);
}

template <class T>
Logits<T> zeros_like(const Logits<T>& logits) {
  Logits<T> zeros;
  for (const auto& head : logits) zeros.push_back(tapestry::zeros<T, 4>(head.shape()));
  return zeros;
}

template <class T>
loss::Predictions<T> view(const std::vector<detect::Head>& heads, const Logits<T>& logits,
                          std::size_t image = 1) {
  return {heads, loss::to_read(logits), image, input_height, input_width};
}

/// Logits that all have one value.
Logits<double> level(double value, DecodeFamily decode = DecodeFamily::darknet) {
  auto logits = random_logits<double>(1, 1, decode);
  for (auto& head : logits) head.fill(value);
  return logits;
}

DecodeFamily any_family() {
  return GENERATE(DecodeFamily::darknet, DecodeFamily::ultralytics, DecodeFamily::yolox,
                  DecodeFamily::distance);
}

/// Lets one candidate of image 1 predict exactly the given box with the given certainty.
void predict(const std::vector<detect::Head>& heads, Logits<double>& logits, const loss::Candidate& candidate,
             double width, double height, double certainty) {
  const auto predictions = view(heads, logits);
  const auto& anchor = heads[candidate.head].anchors[candidate.anchor];
  double* values = logits[candidate.head].data();
  const auto set = [&](std::size_t channel, double value) {
    values[loss::logit_index(predictions, candidate, channel)] = value;
  };
  set(loss::x_channel, 0);
  set(loss::y_channel, 0);
  set(loss::w_channel, std::log(width / anchor[0]));
  set(loss::h_channel, std::log(height / anchor[1]));
  set(objectness, certainty);
  set(of_class_0, certainty);
}

const loss::Target car{0, {50.0, 30.0, 26.0, 17.0}};
}  // namespace

TEST_CASE("the paper's loss adds IoU, objectness and class probability of each scale",
          "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = level(-60);  // every box vanishes and no candidate is sure of anything
  predict(heads, logits, {1, 0, 1, 3}, 20, 16, 2.0);  // centre (56, 24)
  predict(heads, logits, {2, 1, 3, 6}, 9, 14, 1.0);   // centre (52, 28)
  const loss::Target target{0, {56, 24, 20, 16}};
  const auto terms = loss::adversarial(view(heads, logits), target, AdversarialLoss::paper);
  // [47.5, 56.5] × [21, 35] and [46, 66] × [16, 32] share 9 × 11.
  const double smaller_iou = 9.0 * 11 / (9 * 14 + 20 * 16 - 9.0 * 11);
  CHECK(terms.iou == Approx(1 + smaller_iou).epsilon(1e-9));
  CHECK(terms.objectness == Approx(nn::logistic(2.0) + nn::logistic(1.0)));
  CHECK(terms.classification == Approx(nn::logistic(2.0) + nn::logistic(1.0)));
  CHECK(terms.max_score == 0);
  CHECK(terms.total == Approx(0.05 * terms.iou + terms.objectness + 0.5 * terms.classification));
}

TEST_CASE("max_score is minus the log of the chance that nothing finds the target", "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = level(-60);
  predict(heads, logits, {1, 0, 1, 3}, 20, 16, 2.0);
  predict(heads, logits, {2, 1, 3, 6}, 9, 14, 1.0);
  const auto terms =
      loss::adversarial(view(heads, logits), {0, {56, 24, 20, 16}}, AdversarialLoss::max_score);
  CHECK(terms.max_score == Approx(-std::log(1 - nn::logistic(2.0) * nn::logistic(2.0))).epsilon(1e-12));
  CHECK(terms.total == terms.max_score);
  CHECK(terms.objectness == 0);
}

TEST_CASE("vanish is the log of one plus the odds of every name", "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = level(-60);
  predict(heads, logits, {1, 0, 1, 3}, 20, 16, 2.0);
  const loss::Target target{0, {56, 24, 20, 16}};
  const auto predictions = view(heads, logits);
  const auto of_one = loss::adversarial(predictions, target, AdversarialLoss::vanish);
  CHECK(of_one.max_score == Approx(loss::max_score(predictions, target)).epsilon(1e-12));
  CHECK(of_one.total == of_one.max_score);
  // The same box under another name, equally sure: max_score of the first name ignores it.
  logits[1].data()[loss::logit_index(predictions, {1, 0, 1, 3}, heads[1].class_channel(1))] = 2.0;
  const double before = loss::max_score(predictions, target);
  const double score = nn::logistic(2.0) * nn::logistic(2.0);
  CHECK(loss::max_score(predictions, target) == before);
  CHECK(loss::vanish(predictions, target.box) ==
        Approx(std::log(1 + 2 * score / (1 - score))).epsilon(1e-12));
  auto adjoint = zeros_like(logits);
  loss::vanish_adjoint(predictions, target.box, 1.0, loss::to_add_to(adjoint));
  const auto slope = [&](std::size_t k) {
    return adjoint[1].data()[loss::logit_index(predictions, {1, 0, 1, 3}, heads[1].class_channel(k))];
  };
  CHECK(slope(0) > 0.01);
  CHECK(slope(1) == slope(0));
  // Utterly sure under both names: nothing overflows.
  for (const std::size_t channel : {heads[1].class_channel(0), heads[1].class_channel(1), objectness})
    logits[1].data()[loss::logit_index(predictions, {1, 0, 1, 3}, channel)] = 800;
  CHECK(loss::vanish(predictions, target.box) ==
        Approx(std::log(2.0) + loss::max_score(predictions, target)));
}

TEST_CASE("as_coded equals the published terms worked out by hand", "[loss][adversarial]") {
  auto heads = three_heads();
  auto logits = level(0);
  for (auto& head : heads) head.scale_x_y = 1;
  // A target of 20 × 16 around (56, 24): ratios below 4 for all anchors, so two matches a head.
  const loss::Target target{1, {56, 24, 20, 16}};
  for (std::size_t head = 0; head < 3; ++head)
    REQUIRE(loss::matched_candidates(view(heads, logits), head, target).size() == 2);
  for (double& logit : logits[0].storage()) logit = 1;  // a mean class logit of 1 in head 0, of 0 elsewhere
  const auto terms = loss::adversarial(view(heads, logits), target, AdversarialLoss::as_coded);
  CHECK(terms.classification == Approx(1.0));
  const double at_zero = std::log(2.0);                                          // any target
  const double at_one = (10 * loss::softplus(1) + 2 * loss::softplus(-1)) / 12;  // 2 × 3 cells × 2 anchors
  CHECK(terms.objectness == Approx(0.4 * at_one + 1.0 * at_zero + 4.0 * at_zero).epsilon(1e-13));
  double ciou = 0;
  for (std::size_t head = 0; head < 3; ++head)
    for (const auto& candidate : loss::matched_candidates(view(heads, logits), head, target))
      ciou += loss::complete_iou(loss::decoded_box(view(heads, logits), candidate), target.box).value() / 2;
  CHECK(terms.iou == Approx(ciou));
  // Objectness pulls the matched cells up: minimising makes the detector surer there.
  auto adjoint = zeros_like(logits);
  loss::adversarial_adjoint(view(heads, logits), target, AdversarialLoss::as_coded, {0, 1, 0, 0}, 1.0,
                            loss::to_add_to(adjoint));
  const auto matched = loss::matched_candidates(view(heads, logits), 1, target).front();
  CHECK(adjoint[1].data()[loss::logit_index(view(heads, logits), matched, objectness)] == Approx(-0.5 / 48));
}

TEST_CASE("anchors match up to a ratio of 4, in the cell of the centre only", "[loss][adversarial]") {
  const auto heads = three_heads();
  const auto logits = random_logits<double>(1);
  const auto matches = [&](std::size_t head, const detect::Box& box) {
    return loss::matched_candidates(view(heads, logits), head, {0, box});
  };
  CHECK(matches(2, {50, 30, 24, 8}).size() == 1);  // 24 / 6 is not below 4, 24 / 9 is
  CHECK(matches(2, {50, 30, 23.9, 8}) == std::vector<loss::Candidate>{{2, 0, 3, 6}, {2, 1, 3, 6}});
  CHECK(matches(2, {50, 30, 0, 8}).empty());
  CHECK(matches(2, {96, 30, 10, 8}).empty());          // on the border: outside
  CHECK(matches(2, {95.9, 63.9, 10, 8}).size() == 2);  // reaches over it
  CHECK(matches(2, {-0.1, 30, 10, 8}).empty());
}

TEST_CASE("adversarial_adjoint agrees with central differences in double", "[loss][adversarial][gradient]") {
  const auto decode = any_family();
  const auto heads = three_heads(decode);
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::as_coded, AdversarialLoss::max_score,
                             AdversarialLoss::vanish);
  const loss::AdversarialWeights weights{0.7, 1.3, 0.9, 1.1};
  CAPTURE(loss::name_of(kind), detect::name_of(decode));
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const auto logits = random_logits<double>(seed, 1, decode);
    auto adjoint = zeros_like(logits);
    for (int half = 0; half < 2; ++half)
      loss::adversarial_adjoint(view(heads, logits), car, kind, weights, 0.5, loss::to_add_to(adjoint));
    // CIoU's alpha is not differentiated: keep its value out of the difference.
    const auto alpha_free = [&](const Logits<double>& at) {
      double value = loss::adversarial(view(heads, at), car, kind, weights).total;
      if (kind != AdversarialLoss::as_coded) return value;
      for (std::size_t head = 0; head < heads.size(); ++head) {
        const auto matched = loss::matched_candidates(view(heads, at), head, car);
        for (const auto& candidate : matched) {
          const auto now = loss::complete_iou(loss::decoded_box(view(heads, at), candidate), car.box);
          const auto then = loss::complete_iou(loss::decoded_box(view(heads, logits), candidate), car.box);
          value += weights.iou * (now.alpha - then.alpha) * now.aspect / static_cast<double>(matched.size());
        }
      }
      return value;
    };
    test::check_head_adjoints(adjoint, logits, seed, 4.0, alpha_free);
    for (const double slope : adjoint[0].storage()) REQUIRE(std::isfinite(slope));
    const auto half = adjoint[1].size() / 2;
    for (std::size_t i = 0; i < half; ++i) REQUIRE(adjoint[1].data()[i] == 0);  // image 0 is not touched
  }
}

TEST_CASE("adversarial in float follows double", "[loss][adversarial]") {
  const auto heads = three_heads();
  const auto logits = random_logits<double>(3);
  Logits<float> rounded;
  for (const auto& head : logits) rounded.push_back(tapestry::cast<float>(head));
  for (const auto kind : all_kinds) {
    const auto reference = loss::adversarial(view(heads, logits), car, kind);
    const auto terms = loss::adversarial(view(heads, rounded), car, kind);
    // Logits of size 1 are off by 2⁻²⁵; a gradient of length below 10 makes that 10 · 2⁻²⁵ at most.
    CHECK(static_cast<double>(terms.total) == Approx(reference.total).margin(10 * 3e-8).epsilon(6e-8));
    auto adjoint = zeros_like(logits);
    auto float_adjoint = zeros_like(rounded);
    loss::adversarial_adjoint(view(heads, logits), car, kind, {}, 1.0, loss::to_add_to(adjoint));
    loss::adversarial_adjoint(view(heads, rounded), car, kind, {}, 1.0F, loss::to_add_to(float_adjoint));
    for (std::size_t head = 0; head < heads.size(); ++head)
      for (std::size_t i = 0; i < adjoint[head].size(); ++i)
        REQUIRE(std::abs(static_cast<double>(float_adjoint[head].data()[i]) - adjoint[head].data()[i]) <
                1e-6);
  }
}

TEST_CASE("descending a loss hides the target", "[loss][adversarial]") {
  const auto decode = any_family();
  const auto heads = three_heads(decode);
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::max_score, AdversarialLoss::vanish);
  auto logits = random_logits<double>(7, 3, decode);
  for (int step = 0; step < 400; ++step) {
    auto adjoint = zeros_like(logits);
    loss::adversarial_adjoint(view(heads, logits), car, kind, {}, 1.0, loss::to_add_to(adjoint));
    for (std::size_t head = 0; head < heads.size(); ++head) logits[head] -= 2.0 * adjoint[head];
  }
  const auto best = loss::responsible(view(heads, logits), car);
  CHECK((!best || best->score() < 0.1));
}

TEST_CASE("the slope of an ultralytics box equals the one worked out by hand", "[loss][adversarial]") {
  const auto heads = three_heads(DecodeFamily::ultralytics);
  auto logits = level(std::log(3.0));  // σ = ¾, σ' = 3/16
  const loss::Candidate candidate{2, 1, 3, 6};
  const auto box = loss::decoded_box(view(heads, logits), candidate);
  CHECK(box.cx == Approx(8 * (6 + 1.0)).epsilon(1e-14));
  CHECK(box.cy == Approx(8 * (3 + 1.0)).epsilon(1e-14));
  CHECK(box.w == Approx(2.25 * 9).epsilon(1e-14));
  CHECK(box.h == Approx(2.25 * 14).epsilon(1e-14));
  auto adjoint = zeros_like(logits);
  loss::decoded_box_adjoint(view(heads, logits), candidate, {1, 10, 100, 1000}, loss::to_add_to(adjoint));
  const auto slope = [&](std::size_t channel) {
    return adjoint[2].data()[loss::logit_index(view(heads, logits), candidate, channel)];
  };
  CHECK(slope(loss::x_channel) == Approx(2 * 3.0 / 16 * 8).epsilon(1e-14));
  CHECK(slope(loss::y_channel) == Approx(10 * 2 * 3.0 / 16 * 8).epsilon(1e-14));
  CHECK(slope(loss::w_channel) == Approx(100 * 8 * 0.75 * 3 / 16 * 9).epsilon(1e-14));
  CHECK(slope(loss::h_channel) == Approx(1000 * 8 * 0.75 * 3 / 16 * 14).epsilon(1e-14));
}

TEST_CASE("a box of saturated ultralytics logits has a finite slope", "[loss][adversarial]") {
  const auto heads = three_heads(DecodeFamily::ultralytics);
  const double size = GENERATE(100.0, -100.0, 800.0, -800.0, 1e30);
  auto logits = level(size);
  auto adjoint = zeros_like(logits);
  loss::decoded_box_adjoint(view(heads, logits), {1, 0, 1, 3}, {1, 1, 1, 1}, loss::to_add_to(adjoint));
  for (const double slope : adjoint[1].storage()) REQUIRE(std::isfinite(slope));
  // d(2σ)²/dt = 8σ²·σ(−t): at 100 8·e^−100, and at −100 8·e^−200, of an anchor of 20 px
  const double slope =
      adjoint[1].data()[loss::logit_index(view(heads, logits), {1, 0, 1, 3}, loss::w_channel)];
  if (size == 100) CHECK(slope == Approx(20 * 8 * std::exp(-100.0)).epsilon(1e-13));
  if (size == -100) CHECK(slope == Approx(20 * 8 * std::exp(-200.0)).epsilon(1e-13));
}

TEST_CASE("losses refuse heads that give no raw logits", "[loss][adversarial]") {
  auto heads = three_heads();
  const auto logits = random_logits<double>(1);
  heads[2].decode = DecodeFamily::scaled;
  const std::string message =
      ": heads of the decode family scaled (new_coords=1) give activations, but losses need raw logits; "
      "expected darknet, ultralytics, yolox, distance or decoded";
  for (const auto kind : all_kinds) {
    CHECK_THROWS_WITH(loss::adversarial(view(heads, logits), car, kind), "adversarial" + message);
    auto adjoint = zeros_like(logits);
    CHECK_THROWS_WITH(
        loss::adversarial_adjoint(view(heads, logits), car, kind, {}, 1.0, loss::to_add_to(adjoint)),
        "adversarial_adjoint" + message);
  }
}

TEST_CASE("no detection at any scale makes the loss exactly 0", "[loss][adversarial]") {
  const auto heads = three_heads();
  const auto logits = random_logits<double>(4);
  const loss::Target outside{0, {-500.0, -500.0, 10.0, 10.0}};
  const loss::Target flat{0, {50.0, 30.0, 0.0, 10.0}};
  for (const auto kind : {AdversarialLoss::paper, AdversarialLoss::max_score, AdversarialLoss::vanish})
    for (const auto& target : {outside, flat}) {
      CHECK(loss::adversarial(view(heads, logits), target, kind).total == 0.0);
      auto adjoint = zeros_like(logits);
      loss::adversarial_adjoint(view(heads, logits), target, kind, {}, 1.0, loss::to_add_to(adjoint));
      for (const auto& head : adjoint)
        for (const double slope : head.storage()) REQUIRE(slope == 0.0);
    }
  const auto terms = loss::adversarial(view(heads, logits), outside, AdversarialLoss::as_coded);
  CHECK(terms.iou == 0);
  CHECK(terms.classification == 0);
  CHECK(terms.objectness > 0);
}

TEST_CASE("a target box touching or crossing the border is measured whole", "[loss][adversarial]") {
  const auto heads = three_heads();
  const auto logits = random_logits<double>(5);
  for (const auto kind : all_kinds)
    for (const detect::Box& box :
         {detect::Box{8, 32, 16, 20}, detect::Box{0, 0, 30, 30}, detect::Box{93, 60, 30, 30}}) {
      const auto total = loss::adversarial(view(heads, logits), {2, box}, kind).total;
      CHECK(std::isfinite(total));
      CHECK(total > 0);
    }
}

TEST_CASE("saturated logits give finite losses and gradients", "[loss][adversarial]") {
  const auto decode = any_family();
  const auto heads = three_heads(decode);
  const double size = GENERATE(100.0, -100.0, 800.0, -800.0, 1e30);
  const auto logits = level(size, decode);
  for (const auto kind : all_kinds) {
    if (kind == AdversarialLoss::as_coded && size == 1e30) continue;
    CAPTURE(size, loss::name_of(kind), detect::name_of(decode));
    CHECK(std::isfinite(loss::adversarial(view(heads, logits), car, kind).total));
    auto adjoint = zeros_like(logits);
    loss::adversarial_adjoint(view(heads, logits), car, kind, {}, 1.0, loss::to_add_to(adjoint));
    for (const auto& head : adjoint)
      for (const double slope : head.storage()) REQUIRE(std::isfinite(slope));
  }
}

TEST_CASE("max_score still pulls where the detector is utterly sure", "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = level(-60);
  predict(heads, logits, {1, 0, 1, 3}, 20, 16, 100.0);
  const auto predictions = view(heads, logits);
  const loss::Target target{0, loss::decoded_box(predictions, {1, 0, 1, 3})};
  // o = p: the chance to miss is 2e−100, and each of the two logits has half of the slope.
  CHECK(loss::max_score(predictions, target) == Approx(100 - std::log(2.0)).epsilon(1e-12));
  auto adjoint = zeros_like(logits);
  loss::max_score_adjoint(predictions, target, 1.0, loss::to_add_to(adjoint));
  CHECK(adjoint[1].data()[loss::logit_index(predictions, {1, 0, 1, 3}, objectness)] == Approx(0.5));
}

TEST_CASE("a tie goes to the first candidate", "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = level(-60);
  predict(heads, logits, {1, 0, 1, 2}, 16, 16, 1.0);  // 8 px left of the target's centre
  predict(heads, logits, {1, 0, 1, 3}, 16, 16, 1.0);  // 8 px right of it
  const auto found = loss::responsible(view(heads, logits), 1, {0, {48, 24, 16, 16}});
  REQUIRE(found);
  CHECK(found->candidate == loss::Candidate{1, 0, 1, 2});
}

TEST_CASE("responsible is the maximum over every candidate", "[loss][adversarial]") {
  const auto decode = any_family();
  const auto heads = three_heads(decode);
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    auto logits = random_logits<double>(seed, 0.2 * static_cast<double>(seed), decode);
    const loss::Target target{seed % classes, {1.5 * static_cast<double>(seed), 30, 26, 17}};
    for (std::size_t head = 0; head < heads.size(); ++head) {
      std::optional<loss::Responsible> best;
      loss::for_each_candidate(head, heads[head], [&](const loss::Candidate& candidate) {
        const auto found = loss::examine_candidate(view(heads, logits), candidate, target);
        if (found.score() > (best ? best->score() : 0)) best = found;
      });
      const auto found = loss::responsible(view(heads, logits), head, target);
      REQUIRE(found.has_value() == best.has_value());
      if (found) CHECK(found->candidate == best->candidate);
    }
  }
}

TEST_CASE("NaN arriving in the loss is passed on", "[loss][adversarial]") {
  const auto decode = any_family();
  const auto heads = three_heads(decode);
  for (const auto kind : all_kinds) {
    auto logits = random_logits<double>(8, 1, decode);
    const auto place = loss::matched_candidates(view(heads, logits), 1, car).front();
    logits[1].data()[loss::logit_index(view(heads, logits), place, loss::w_channel)] = std::nan("");
    CHECK(std::isnan(loss::adversarial(view(heads, logits), car, kind).total));
    auto anywhere = random_logits<double>(8, 1, decode);
    const std::size_t channel = loss::objectness_channel(heads[2], car.class_index);
    anywhere[2].data()[loss::logit_index(view(heads, anywhere), {2, 0, 7, 0}, channel)] = std::nan("");
    CHECK(std::isnan(loss::adversarial(view(heads, anywhere), car, kind).total));
  }
}

TEST_CASE("adversarial refuses what does not fit together", "[loss][adversarial]") {
  const auto heads = three_heads();
  auto logits = random_logits<double>(9);
  const auto kind = AdversarialLoss::paper;
  CHECK_THROWS_AS(loss::adversarial(view(heads, logits, 2), car, kind), DomainError);
  CHECK_THROWS_AS(loss::adversarial(view(heads, logits), {3, car.box}, kind), DomainError);
  CHECK_THROWS_AS(loss::adversarial(view(heads, logits), {0, {std::nan(""), 0, 1, 1}}, kind), DomainError);
  auto two = logits;
  two.pop_back();
  CHECK_THROWS_WITH(loss::adversarial(view(heads, two), car, kind),
                    "adversarial: logits of 2 heads, expected 3");
  CHECK_THROWS_AS(loss::adversarial_adjoint(view(heads, logits), car, kind, {}, 1.0, loss::to_add_to(two)),
                  ShapeError);
  std::swap(logits[0], logits[1]);
  CHECK_THROWS_WITH(loss::adversarial(view(heads, logits), car, kind),
                    "adversarial: logits is [2, 16, 4, 6], expected [2, 16, 2, 3]");
}

TEST_CASE("adversarial losses are chosen by name", "[loss][adversarial]") {
  for (const auto kind : all_kinds) CHECK(loss::adversarial_loss_by_name(loss::name_of(kind)) == kind);
  CHECK_THROWS_WITH(loss::adversarial_loss_by_name("papre"),
                    "no adversarial loss is called 'papre'; there are paper, as_coded, max_score, vanish");
}
