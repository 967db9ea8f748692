#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/box_formula.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;
using detect::ChannelOrder, detect::DecodeFamily, detect::Head;

namespace {
constexpr std::size_t height = 64, width = 96;  // 2 × 3 cells of 32 pixels
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

Head yolox_head(std::size_t classes = 3) { return {classes, 2, 3, {}, 1, DecodeFamily::yolox}; }

Head distance_head(ChannelOrder order, std::size_t bins = 8, std::size_t classes = 3) {
  return {classes, 2, 3, {}, 1, DecodeFamily::distance, bins, order};
}

double sigma(double x) { return 1 / (1 + std::exp(-x)); }

std::vector<detect::Detection> decoded(const Head& head, const Array<double, 4>& logits,
                                       double threshold = 0.25) {
  return detect::decode<double>({head}, {logits}, 0, threshold, height, width);
}

/// The reach of one side in cells by its definition, without any care for large logits.
double plain_reach(const Array<double, 4>& logits, std::size_t first, std::size_t bins, std::size_t row,
                   std::size_t column) {
  double weighted = 0, sum = 0;
  for (std::size_t bin = 0; bin < bins; ++bin) {
    const double weight = std::exp(logits(0, first + bin, row, column));
    weighted += weight * static_cast<double>(bin);
    sum += weight;
  }
  return weighted / sum;
}
}  // namespace

TEST_CASE("a head says where its channels are", "[detect][head]") {
  const Head anchored{3, 2, 3, {{{10, 20}}, {{30, 40}}}, 1, DecodeFamily::ultralytics};
  CHECK(anchored.channel_count() == 16);
  CHECK(anchored.candidate_count() == 12);
  CHECK(anchored.objectness_channel().value() == 4);
  CHECK(anchored.class_channel(2) == 7);
  CHECK(yolox_head().channel_count() == 8);
  CHECK(yolox_head().candidate_count() == 6);
  CHECK(yolox_head().objectness_channel().value() == 4);
  CHECK(yolox_head().class_channel(2) == 7);

  const Head nanodet{80, 52, 52, {}, 1, DecodeFamily::distance, 8, ChannelOrder::classes_first};
  CHECK(nanodet.channel_count() == 112);
  CHECK(nanodet.candidate_count() == 2704);
  CHECK(!nanodet.objectness_channel());
  CHECK(nanodet.class_channel(79) == 79);
  CHECK(nanodet.box_channel() == 80);
  CHECK(nanodet.box_channel_count() == 32);
  const Head yolov8{80, 80, 80, {}, 1, DecodeFamily::distance, 16, ChannelOrder::box_first};
  CHECK(yolov8.channel_count() == 144);
  CHECK(yolov8.box_channel() == 0);
  CHECK(yolov8.class_channel(0) == 64);
}

TEST_CASE("a yolox box equals the one worked out by hand", "[detect][anchor_free]") {
  auto logits = tapestry::filled<double, 4>({1, 8, 2, 3}, -20);
  const double values[6] = {0.25, -1.5, std::log(2.0), std::log(0.5), std::log(3.0), 0};
  for (std::size_t c = 0; c < 6; ++c) logits(0, c, 1, 2) = values[c];
  const auto found = decoded(yolox_head(), logits);
  REQUIRE(found.size() == 1);
  CHECK(found[0].candidate == 5);
  CHECK(found[0].class_index == 0);
  CHECK(found[0].objectness == Approx(0.75).epsilon(1e-14));
  CHECK(found[0].confidence == Approx(0.375).epsilon(1e-14));
  CHECK(found[0].box.cx == Approx((2 + 0.25) * 32).epsilon(1e-14));
  CHECK(found[0].box.cy == Approx((1 - 1.5) * 32).epsilon(1e-14));
  CHECK(found[0].box.w == Approx(64).epsilon(1e-14));
  CHECK(found[0].box.h == Approx(16).epsilon(1e-14));
}

