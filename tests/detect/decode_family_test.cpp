#include <tapestry/detect/box_formula.hpp>
#include <tapestry/io/darknet/model_file.hpp>

#include "../support/random_array.hpp"
#include "../support/random_model.hpp"
#include "../support/refusal.hpp"

using namespace tapestry;
using detect::DecodeFamily, detect::Head;

namespace {
const double not_a_number = std::numeric_limits<double>::quiet_NaN();
const double log_3 = std::log(3.0);  // σ(log 3) = ¾, σ(−log 3) = ¼

Head small_head(DecodeFamily family, double scale_x_y = 1.2) {
  return {2, 2, 3, {{{10.0, 20.0}}}, scale_x_y, family};
}

/// Outputs [1, 7, 2, 3] of no object anywhere.
Array<double, 4> empty_outputs(DecodeFamily family) {
  return tapestry::filled<double, 4>({1, 7, 2, 3}, family == DecodeFamily::scaled ? 0.0 : -20.0);
}

/// Output of a head of the family for a logit of the other families.
double output(DecodeFamily family, double logit) {
  return family == DecodeFamily::scaled ? nn::logistic(logit) : logit;
}

std::vector<detect::Detection> decoded(const Head& head, const Array<double, 4>& outputs,
                                       double threshold = 0.25) {
  return detect::decode<double>({head}, {outputs}, 0, threshold, 64, 96);
}

const std::string two_convolutions = test::cfg_text("two_convolutions");

std::string with_logistic(const std::string& more) {
  std::string text = two_convolutions;
  return text.replace(text.find("linear"), 6, "logistic") + more;
}

detect::NetworkConfig parsed(const std::string& text) { return io::parse_network_config(text, "some.cfg"); }
}  // namespace

TEST_CASE("decode families have names", "[detect][decode_family]") {
  for (const auto family : detect::decode_families)
    CHECK(detect::decode_family_by_name(detect::name_of(family)) == family);
  CHECK(detect::name_of(DecodeFamily::scaled) == "scaled");
  CHECK_THROWS_WITH(detect::decode_family_by_name("yolov5"),
                    "no decode family is called 'yolov5'; expected darknet, ultralytics, scaled, yolox, "
                    "distance or decoded");
  CHECK_THROWS_AS(detect::decode_family_by_name(""), DomainError);
  CHECK(Head{}.decode == DecodeFamily::darknet);
}

TEST_CASE("each decode family puts a box where its formula says", "[detect][decode_family]") {
  struct Row {
    DecodeFamily family;
    double cx, cy, w, h;
  };
  // Cells of 32 px, anchor 10 × 20, s = 1.2, at row 1 and column 2; σ of the logits is ¾, ¼, ½, ¾.
  const std::vector<Row> rows{{DecodeFamily::darknet, (2 + 0.8) * 32, (1 + 0.2) * 32, 10, 3 * 20},
                              {DecodeFamily::ultralytics, (2 + 1) * 32, (1 + 0) * 32, 10, 2.25 * 20},
                              {DecodeFamily::scaled, (2 + 0.8) * 32, (1 + 0.2) * 32, 10, 2.25 * 20}};
  for (const Row& row : rows) {
    CAPTURE(detect::name_of(row.family));
    auto outputs = empty_outputs(row.family);
    const double logits[6] = {log_3, -log_3, 0, log_3, log_3, log_3};
    for (std::size_t c = 0; c < 6; ++c) outputs(0, c, 1, 2) = output(row.family, logits[c]);
    const auto found = decoded(small_head(row.family), outputs);
    REQUIRE(found.size() == 1);
    CHECK(found[0].class_index == 0);
    CHECK(found[0].candidate == 5);
    CHECK(found[0].objectness == Approx(0.75).epsilon(1e-14));
    CHECK(found[0].confidence == Approx(0.5625).epsilon(1e-14));
    CHECK(found[0].box.cx == Approx(row.cx).epsilon(1e-14));
    CHECK(found[0].box.cy == Approx(row.cy).epsilon(1e-14));
    CHECK(found[0].box.w == Approx(row.w).epsilon(1e-14));
    CHECK(found[0].box.h == Approx(row.h).epsilon(1e-14));
    CHECK(decoded(small_head(row.family), outputs, 0.5626).empty());
  }
}

