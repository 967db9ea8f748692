#include <tapestry/loss/adversarial.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using detect::ChannelOrder, detect::DecodeFamily, loss::AdversarialLoss;

namespace {
constexpr std::size_t input_height = 64, input_width = 96, classes = 3;
const std::vector<AdversarialLoss> all_kinds{AdversarialLoss::paper, AdversarialLoss::as_coded,
                                             AdversarialLoss::max_score, AdversarialLoss::vanish};
using Logits = std::vector<Array<double, 4>>;

double sigma(double x) { return 1 / (1 + std::exp(-x)); }

/// Two heads with strides 16 and 8.
std::vector<detect::Head> two_heads(DecodeFamily family, ChannelOrder order = ChannelOrder::box_first,
                                    std::size_t bins = 8) {
  return {{classes, 4, 6, {}, 1, family, bins, order}, {classes, 8, 12, {}, 1, family, bins, order}};
}

/// Two images' logits.
Logits logits_of(const std::vector<detect::Head>& heads, std::uint64_t seed, double size) {
  Logits logits;
  for (const auto& head : heads)
    logits.push_back(test::random_array<double>({2, head.channel_count(), head.grid_height, head.grid_width},
                                                seed * 10 + logits.size(), -size, size));
  return logits;
}

Logits filled(const std::vector<detect::Head>& heads, double value) {
  Logits logits = logits_of(heads, 1, 1);
  for (auto& head : logits)
    for (double& logit : head.storage()) logit = value;
  return logits;
}

Logits zeros_like(const Logits& logits) {
  Logits zeros;
  for (const auto& head : logits) zeros.push_back(tapestry::zeros<double, 4>(head.shape()));
  return zeros;
}

loss::Predictions<double> view(const std::vector<detect::Head>& heads, const Logits& logits) {
  return {heads, loss::to_read(logits), 1, input_height, input_width};
}

double& at(const std::vector<detect::Head>& heads, Logits& logits, const loss::Candidate& candidate,
           std::size_t channel) {
  return logits[candidate.head].data()[loss::logit_index(view(heads, logits), candidate, channel)];
}

/// Distances of two bins, so σ(t) of a cell: lets a candidate reach that part of a cell to every side.
void reach(const std::vector<detect::Head>& heads, Logits& logits, const loss::Candidate& candidate,
           double share) {
  for (std::size_t side = 0; side < 4; ++side) {
    const std::size_t first = heads[candidate.head].box_channel() + 2 * side;
    at(heads, logits, candidate, first) = 0;
    at(heads, logits, candidate, first + 1) = std::log(share / (1 - share));
  }
}

const loss::Target car{1, {50, 30, 26, 17}};
}  // namespace

TEST_CASE("losses of distance heads equal the ones worked out by hand", "[loss][anchor_free]") {
  const auto order = GENERATE(ChannelOrder::box_first, ChannelOrder::classes_first);
  const auto heads = two_heads(DecodeFamily::distance, order, 2);
  auto logits = filled(heads, -60);
  const loss::Candidate coarse{0, 0, 1, 3}, fine{1, 0, 3, 6};  // centres (56, 24) and (52, 28)
  reach(heads, logits, coarse, 0.75);                          // 24 × 24
  reach(heads, logits, fine, 0.5);                             // 8 × 8, within the target
  at(heads, logits, coarse, heads[0].class_channel(1)) = 2;
  at(heads, logits, fine, heads[1].class_channel(1)) = 1;
  const loss::Target target{1, {56, 24, 24, 24}};
  const auto predictions = view(heads, logits);
  const double ious = 1 + 64.0 / 576, scores = sigma(2) + sigma(1);

  const auto paper = loss::adversarial(predictions, target, AdversarialLoss::paper);
  CHECK(paper.iou == Approx(ious).epsilon(1e-12));
  CHECK(paper.objectness == Approx(scores).epsilon(1e-12));  // the class score, once more
  CHECK(paper.classification == Approx(scores).epsilon(1e-12));
  const auto surest = loss::adversarial(predictions, target, AdversarialLoss::max_score);
  CHECK(surest.total == Approx(-std::log(1 - sigma(2))).epsilon(1e-12));  // and not its square

  // Cells of (56, 24): the coarse candidate's, and in the fine head one without any score.
  const auto coded = loss::adversarial(predictions, target, AdversarialLoss::as_coded);
  CHECK(coded.classification == Approx(2).epsilon(1e-12));  // the largest mean of −60 counts as 0
  const double of_coarse = loss::softplus(-2.0) / 24, of_fine = (60 + loss::softplus(1.0)) / 96;
  CHECK(coded.objectness == Approx(1.0 * of_coarse + 4.0 * of_fine).epsilon(1e-12));
}

