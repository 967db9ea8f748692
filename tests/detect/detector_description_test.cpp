#include <tapestry/detect/detector_description.hpp>

#include "../support/catch.hpp"

using namespace tapestry;
using detect::DetectorDescription, detect::HeadKind;

TEST_CASE("kinds of heads have names and families", "[detect][detector_description]") {
  for (const auto kind : detect::head_kinds) CHECK(detect::head_kind_by_name(detect::name_of(kind)) == kind);
  CHECK(detect::decode_family_of(HeadKind::ultralytics) == detect::DecodeFamily::ultralytics);
  CHECK(detect::decode_family_of(HeadKind::nanodet) == detect::DecodeFamily::distance);
  CHECK_THROWS_WITH(detect::head_kind_by_name("distance"),
                    "no kind of head is called 'distance'; expected darknet, ultralytics, yolox, nanodet, "
                    "yolov8, yolov5, boxes_and_scores or end_to_end");
}

TEST_CASE("the heads of a description have the cells of their strides", "[detect][detector_description]") {
  auto description = detect::known_description("nanodet");
  const auto nanodet = detect::heads_of(description, 80, 416, 320);
  REQUIRE(nanodet.size() == 3);
  CHECK(nanodet[0].grid_height == 52);
  CHECK(nanodet[2].grid_width == 10);
  CHECK(nanodet[1].stride == 16);
  CHECK(nanodet[1].channel_count() == 112);
  CHECK(nanodet[1].class_channel(0) == 0);
  CHECK(detect::class_count_of(description, 112) == 80);
  description.strides = {64};
  CHECK(detect::heads_of(description, 80, 416, 416)[0].grid_width == 7);  // 6.5 rounded up

  const auto yolox = detect::heads_of(detect::known_description("yolox"), 80, 416, 416);
  REQUIRE(yolox.size() == 3);
  CHECK(yolox[0].candidate_count() + yolox[1].candidate_count() + yolox[2].candidate_count() == 3549);
  CHECK(yolox[0].channel_count() == 85);
  CHECK(detect::class_count_of(detect::known_description("yolox"), 85) == 80);

  const auto yolov5 = detect::heads_of(detect::known_description("yolov5"), 80, 640, 640);
  CHECK(yolov5[0].candidate_count() + yolov5[1].candidate_count() + yolov5[2].candidate_count() == 25200);
  CHECK(yolov5[1].channel_count() == 255);
  CHECK(detect::class_count_of(detect::known_description("yolov5"), 255) == 80);

  const auto yolov8 = detect::heads_of({{}, {}, HeadKind::yolov8, {8}}, 80, 640, 640);
  CHECK(yolov8[0].channel_count() == 144);
  CHECK(yolov8[0].class_channel(0) == 64);
  CHECK_NOTHROW(detect::require_layout("test", yolov8[0]));
}

TEST_CASE("descriptions that mean no heads are refused", "[detect][detector_description]") {
  CHECK_THROWS_WITH(
      detect::heads_of({{}, {}, HeadKind::darknet, {8, 16}}, 80, 416, 416),
      "heads_of: a description of darknet heads has anchors for 0 of them, expected some for 2");
  CHECK_THROWS_WITH(detect::heads_of({{}, {}, HeadKind::yolox, {8}, {{{4, 4}}}}, 80, 416, 416),
                    "heads_of: a description of yolox heads has anchors for 1 of them, expected some for 0");
  CHECK_THROWS_AS(detect::heads_of({{}, {}, HeadKind::yolov5, {8, 16}, {{{4, 4}}, {}}}, 80, 416, 416),
                  DomainError);
  CHECK_THROWS_AS(detect::heads_of({{}, {}, HeadKind::yolox, {0}}, 80, 416, 416), DomainError);
  CHECK_THROWS_WITH(detect::class_count_of(detect::known_description("nanodet"), 32),
                    "class_count_of: outputs of 32 channels, expected more than 32 for nanodet heads");
  CHECK_THROWS_WITH(detect::class_count_of(detect::known_description("yolov5"), 256),
                    "class_count_of: outputs of 256 channels, expected more than 15 and a multiple of 3 for "
                    "yolov5 heads");
  CHECK_THROWS_WITH(detect::known_description("yolov9"),
                    "no known detector is called 'yolov9'; expected yolox, nanodet, picodet or yolov5");
}
