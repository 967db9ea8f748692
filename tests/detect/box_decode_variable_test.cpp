#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/box_formula.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;
using detect::DecodeFamily;

namespace {
constexpr std::size_t height = 64, width = 96;

detect::Head head_of(DecodeFamily family) {
  detect::Head head{3, 2, 3, {{{10.0, 20.0}}, {{30.0, 16.0}}}, 1.2, family};
  if (!detect::has_anchors(family)) head.anchors.clear();
  if (family == DecodeFamily::distance) head.order = detect::ChannelOrder::classes_first;
  return head;
}

detect::Head exclusive_head() {
  auto head = head_of(DecodeFamily::darknet);
  head.exclusive_classes = true;
  return head;
}

/// Two images' outputs as the family gives them.
template <class T>
Array<T, 4> outputs(DecodeFamily family) {
  const bool is_activation = family == DecodeFamily::scaled;
  return random_array<T>({2, head_of(family).channel_count(), 2, 3}, 1, is_activation ? 0.05 : -2,
                         is_activation ? 0.95 : 2);
}

detect::Head any_head() {
  return GENERATE(head_of(DecodeFamily::darknet), exclusive_head(), head_of(DecodeFamily::ultralytics),
                  head_of(DecodeFamily::scaled), head_of(DecodeFamily::yolox),
                  head_of(DecodeFamily::distance), head_of(DecodeFamily::decoded));
}
}  // namespace

TEST_CASE("decode on the tape gives the boxes and scores of decode()", "[detect][decode]") {
  const auto head = any_head();
  const auto logits = outputs<double>(head.decode);
  const auto decoded = detect::decode<double>(head, logits, height, width);
  for (std::size_t image = 0; image < 2; ++image) {
    const auto expected = detect::decode<double>({head}, {logits}, image, 0, height, width);
    REQUIRE(expected.size() == head.candidate_count() * 3);
    for (const auto& detection : expected) {
      const std::size_t i = detection.candidate;
      const auto& boxes = decoded.boxes.value();
      CHECK(boxes(image, i, 0) == detection.box.cx);
      CHECK(boxes(image, i, 1) == detection.box.cy);
      CHECK(boxes(image, i, 2) == detection.box.w);
      CHECK(boxes(image, i, 3) == detection.box.h);
      CHECK(decoded.objectness.value()(image, i, 0) == detection.objectness);
      CHECK(detect::confidences(decoded).value()(image, i, detection.class_index) == detection.confidence);
    }
  }
}

TEMPLATE_TEST_CASE("the adjoint of decoded heads agrees with central differences", "[detect][gradient]",
                   float, double) {
  const auto head = any_head();
  const auto start = outputs<TestType>(head.decode);
  const auto direction = test::random_direction<TestType>({2, head.channel_count(), 2, 3}, 2);
  const std::size_t count = head.candidate_count();
  const std::vector<Array<TestType, 3>> weights{random_array<TestType>({2, count, 4}, 3, -0.02, 0.02),
                                                random_array<TestType>({2, count, 1}, 4, -1, 1),
                                                random_array<TestType>({2, count, 3}, 5, -1, 1)};
  const auto value = [&](const Array<TestType, 4>& logits) {
    const auto decoded = detect::decode<TestType>(head, logits, height, width);
    return dot(decoded.boxes.value(), weights[0]) + dot(decoded.objectness.value(), weights[1]) +
           dot(decoded.classes.value(), weights[2]);
  };
  ActiveTape<TestType> tape;
  const auto logits = tape.input(start);
  const auto decoded = detect::decode(head, logits, height, width);
  double found = 0;  // of three sweeps, each with two heads' results untouched
  tape.reverse(decoded.boxes, weights[0]);
  found += static_cast<double>(dot(logits.adjoint(), direction));
  tape.reverse(decoded.objectness, weights[1]);
  found += static_cast<double>(dot(logits.adjoint(), direction));
  tape.reverse(decoded.classes, weights[2]);
  found += static_cast<double>(dot(logits.adjoint(), direction));
  CHECK(std::abs(found - static_cast<double>(central_difference(value, start, direction))) <=
        static_cast<double>(test::central_difference_tolerance(value(start))));
}

TEST_CASE("a bounded extent has no slope, and what is not asked for adds no NaN", "[detect][decode]") {
  const auto head = head_of(DecodeFamily::darknet);
  auto start = tapestry::zeros<double, 4>({1, 16, 2, 3});
  start(0, 2, 0, 0) = detect::largest_extent_logit + 1;
  start(0, 3, 0, 1) = 1e308;
  ActiveTape<double> tape;
  const auto logits = tape.input(start);
  const auto decoded = detect::decode(head, logits, height, width);
  tape.reverse(decoded.boxes, tapestry::filled<double, 3>({1, 12, 4}, 1));
  CHECK(logits.adjoint()(0, 2, 0, 0) == 0);
  CHECK(logits.adjoint()(0, 3, 0, 1) == 0);
  CHECK(logits.adjoint()(0, 2, 0, 1) == 10);  // e⁰ times the anchor
}

TEST_CASE("decode on the tape refuses logits of another head", "[detect][decode]") {
  CHECK_THROWS_WITH(
      detect::decode<float>(head_of(DecodeFamily::darknet), tapestry::zeros<float, 4>({1, 14, 2, 3}), 64, 96),
      "decode: logits is [1, 14, 2, 3], expected [1, 16, 2, 3]");
}