TEST_CASE("a box of distances equals the one worked out by hand", "[detect][anchor_free]") {
  // Two bins: a distance is σ of the second logit less the first. ¼ cell left, ¾ top, ½ right, 0.9 down.
  const double second[4] = {-std::log(3.0), std::log(3.0), 0, std::log(9.0)};
  const auto order = GENERATE(ChannelOrder::box_first, ChannelOrder::classes_first);
  const Head head = distance_head(order, 2);
  auto logits = tapestry::filled<double, 4>({1, 11, 2, 3}, -20);
  const std::size_t first_box = order == ChannelOrder::box_first ? 0 : 3;
  const std::size_t first_class = order == ChannelOrder::box_first ? 8 : 0;
  for (std::size_t side = 0; side < 4; ++side) {
    logits(0, first_box + 2 * side, 0, 1) = 5;
    logits(0, first_box + 2 * side + 1, 0, 1) = 5 + second[side];
  }
  logits(0, first_class + 1, 0, 1) = std::log(4.0);
  logits(0, first_class + 2, 0, 1) = 0;
  const auto found = decoded(head, logits);
  REQUIRE(found.size() == 2);
  CHECK(found[0].class_index == 1);
  CHECK(found[0].confidence == Approx(0.8).epsilon(1e-14));
  CHECK(found[1].class_index == 2);
  CHECK(found[1].confidence == 0.5);
  CHECK(found[1].objectness == found[0].confidence);  // the surest class of the candidate
  for (const auto& detection : found) {
    CHECK(detection.candidate == 1);
    CHECK(detection.box.left() == Approx((1.5 - 0.25) * 32).epsilon(1e-13));
    CHECK(detection.box.top() == Approx((0.5 - 0.75) * 32).epsilon(1e-13));
    CHECK(detection.box.right() == Approx((1.5 + 0.5) * 32).epsilon(1e-13));
    CHECK(detection.box.bottom() == Approx((0.5 + 0.9) * 32).epsilon(1e-13));
  }
}

TEST_CASE("anchor-free boxes equal their definition at random logits", "[detect][anchor_free]") {
  const auto yolox = random_array<double>({1, 8, 2, 3}, 1, -3, 3);
  const auto of_yolox = decoded(yolox_head(), yolox, 0);
  REQUIRE(of_yolox.size() == 18);
  for (const auto& d : of_yolox) {
    const std::size_t row = d.candidate / 3, column = d.candidate % 3;
    CHECK(d.box.cx == Approx((yolox(0, 0, row, column) + static_cast<double>(column)) * 32).margin(1e-12));
    CHECK(d.box.cy == Approx((yolox(0, 1, row, column) + static_cast<double>(row)) * 32).margin(1e-12));
    CHECK(d.box.w == Approx(std::exp(yolox(0, 2, row, column)) * 32).epsilon(1e-14));
    CHECK(d.box.h == Approx(std::exp(yolox(0, 3, row, column)) * 32).epsilon(1e-14));
    CHECK(d.confidence ==
          Approx(sigma(yolox(0, 4, row, column)) * sigma(yolox(0, 5 + d.class_index, row, column)))
              .epsilon(1e-14));
  }
  const std::size_t bins = GENERATE(1U, 2U, 8U, 16U);
  const auto order = GENERATE(ChannelOrder::box_first, ChannelOrder::classes_first);
  const Head head = distance_head(order, bins);
  Array<double, 4> logits(Extents<4>{1, head.channel_count(), 2, 3});
  Random random(2);
  for (double& value : logits.storage()) value = random.uniform(-3, 3);
  const auto of_distances = decoded(head, logits, 0);
  REQUIRE(of_distances.size() == 18);
  const std::size_t first_box = order == ChannelOrder::box_first ? 0 : 3;
  const std::size_t first_class = order == ChannelOrder::box_first ? 4 * bins : 0;
  for (const auto& d : of_distances) {
    const std::size_t row = d.candidate / 3, column = d.candidate % 3;
    const auto reach = [&](std::size_t side) {
      return 32 * plain_reach(logits, first_box + side * bins, bins, row, column);
    };
    const double x = (static_cast<double>(column) + 0.5) * 32, y = (static_cast<double>(row) + 0.5) * 32;
    CHECK(d.box.left() == Approx(x - reach(0)).margin(1e-11));
    CHECK(d.box.top() == Approx(y - reach(1)).margin(1e-11));
    CHECK(d.box.right() == Approx(x + reach(2)).margin(1e-11));
    CHECK(d.box.bottom() == Approx(y + reach(3)).margin(1e-11));
    CHECK(d.confidence == Approx(sigma(logits(0, first_class + d.class_index, row, column))).epsilon(1e-14));
  }
}