TEST_CASE("losses of yolox heads equal the ones worked out by hand", "[loss][anchor_free]") {
  const auto heads = two_heads(DecodeFamily::yolox);
  auto logits = filled(heads, -60);
  const loss::Candidate candidate{0, 0, 1, 3};
  const double values[4] = {0.5, 0.5, std::log(1.5), std::log(1.5)};  // centre (56, 24), 24 × 24
  for (std::size_t channel = 0; channel < 4; ++channel)
    at(heads, logits, candidate, channel) = values[channel];
  at(heads, logits, candidate, 4) = 2;
  at(heads, logits, candidate, heads[0].class_channel(1)) = 1;
  const loss::Target target{1, {56, 24, 24, 48}};
  const auto predictions = view(heads, logits);
  const auto paper = loss::adversarial(predictions, target, AdversarialLoss::paper);
  CHECK(paper.iou == Approx(0.5).epsilon(1e-12));
  CHECK(paper.objectness == Approx(sigma(2)).epsilon(1e-12));
  CHECK(paper.classification == Approx(sigma(1)).epsilon(1e-12));
  CHECK(loss::max_score(predictions, target) ==
        Approx(-std::log(1 - sigma(2) * sigma(1) / 2)).epsilon(1e-12));
  CHECK(loss::matched_candidates(predictions, 0, target) == std::vector{candidate});
}

TEST_CASE("losses of anchor-free heads agree with central differences in double",
          "[loss][anchor_free][gradient][long]") {
  const int layout = GENERATE(0, 1, 2);
  const auto heads = layout == 0   ? two_heads(DecodeFamily::yolox)
                     : layout == 1 ? two_heads(DecodeFamily::distance, ChannelOrder::box_first, 16)
                                   : two_heads(DecodeFamily::distance, ChannelOrder::classes_first, 8);
  const auto kind = GENERATE(AdversarialLoss::paper, AdversarialLoss::as_coded, AdversarialLoss::max_score,
                             AdversarialLoss::vanish);
  const loss::AdversarialWeights weights{0.7, 1.3, 0.9, 1.1};
  CAPTURE(layout, loss::name_of(kind));
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    auto logits = logits_of(heads, seed, 2);
    auto adjoint = zeros_like(logits);
    loss::adversarial_adjoint(view(heads, logits), car, kind, weights, 1.0, loss::to_add_to(adjoint));
    // CIoU's α is a constant to its gradient: hold it at its value here.
    const auto alphas = [&] {
      std::vector<double> values;
      for (std::size_t head = 0; head < 2; ++head)
        for (const auto& candidate : loss::matched_candidates(view(heads, logits), head, car))
          values.push_back(
              loss::complete_iou(loss::decoded_box(view(heads, logits), candidate), car.box).alpha);
      return values;
    };
    const auto held = alphas();
    const auto value = [&] {
      double total = loss::adversarial(view(heads, logits), car, kind, weights).total;
      std::size_t match = 0;
      for (std::size_t head = 0; kind == AdversarialLoss::as_coded && head < 2; ++head)
        for (const auto& candidate : loss::matched_candidates(view(heads, logits), head, car)) {
          const auto now = loss::complete_iou(loss::decoded_box(view(heads, logits), candidate), car.box);
          total += weights.iou * (now.alpha - held[match++]) * now.aspect;
        }
      return total;
    };
    const double h = test::central_difference_step<double>();
    const double tolerance = 4 * test::central_difference_tolerance(value());
    for (std::size_t head = 0; head < 2; ++head)
      for (std::size_t i = logits[head].size() / 2; i < logits[head].size(); ++i) {  // of image 1
        const double difference = test::slope_by(logits[head].data()[i], h, value);
        if (std::abs(adjoint[head].data()[i] - difference) <= tolerance) continue;
        CAPTURE(seed, head, i, difference);
        CHECK(adjoint[head].data()[i] == difference);
      }
    const double before = value();
    const auto others = logits_of(heads, seed + 10, 2);
    for (std::size_t head = 0; head < 2; ++head)
      for (std::size_t i = 0; i < logits[head].size() / 2; ++i) {
        REQUIRE(adjoint[head].data()[i] == 0);
        logits[head].data()[i] = others[head].data()[i];
      }
    REQUIRE(value() == before);  // whatever is in image 0
  }
}

TEST_CASE("both orders of a distance head's channels give the same losses", "[loss][anchor_free]") {
  const auto box_first = two_heads(DecodeFamily::distance, ChannelOrder::box_first);
  const auto classes_first = two_heads(DecodeFamily::distance, ChannelOrder::classes_first);
  auto logits = logits_of(box_first, 3, 3);
  auto turned = logits;
  for (std::size_t head = 0; head < 2; ++head)
    loss::for_each_candidate(head, box_first[head], [&](const loss::Candidate& candidate) {
      for (std::size_t c = 0; c < 32 + classes; ++c)
        at(classes_first, turned, candidate, c < 32 ? classes + c : c - 32) =
            at(box_first, logits, candidate, c);
    });
  for (const auto kind : all_kinds) {
    CHECK(loss::adversarial(view(box_first, logits), car, kind).total ==
          loss::adversarial(view(classes_first, turned), car, kind).total);
    auto adjoint = zeros_like(logits), turned_adjoint = adjoint;
    loss::adversarial_adjoint(view(box_first, logits), car, kind, {}, 1.0, loss::to_add_to(adjoint));
    loss::adversarial_adjoint(view(classes_first, turned), car, kind, {}, 1.0,
                              loss::to_add_to(turned_adjoint));
    const loss::Candidate match{1, 0, 3, 6};
    for (std::size_t c = 0; c < 32 + classes; ++c)
      CHECK(at(box_first, adjoint, match, c) ==
            at(classes_first, turned_adjoint, match, c < 32 ? classes + c : c - 32));
  }
}

