// Descriptions of exports by one word: what the nodes show.
#include <tapestry/detect/exported_heads.hpp>

#include <algorithm>
#include <cmath>
#include <string>
#include <tapestry/detect/detector.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <vector>

#include "../support/catch.hpp"
#include "../support/exports.hpp"
#include "../support/raw_numbers.hpp"
#include "../support/small_exports.hpp"

namespace detect = tapestry::detect;
namespace io = tapestry::io;
using namespace tapestry;
using test::with_export;

TEST_CASE("torchvision's two stages are read before their suppression", "[detect][exports][named_export]") {
  const auto [name, file] =
      GENERATE(std::pair("faster_rcnn", "leg17.onnx"), std::pair("mask_rcnn", "leg13.onnx"));
  with_export(name, [file = file](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / file);
    CHECK(detect::recognised_export(network) == "torchvision");
    const auto found = detect::named_export(network, "torchvision", 0, 0);
    CHECK(found.head == detect::HeadKind::boxes_and_scores);
    CHECK(found.decoded.boxes == "/m/roi_heads/Reshape_2_output_0");
    CHECK(found.decoded.scores == "/m/roi_heads/box_predictor/cls_score/Gemm_output_0");
    CHECK(found.decoded.has_box_for_each_class);
    CHECK(found.decoded.score_form == detect::ScoreForm::softmax);
    CHECK(found.decoded.background == detect::Background::first);
    CHECK(found.decoded.form == detect::BoxForm::corners);
  });
}

TEST_CASE("torchvision's SSD is read before its suppression", "[detect][exports][named_export]") {
  with_export("ssd", [](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / "leg17.onnx");
    const auto found = detect::named_export(network, "torchvision", 0, 0);
    CHECK(found.decoded.boxes == "/m/Reshape_output_0");
    CHECK(found.decoded.scores == "/m/head/classification_head/Concat_8_output_0");
    CHECK_FALSE(found.decoded.has_box_for_each_class);
  });
}

TEST_CASE("torchvision's RetinaNet is read before its suppression, with the number of classes from names",
          "[detect][exports][named_export]") {
  with_export("retinanet", [](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / "leg17.onnx");
    const auto found = detect::named_export(network, "torchvision", 6, 0);
    CHECK(found.head == detect::HeadKind::end_to_end);
    CHECK(found.decoded.boxes == "/m/Concat_25_output_0");
    CHECK(found.decoded.scores == "/m/Concat_26_output_0");
    CHECK(found.decoded.labels == "/m/Concat_27_output_0");
    CHECK(found.decoded.classes == 6);
    CHECK_THROWS_WITH(detect::named_export(network, "torchvision", 0, 0),
                      test::contains("do not tell the number of classes"));
    const detect::Detector<float> detector(network, found);
    detect::Pass<float> pass;
    detector.forward(test::picture_of(detector, folder), pass);
    test::require_results(folder, detector.detections(pass.logits, 0, 0.01, 1), true);
  });
}

TEST_CASE("outputs of YOLOv8 are read with logits for scores", "[detect][exports][named_export]") {
  with_export("yolov8_like", [](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / "leg17.onnx");
    const auto found = detect::named_export(network, "yolov8", 0, 0);
    CHECK(found.decoded.score_form == detect::ScoreForm::logits);
    const detect::Detector<double> detector(network, found);
    const auto logits = detect::forward(detector, test::picture_of(detector, folder)).front();
    const auto output = test::raw_numbers<double>(folder / "out.0.bin");  // [1, 4 + K, N]
    REQUIRE(logits.size() == output.size());
    const std::size_t boxes = 4 * logits.shape(3);
    for (std::size_t i = 0; i < output.size(); ++i) {
      const double value = i < boxes ? logits.data()[i] : 1 / (1 + std::exp(-logits.data()[i]));
      CHECK(std::abs(value - output[i]) <= 1e-6 * (1 + std::abs(output[i])));
    }
  });
}

TEST_CASE("outputs of YOLOv10 are read as they are", "[detect][exports][named_export]") {
  with_export("yolov10_like", [](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / "leg17.onnx");
    const detect::Detector<double> detector(network, detect::named_export(network, "end_to_end", 8, 0));
    detect::Pass<double> pass;
    detector.forward(test::picture_of(detector, folder), pass);
    const auto found = detector.detections(pass.logits, 0, 1e-6, 1);
    const auto rows = test::raw_numbers<double>(folder / "out.0.bin");
    REQUIRE(!rows.empty());
    for (std::size_t row = 0; row < rows.size(); row += 6)
      CHECK(std::ranges::any_of(found, [&](const detect::Detection& one) {
        return std::abs(one.confidence - rows[row + 4]) <= 1e-6 &&
               one.class_index == static_cast<std::size_t>(rows[row + 5]) &&
               std::abs(one.box.cx - (rows[row] + rows[row + 2]) / 2) <= 1e-4;
      }));
  });
}

TEST_CASE("PicoDet has four grids, in the form of NanoDet's", "[detect][named_export]") {
  const auto network = test::nanodet_like(128, 4);
  const auto kind = detect::named_export(network, "picodet", 0, 0);
  CHECK(kind.encoding == detect::imagenet_encoding);
  const detect::Detector<float> detector(network, kind);
  REQUIRE(detector.heads().size() == 4);
  CHECK(detector.heads().back().stride == 64);
  CHECK(detector.heads().back().classes == test::exported_classes);
  CHECK_THROWS_WITH(detect::Detector<float>(test::nanodet_like(128), kind),
                    test::contains("grids of outputs"));
}

TEST_CASE("words that do not fit a network are refused", "[detect][named_export][error]") {
  nn::NetworkDescription network;
  network.path = "net.onnx";
  network.opset = 17;
  network.inputs = {{"x", {1, 3, 4, 4}}};
  network.nodes = {{"", "Relu", {"x"}, {"y"}, {}}};
  network.outputs = {"y"};
  CHECK(detect::recognised_export(network).empty());
  CHECK_THROWS_WITH(detect::named_export(network, "torchvision", 0, 0),
                    test::contains("net.onnx: not an export of a torchvision detector"));
  CHECK_THROWS_WITH(detect::named_export(network, "end_to_end", 0, 0),
                    test::contains("give the file of their names (--names)"));
  CHECK_THROWS_AS(detect::named_export(network, "yolo", 0, 0), DomainError);
  const detect::DetectorDescription description = detect::named_export(network, "yolov8", 0, 0);
  CHECK_THROWS_AS(detect::Detector<float>(network, description), FileError);
}