TEST_CASE("a stride that does not divide the input is taken from the head", "[detect][anchor_free]") {
  // 416 pixels in strides of 64 have 7 cells; the last one reaches over the border.
  auto head = distance_head(ChannelOrder::classes_first, 8, 1);
  head.grid_height = head.grid_width = 7;
  head.stride = 64;
  auto logits = tapestry::filled<double, 4>({1, 33, 7, 7}, 0);  // 3.5 cells to every side
  const auto found = detect::decode<double>({head}, {logits}, 0, 0.25, 416, 416);
  REQUIRE(found.size() == 49);
  CHECK(found[48].box.cx == 6.5 * 64);
  CHECK(found[48].box.w == Approx(7 * 64).epsilon(1e-14));
  head.stride = 0;
  CHECK(detect::decode<double>({head}, {logits}, 0, 0.25, 416, 416)[48].box.cx ==
        Approx(6.5 / 7 * 416).epsilon(1e-14));
}

TEST_CASE("saturated anchor-free logits decode to finite boxes and NaN to none", "[detect][anchor_free]") {
  const auto family = GENERATE(DecodeFamily::yolox, DecodeFamily::distance);
  const Head head = family == DecodeFamily::yolox ? yolox_head() : distance_head(ChannelOrder::box_first);
  for (const double size : {100.0, -100.0, 800.0, 1e30}) {
    auto logits = tapestry::zeros<double, 4>({1, head.channel_count(), 2, 3});
    for (std::size_t c = 0; c < head.channel_count(); ++c)
      for (std::size_t column = 0; column < 3; ++column)
        logits(0, c, 0, column) = c >= head.class_channel(0) || head.objectness_channel() == c ? 100
                                  : (c + column) % 3 == 0                                      ? size
                                                                                               : -size;
    std::size_t sure = 0;
    for (const auto& detection : decoded(head, logits, 0.9)) {
      CHECK(std::isfinite(detection.box.cx + detection.box.cy + detection.box.w + detection.box.h));
      CHECK(detection.confidence == 1);
      ++sure;
    }
    CHECK(sure == 9);
  }
  for (std::size_t c = 0; c < head.channel_count(); ++c) {
    auto logits = tapestry::filled<double, 4>({1, head.channel_count(), 2, 3}, -20);
    for (std::size_t i = 0; i < head.channel_count(); ++i) logits(0, i, 1, 0) = i == c ? not_a_number : 9;
    const bool is_class = c >= head.class_channel(0);  // two classes remain beside an objectness
    CHECK(decoded(head, logits).size() == (is_class && head.has_objectness() ? 2 : 0));
  }
}

TEST_CASE("a distance's slope keeps its digits where one bin has everything", "[detect][anchor_free]") {
  const double size = GENERATE(0.5, 5.0, 40.0, 100.0, 600.0);
  // Two bins: d = σ(t), d' = σ(t)·σ(−t), and both sides of it are one number with two signs.
  const detect::BinDistribution two(2, [&](std::size_t bin) { return bin == 1 ? size : 0; });
  const double slope = std::exp(-size) / std::pow(1 + std::exp(-size), 2);
  CHECK(two.mean_slope(1) == Approx(slope).epsilon(1e-13));
  CHECK(two.mean_slope(0) == Approx(-slope).epsilon(1e-13));
  // The last of eight has all but 7·e^−size, so that 7 − d is 28·e^−size.
  const detect::BinDistribution eight(8, [&](std::size_t bin) { return bin == 7 ? size : 0; });
  const double other = std::exp(-size) / (1 + 7 * std::exp(-size));
  CHECK(eight.mean_slope(7) == Approx(28 * other / (1 + 7 * std::exp(-size))).epsilon(1e-13));
  double sum = 0;  // adding one number to all logits changes nothing
  for (std::size_t bin = 0; bin < 8; ++bin) sum += eight.mean_slope(bin);
  CHECK(std::abs(sum) <= 1e-14 * eight.mean_slope(7));
}

