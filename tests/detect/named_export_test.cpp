// Descriptions of exports by one word: facts from the nodes.

#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/exports.hpp"
#include "../support/small_exports.hpp"

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
    const auto found = detect::named_export(io::read_onnx(folder / "leg17.onnx"), "torchvision", 0, 0);
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
                    test::contains("filters of its last convolutions"));
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
                    test::contains("net.onnx: not an export of a detector that chooses the classes itself"));
  CHECK_THROWS_AS(detect::named_export(network, "yolo", 0, 0), DomainError);
  const detect::DetectorDescription description = detect::named_export(network, "yolov8", 0, 0);
  CHECK_THROWS_AS(detect::Detector<float>(network, description), FileError);
}

TEST_CASE("a YOLOX of one class is recognised, with objectness before its class", "[detect][named_export]") {
  const auto network = test::yolox_like(64, 1);
  CHECK(detect::recognised_detector(network) == detect::known_description("yolox"));
  const detect::Detector<double> detector(network, detect::known_description("yolox"));
  CHECK(detector.heads().front().classes == 1);
  // The network's own output, [1, N, 6], read as numbers that are boxes, objectness and class already.
  detect::DetectorDescription own;
  own.encoding = detector.description().encoding;
  own.head = detect::HeadKind::boxes_and_scores;
  own.decoded.boxes = own.decoded.scores = network.outputs.front();
  own.decoded.has_objectness = true;
  const auto pictures = test::pictures<double>(1, 64);
  const auto logits = detect::forward(detector, pictures).front();
  const auto expected =
      detect::forward(detect::Detector<double>(network, own), pictures).front();  // [1, 5, 1, N]
  REQUIRE(logits.shape(1) == 6);
  const auto curve = [](double t) { return 1 / (1 + std::exp(-t)); };
  for (std::size_t cell = 0; cell < 64; ++cell) {
    const auto raw = [&](std::size_t channel) { return logits(0, channel, cell / 8, cell % 8); };
    CHECK(raw(1) == Approx(expected(0, 1, 0, cell)));
    CHECK(curve(raw(4)) * curve(raw(5)) == Approx(curve(expected(0, 4, 0, cell))));
  }
}

TEST_CASE("anchors that an export multiplies by are its own", "[detect][named_export]") {
  auto anchors = detect::known_description("yolov5").anchors;
  CHECK(detect::named_export(test::yolov5_like(64, anchors), "yolov5", 0, 0) ==
        detect::known_description("yolov5"));
  anchors[1] = {{20, 31}, {62, 45}, {59, 112.5}};
  const auto network = test::yolov5_like(64, anchors);
  const auto kind = detect::named_export(network, "yolov5", 0, 0);
  CHECK(kind.anchors == anchors);
  CHECK(detect::Detector<float>(network, kind).heads()[1].anchors == anchors[1]);
  CHECK_THROWS_WITH(detect::Detector<float>(network, detect::known_description("yolov5")),
                    test::contains("anchors that it multiplies extents by"));
}

TEST_CASE("outputs of queries without names are told by their layers", "[detect][named_export]") {
  for (const bool chooses : {false, true}) {
    const auto network = test::detr_like(64, chooses);
    const auto kind = detect::named_export(network, chooses ? "rt_detr" : "detr", 0, 0);
    CHECK(kind.decoded.scores == network.outputs[0]);
    CHECK(kind.decoded.boxes == network.outputs[1]);
    const detect::Detector<float> detector(network, kind);
    CHECK(detector.heads().front().classes == test::exported_classes + (chooses ? 1 : 0));
    CHECK_THROWS_WITH(detect::named_export(network, chooses ? "detr" : "rt_detr", 0, 0),
                      test::contains("not an export of"));
  }
}

TEST_CASE("the layer that all heads of a decoded output see is a map", "[detect][exports][named_export]") {
  const auto [name, file, word] = GENERATE(
      std::tuple("faster_rcnn", "leg17.onnx", "torchvision"),
      std::tuple("mask_rcnn", "leg13.onnx", "torchvision"), std::tuple("ssd", "leg17.onnx", "torchvision"),
      std::tuple("retinanet", "leg17.onnx", "torchvision"),
      std::tuple("yolov10_like", "leg17.onnx", "end_to_end"),
      std::tuple("yolov8_like", "leg17.onnx", "yolov8"), std::tuple("yolov8_like", "qdq.onnx", "yolov8"));
  with_export(name, [file = file, word = word](const std::filesystem::path& folder) {
    const auto network = io::read_onnx(folder / file);
    const auto kind = detect::named_export(network, word, 4, 0);
    const std::string layer = detect::common_layer(network, kind);
    CAPTURE(folder.string(), layer);
    REQUIRE(!layer.empty());
    const detect::Detector<float> detector(network, kind, 0, {layer});
    detect::Pass<float> pass;
    detector.forward(test::picture_of(detector, folder), pass, detect::Mode::input_gradient);
    const Array<float, 4> ones = filled<float, 4>(pass.logits.front().shape(), 1.0F);
    const auto slope = detector.layer_adjoint(pass, {&ones}, 0, 0);
    CHECK(slope.shape(1) * slope.shape(2) > 1);
    CHECK(std::ranges::any_of(slope.storage(), [](float value) { return value != 0; }));
  });
}