TEST_CASE("each decode family has its range, reached by saturated logits", "[detect][decode_family]") {
  struct Row {
    DecodeFamily family;
    double scale_x_y, offset_low, offset_high, extent_high;
  };
  const double bounded = std::exp(detect::largest_extent_logit);
  const std::vector<Row> rows{{DecodeFamily::darknet, 1, 0, 1, bounded},
                              {DecodeFamily::darknet, 1.2, -0.1, 1.1, bounded},
                              {DecodeFamily::ultralytics, 1, -0.5, 1.5, 4},
                              {DecodeFamily::ultralytics, 1.2, -0.5, 1.5, 4},  // scale_x_y plays no part
                              {DecodeFamily::scaled, 1, 0, 1, 4},
                              {DecodeFamily::scaled, 1.2, -0.1, 1.1, 4},
                              {DecodeFamily::scaled, 2, -0.5, 1.5, 4}};
  for (const Row& row : rows) {
    CAPTURE(detect::name_of(row.family), row.scale_x_y);
    const Head head = small_head(row.family, row.scale_x_y);
    for (const double size : {100.0, 800.0, 1e30}) {
      const double high = output(row.family, size), low = output(row.family, -size);
      CHECK(detect::centre_offset(head, low) == Approx(row.offset_low).margin(1e-15));
      CHECK(detect::centre_offset(head, high) == Approx(row.offset_high));
      CHECK(detect::extent_factor(head, low) == Approx(0).margin(1e-40));
      CHECK(detect::extent_factor(head, high) == Approx(row.extent_high));
      CHECK(detect::probability(head, low) == Approx(0).margin(1e-40));
      CHECK(detect::probability(head, high) == 1);
    }
  }
}

TEST_CASE("T10: saturated outputs decode to finite boxes and NaN to none, in each family",
          "[detect][decode_family]") {
  const auto family = GENERATE(DecodeFamily::darknet, DecodeFamily::ultralytics, DecodeFamily::scaled);
  CAPTURE(detect::name_of(family));
  auto outputs = empty_outputs(family);
  for (std::size_t c = 0; c < 7; ++c) {
    outputs(0, c, 0, 0) = output(family, 1e4);
    outputs(0, c, 0, 1) = output(family, c < 4 ? -1e4 : 100);
    outputs(0, c, 0, 2) = not_a_number;
  }
  CHECK(decoded(small_head(family), outputs).size() == 4);
  for (const auto& detection : decoded(small_head(family), outputs)) {
    CHECK(std::isfinite(detection.box.cx + detection.box.cy + detection.box.w + detection.box.h));
    CHECK(detection.confidence == 1);
  }
  for (std::size_t missing = 0; missing < 6; ++missing) {  // class 1 is left
    outputs = empty_outputs(family);
    for (std::size_t c = 0; c < 6; ++c) outputs(0, c, 1, 0) = c == missing ? not_a_number : output(family, 9);
    CHECK(decoded(small_head(family), outputs).empty());
  }
}

TEST_CASE("scaled with s = 2 is ultralytics after the logistic function", "[detect][decode_family]") {
  const Array<double, 4> logits = test::random_array<double>({1, 7, 2, 3}, 1, -4, 4);
  Array<double, 4> activations = logits;
  for (double& value : activations.storage()) value = nn::logistic(value);
  const auto expected = decoded(small_head(DecodeFamily::ultralytics), logits, 0.01);
  const auto found = decoded(small_head(DecodeFamily::scaled, 2), activations, 0.01);
  REQUIRE(expected.size() > 5);
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].confidence == expected[i].confidence);
    CHECK(found[i].box.cx == Approx(expected[i].box.cx).epsilon(1e-14));
    CHECK(found[i].box.cy == Approx(expected[i].box.cy).epsilon(1e-14));
    CHECK(found[i].box.w == expected[i].box.w);
    CHECK(found[i].box.h == expected[i].box.h);
  }
}