TEST_CASE("decode_box_adjoint agrees with central differences on anchor-free heads",
          "[detect][anchor_free][gradient]") {
  const int kind = GENERATE(0, 1, 2, 3);
  const Head head = kind == 0   ? yolox_head()
                    : kind == 1 ? distance_head(ChannelOrder::box_first, 16)
                    : kind == 2 ? distance_head(ChannelOrder::classes_first)
                                : distance_head(ChannelOrder::classes_first, 1);
  const detect::CandidatePlace place{0, 1, 2, width, height};
  const detect::Box box_adjoint{0.3, -0.7, 0.2, 0.9};
  Random random(5);
  std::vector<double> logits(head.channel_count());
  for (double& logit : logits) logit = random.uniform(-3, 3);
  const auto value = [&] {
    const auto box = detect::decode_box(head, place, [&](std::size_t channel) { return logits[channel]; });
    return box.cx * box_adjoint.cx + box.cy * box_adjoint.cy + box.w * box_adjoint.w + box.h * box_adjoint.h;
  };
  std::vector<double> adjoint(head.channel_count());
  detect::decode_box_adjoint(
      head, place, [&](std::size_t channel) { return logits[channel]; }, box_adjoint,
      [&](std::size_t channel, double slope) { adjoint[channel] += slope; });
  const double h = test::central_difference_step<double>();
  for (std::size_t channel = 0; channel < logits.size(); ++channel)
    CHECK(std::abs(adjoint[channel] - test::slope_by(logits[channel], h, value)) <=
          test::central_difference_tolerance(value()));
}

TEST_CASE("the surest class stands for a missing objectness, ties to the first", "[detect][anchor_free]") {
  const Head head = distance_head(ChannelOrder::classes_first, 2);
  std::vector<double> logits(11, 0);
  const auto surest = [&] {
    return detect::surest_channel(head, [&](std::size_t channel) { return logits[channel]; });
  };
  CHECK(surest() == 0);
  logits[1] = logits[2] = 4;
  CHECK(surest() == 1);
  logits[5] = 9;  // of the box
  CHECK(surest() == 1);
  logits[2] = not_a_number;
  CHECK(surest() == 2);
  logits[0] = not_a_number;
  CHECK(surest() == 0);

  ActiveTape<double> tape;
  const auto x = tape.input(random_array<double>({1, 11, 2, 3}, 3, -1, 1));
  const auto of_tape = detect::decode(head, x, height, width);
  CHECK(!of_tape.has_objectness);
  CHECK((detect::confidences(of_tape).value() == of_tape.classes.value()));
  tape.reverse(of_tape.objectness, tapestry::filled<double, 3>({1, 6, 1}, 1));
  for (std::size_t cell = 0; cell < 6; ++cell) {
    double largest = 0, slopes = 0;
    for (std::size_t k = 0; k < 3; ++k)
      largest = std::max(largest, of_tape.classes.value().data()[cell * 3 + k]);
    for (std::size_t c = 0; c < 11; ++c) slopes += x.adjoint().data()[c * 6 + cell];
    CHECK(of_tape.objectness.value().data()[cell] == largest);
    CHECK(slopes == Approx(largest * (1 - largest)).epsilon(1e-12));
  }
}

TEST_CASE("heads that make no sense and logits of other heads are refused", "[detect][anchor_free]") {
  const auto refusal = [](const Head& head, std::size_t channels, const std::string& message) {
    const auto logits = tapestry::zeros<double, 4>({1, channels, 2, 3});
    CHECK_THROWS_WITH(decoded(head, logits), message);
    CHECK_THROWS_WITH(detect::decode<double>(head, logits, height, width), message);
  };
  refusal(yolox_head(), 9, "decode: logits is [1, 9, 2, 3], expected [1, 8, 2, 3]");
  refusal(distance_head(ChannelOrder::box_first), 36,
          "decode: logits is [1, 36, 2, 3], expected [1, 35, 2, 3]");
  auto head = yolox_head();
  head.anchors = {{{10, 20}}};
  refusal(head, 8, "decode: a head of the decode family yolox has 1 anchors, expected none");
  refusal(distance_head(ChannelOrder::box_first, 0), 3,
          "decode: a head of the decode family distance has 0 bins, expected 1 to 256");
  refusal(distance_head(ChannelOrder::box_first, 257), 1031,
          "decode: a head of the decode family distance has 257 bins, expected 1 to 256");
  refusal(distance_head(ChannelOrder::box_first, 8, 0), 32,
          "decode: a head of the decode family distance has no classes, expected at least 1");
}