TEST_CASE("among equal anchor-free candidates the first one is hidden", "[loss][anchor_free]") {
  const auto heads = two_heads(DecodeFamily::distance, ChannelOrder::classes_first, 2);
  auto logits = filled(heads, -60);
  for (const std::size_t column : {2U, 3U}) {  // 8 px to either side of the target's centre
    reach(heads, logits, {0, 0, 1, column}, 0.5);
    at(heads, logits, {0, 0, 1, column}, 1) = 3;
  }
  const loss::Target target{1, {48, 24, 16, 16}};
  const auto found = loss::responsible(view(heads, logits), target);
  REQUIRE(found);
  CHECK(found->candidate == loss::Candidate{0, 0, 1, 2});
  CHECK(found->confidence == found->class_probability);
  CHECK(found->score() == Approx(sigma(3) / 3));
}

TEST_CASE("max_score still pulls where a head without objectness is utterly sure", "[loss][anchor_free]") {
  const auto heads = two_heads(DecodeFamily::distance, ChannelOrder::classes_first, 2);
  auto logits = filled(heads, -60);
  const loss::Candidate candidate{0, 0, 1, 3};
  reach(heads, logits, candidate, 0.5);
  at(heads, logits, candidate, 1) = 100;
  const loss::Target target{1, loss::decoded_box(view(heads, logits), candidate)};
  CHECK(loss::max_score(view(heads, logits), target) == Approx(100).epsilon(1e-12));
  auto adjoint = zeros_like(logits);
  loss::max_score_adjoint(view(heads, logits), target, 1.0, loss::to_add_to(adjoint));
  CHECK(at(heads, adjoint, candidate, 1) == Approx(1).epsilon(1e-12));
}

TEST_CASE("a NaN anywhere among what decides makes an anchor-free loss NaN", "[loss][anchor_free]") {
  const int layout = GENERATE(0, 1, 2);
  const auto heads = layout == 0   ? two_heads(DecodeFamily::yolox)
                     : layout == 1 ? two_heads(DecodeFamily::distance, ChannelOrder::box_first)
                                   : two_heads(DecodeFamily::distance, ChannelOrder::classes_first);
  for (std::size_t channel = 0; channel < heads[1].channel_count(); ++channel) {
    auto logits = logits_of(heads, 4, 6);
    at(heads, logits, {1, 0, 7, 0}, channel) = std::nan("");
    const bool is_other_class = channel == heads[1].class_channel(0) || channel == heads[1].class_channel(2);
    CAPTURE(layout, channel);
    for (const auto kind : {AdversarialLoss::paper, AdversarialLoss::max_score})
      CHECK(std::isnan(loss::adversarial(view(heads, logits), car, kind).total) == !is_other_class);
  }
}

TEST_CASE("the cell of a centre follows a stride that does not divide the input", "[loss][anchor_free]") {
  detect::Head head{1, 7, 7, {}, 1, DecodeFamily::distance};
  const auto cell = [&](double cx, double cy) { return loss::cell_of(head, {cx, cy, 9, 9}, 416, 416); };
  CHECK(cell(383, 10).column == 6);  // as 416 / 7 pixels are a cell
  head.stride = 64;
  CHECK(cell(383, 10).column == 5);
  CHECK(cell(385, 415.9).column == 6);
  CHECK(cell(385, 415.9).row == 6);
  CHECK(!cell(385, 416).exists);  // outside the picture, though not outside the grid
}

TEST_CASE("losses refuse logits that do not fit anchor-free heads", "[loss][anchor_free]") {
  auto heads = two_heads(DecodeFamily::distance);
  const auto logits = logits_of(heads, 5, 1);
  const auto total = [&] {
    return loss::adversarial(view(heads, logits), car, AdversarialLoss::paper).total;
  };
  CHECK(std::isfinite(total()));
  heads[1].bins = 9;
  CHECK_THROWS_WITH(total(), "adversarial: logits is [2, 35, 8, 12], expected [2, 39, 8, 12]");
  heads[1].bins = 0;
  CHECK_THROWS_WITH(total(),
                    "adversarial: a head of the decode family distance has 0 bins, expected 1 to 256");
  heads[1] = two_heads(DecodeFamily::yolox)[1];
  CHECK_THROWS_WITH(total(), "adversarial: logits is [2, 35, 8, 12], expected [2, 8, 8, 12]");
}