TEST_CASE("new_coords=1 of a cfg makes heads scaled", "[detect][decode_family]") {
  CHECK(detect::decode_family_of(parsed(two_convolutions)) == DecodeFamily::darknet);
  CHECK(detect::decode_family_of(parsed(two_convolutions + "new_coords=0\n")) == DecodeFamily::darknet);
  const auto config = parsed(with_logistic("new_coords=1\nscale_x_y=2.0\n"));
  CHECK(config.warnings.empty());
  CHECK(detect::decode_family_of(config) == DecodeFamily::scaled);
  CHECK(detect::decode_warnings(config).empty());

  // The same parameters without σ in the network, and decoded as ultralytics.
  const auto scaled = test::random_model<double>(config, 1);
  const auto raw =
      test::random_model<double>(detect::with_decode(parsed(two_convolutions), DecodeFamily::ultralytics), 1);
  REQUIRE(scaled.heads()[0].decode == DecodeFamily::scaled);
  REQUIRE(raw.heads()[0].decode == DecodeFamily::ultralytics);
  const Array<double, 4> images = test::random_array<double>({1, 64, 64, 3}, 2);
  const auto detections = [&](const detect::DarknetModel<double>& network) {
    return detect::decode(network.heads(), detect::forward(network.detector(), images), 0, 0.2, 64, 64);
  };
  const auto found = detections(scaled), expected = detections(raw);
  REQUIRE(found.size() == expected.size());
  REQUIRE(found.size() > 100);
  for (std::size_t i = 0; i < found.size(); ++i) {
    CHECK(found[i].candidate == expected[i].candidate);
    CHECK(found[i].confidence == Approx(expected[i].confidence).epsilon(1e-12));
    CHECK(detect::iou(found[i].box, expected[i].box) > 1 - 1e-12);
  }
}

TEST_CASE("a decode family that contradicts the cfg is refused", "[detect][decode_family]") {
  const auto with = [](const std::string& text, DecodeFamily family) {
    return detect::decode_family_of(detect::with_decode(parsed(text), family));
  };
  for (const auto family : {DecodeFamily::darknet, DecodeFamily::ultralytics})
    CHECK(with(two_convolutions, family) == family);
  CHECK(with(with_logistic(""), DecodeFamily::scaled) == DecodeFamily::scaled);
  CHECK(with(with_logistic("new_coords=1\n"), DecodeFamily::scaled) == DecodeFamily::scaled);
  test::check_refused(ErrorKind::mismatch,
                      "some.cfg:16: layer 2 (yolo): new_coords=1 contradicts the requested decode "
                      "family; expected scaled, found ultralytics",
                      [&] { (void)with(with_logistic("new_coords=1\n"), DecodeFamily::ultralytics); });
  test::check_refused(ErrorKind::mismatch, "expected activation=logistic in a [convolutional] layer",
                      [&] { (void)with(two_convolutions, DecodeFamily::scaled); });
  test::check_refused(ErrorKind::mismatch,
                      "some.cfg:16: layer 2 (yolo): a decode family without anchors; expected darknet, "
                      "ultralytics or scaled, found yolox",
                      [&] { (void)with(two_convolutions, DecodeFamily::yolox); });
}

TEST_CASE("a [region] is of the family darknet alone", "[detect][decode_family]") {
  const std::string text = test::cfg_text("region_layers");
  CHECK(detect::decode_family_of(parsed(text)) == DecodeFamily::darknet);
  CHECK(detect::decode_family_of(detect::with_decode(parsed(text), DecodeFamily::darknet)) ==
        DecodeFamily::darknet);
  test::check_refused(ErrorKind::mismatch,
                      "layer 7 (region): a [region] contradicts the requested decode family; "
                      "expected darknet, found ultralytics",
                      [&] { (void)detect::with_decode(parsed(text), DecodeFamily::ultralytics); });
}

TEST_CASE("σ taken twice is remarked on", "[detect][decode_family]") {
  CHECK(detect::decode_warnings(parsed(two_convolutions)).empty());
  const auto warnings = detect::decode_warnings(parsed(with_logistic("")));
  REQUIRE(warnings.size() == 1);
  CHECK(warnings[0] ==
        "some.cfg:16: decode family darknet takes the logistic function of outputs of activation=logistic; "
        "is it scaled "
        "(new_coords=1)?");
}
