// A detector that torchvision exported whole, with its own resizing and suppression: its candidates are
// values before the suppression.
#include <tapestry/io/onnx/onnx_file.hpp>

#include "../support/exports.hpp"

using namespace tapestry;
namespace files = std::filesystem;
using test::picture_of, test::require_results, test::with_export;

namespace {
detect::DetectorDescription ssd_description() {
  detect::DetectorDescription description;
  description.head = detect::HeadKind::boxes_and_scores;
  description.decoded.boxes = "/m/Reshape_output_0";  // [candidates, 4], cut at the picture
  description.decoded.scores =
      "/m/head/classification_head/Concat_8_output_0";  // [1, candidates, 1 + classes]
  description.decoded.form = detect::BoxForm::corners;
  description.decoded.score_form = detect::ScoreForm::softmax;
  description.decoded.background = detect::Background::first;
  return description;
}

/// Second stage of a Faster or Mask R-CNN: as many proposals as the picture has, with a box for each class.
detect::DetectorDescription second_stage_description() {
  detect::DetectorDescription description;
  description.head = detect::HeadKind::boxes_and_scores;
  description.decoded.boxes = "/m/roi_heads/Reshape_2_output_0";  // [proposals, 1 + classes, 4]
  description.decoded.scores = "/m/roi_heads/box_predictor/cls_score/Gemm_output_0";
  description.decoded.has_box_for_each_class = true;
  description.decoded.form = detect::BoxForm::corners;
  description.decoded.score_form = detect::ScoreForm::softmax;
  description.decoded.background = detect::Background::first;
  return description;
}

/// What is left after suppression.
detect::DetectorDescription final_description(const nn::NetworkDescription& network) {
  detect::DetectorDescription description;
  description.head = detect::HeadKind::end_to_end;
  description.decoded.boxes = network.outputs[0];
  description.decoded.scores = network.outputs[1];
  description.decoded.labels = network.outputs[2];
  description.decoded.classes = 5;
  description.decoded.form = detect::BoxForm::corners;
  return description;
}

/// Slope of a sum of every seventh class logit along its gradient by the picture, against differences.
void require_slope(const detect::Detector<double>& detector, const Array<double, 4>& picture,
                   double tolerance) {
  detect::Pass<double> pass;
  const auto classes = [&](const Array<double, 4>& x, Array<double, 4>* weights) {
    detector.forward(x, pass, detect::Mode::input_gradient);
    const Array<double, 4>& logits = pass.logits.front();
    const std::size_t first = 4 * logits.shape(3);  // behind the boxes
    if (weights != nullptr) *weights = zeros<double, 4>(logits.shape());
    double sum = 0;
    for (std::size_t i = first; i < logits.size(); i += 7) {
      sum += logits.data()[i];
      if (weights != nullptr) weights->data()[i] = 1;
    }
    return sum;
  };
  Array<double, 4> weights;
  static_cast<void>(classes(picture, &weights));
  Array<double, 4> gradient = zeros<double, 4>(picture.shape());
  detector.input_adjoint(pass, {weights}, gradient);
  double squares = 0;
  for (const double slope : gradient.storage()) squares += slope * slope;
  const double h = 1e-6, length = std::sqrt(squares);
  REQUIRE(length > 0);
  const auto at = [&](double step) {
    Array<double, 4> moved = picture;
    for (std::size_t i = 0; i < moved.size(); ++i) moved.data()[i] += step * gradient.data()[i] / length;
    return classes(moved, nullptr);
  };
  CHECK((at(h) - at(-h)) / (2 * h) == Approx(length).epsilon(tolerance));
}
}  // namespace

TEST_CASE("candidates of a whole SSD, before its suppression, give the framework's boxes and scores",
          "[detect][exports]") {
  with_export("ssd", [](const files::path& folder) {
    const detect::Detector<float> detector(io::read_onnx(folder / "leg17.onnx"), ssd_description());
    detect::Pass<float> pass;
    detector.forward(picture_of(detector, folder), pass);
    require_results(folder, detector.detections(pass.logits, 0, 0.01, 1), false);
  });
}

TEST_CASE("the gradient of a whole SSD's logits by the picture equals differences", "[detect][exports]") {
  with_export("ssd", [](const files::path& folder) {
    const detect::Detector<double> detector(io::read_onnx(folder / "leg17.onnx"), ssd_description());
    require_slope(detector, picture_of(detector, folder), 1e-6);
  });
}

TEST_CASE("proposals of whole Faster and Mask R-CNNs give the framework's boxes and scores, and gradients",
          "[detect][exports]") {
  const auto [name, file] =
      GENERATE(std::pair("faster_rcnn", "leg17.onnx"), std::pair("mask_rcnn", "leg13.onnx"));
  with_export(name, [&, file = file](const files::path& folder) {
    const auto network = io::read_onnx(folder / file);
    const detect::Detector<double> detector(network, second_stage_description());
    const auto picture = picture_of(detector, folder);
    detect::Pass<double> pass;
    detector.forward(picture, pass);
    require_results(folder, detector.detections(pass.logits, 0, 0.01, 1), false);
    require_slope(detector, picture, 1e-5);
  });
}

TEST_CASE(
    "attention to a layer of a network in stages: all slopes by the picture go through its first layers",
    "[detect][exports]") {
  with_export("faster_rcnn", [](const files::path& folder) {
    const std::string layer = "/m/backbone/body/layer1/layer1.2/Relu_output_0";
    const detect::Detector<double> detector(io::read_onnx(folder / "leg17.onnx"), second_stage_description(),
                                            0, {layer});
    const auto picture = picture_of(detector, folder);
    detect::Pass<double> pass;
    detector.forward(picture, pass, detect::Mode::input_gradient);
    const Array<double, 4> weights = filled<double, 4>(pass.logits.front().shape(), 1.0);
    Array<double, 4> direct = zeros<double, 4>(picture.shape()), through = direct;
    detector.input_adjoint(pass, {weights}, direct);
    const auto adjoint = detector.layer_adjoint(pass, {&weights}, 0, 0);
    CHECK(adjoint.shape() == detector.layer_values(pass, 0, 0).shape());
    detector.pull_back_layer(pass, 0, 0, adjoint, through);
    double most = 0;
    for (const double slope : direct.storage()) most = std::max(most, std::abs(slope));
    REQUIRE(most > 0);
    for (std::size_t i = 0; i < direct.size(); ++i)
      REQUIRE(std::abs(direct.data()[i] - through.data()[i]) <= 1e-12 * most);
  });
}

TEST_CASE("what a network in stages does not do is refused", "[detect][exports][error]") {
  with_export("faster_rcnn", [](const files::path& folder) {
    auto description = second_stage_description();
    const auto network = io::read_onnx(folder / "leg17.onnx");
    const detect::Detector<float> detector(network, description);
    CHECK(detector.weights().size() == 0);
    CHECK(detector.share_kept({0, 0, 8, 8}) == 0);
    const auto picture = picture_of(detector, folder);
    detect::Pass<float> pass;
    CHECK_THROWS_WITH(detector.forward(picture, pass, detect::Mode::training),
                      test::contains("a network whose extents depend on the picture does not train"));
    detector.forward(picture, pass);
    CHECK_THROWS_AS(detector.pull_back(pass, {&pass.logits[0]}, nullptr), DomainError);
    description.decoded.most_candidates = 1;
    const detect::Detector<float> narrow(network, description);
    CHECK_THROWS_WITH(narrow.forward(picture, pass), test::contains("candidates in a picture, at most 1"));
  });
}

TEST_CASE("a batch through a network in stages has the bits of its pictures", "[detect][exports]") {
  with_export("faster_rcnn", [](const files::path& folder) {
    const detect::Detector<float> detector(io::read_onnx(folder / "leg17.onnx"), second_stage_description());
    const auto picture = picture_of(detector, folder);
    Array<float, 4> batch(Extents<4>{2, picture.shape(1), picture.shape(2), 3});
    std::copy(picture.begin(), picture.end(), batch.begin());
    std::reverse_copy(picture.begin(), picture.end(),
                      batch.begin() + static_cast<std::ptrdiff_t>(picture.size()));
    detect::Pass<float> pass, alone;
    detector.forward(batch, pass, detect::Mode::input_gradient);
    Array<float, 4> gradient = zeros<float, 4>(batch.shape());
    const auto weights = filled<float, 4>(pass.logits.front().shape(), 1.0F);
    detector.input_adjoint(pass, {weights}, gradient);
    for (std::size_t n = 0; n < 2; ++n) {
      Array<float, 4> one(picture.shape()), of_one = zeros<float, 4>(picture.shape());
      std::copy_n(batch.data() + n * one.size(), one.size(), one.data());
      detector.forward(one, alone, detect::Mode::input_gradient);
      const Array<float, 4>& logits = alone.logits.front();
      CHECK(std::equal(logits.begin(), logits.end(), pass.logits.front().data() + n * logits.size()));
      detector.input_adjoint(alone, {filled<float, 4>(logits.shape(), 1.0F)}, of_one);
      CHECK(std::equal(of_one.begin(), of_one.end(), gradient.data() + n * of_one.size()));
    }
  });
}

TEST_CASE("a network of a picture [3, H, W] is one of [1, 3, H, W]", "[detect][exports]") {
  with_export("yolov8_like", [](const files::path& folder) {
    auto network = io::read_onnx(folder / "leg17.onnx");
    const auto description = detect::named_export(network, "yolov8", 0, 0);
    const detect::Detector<float> whole(network, description);
    auto& input = network.inputs.front();
    network.constants["axis of the batch"] = {{1}, nn::ElementType::integer, std::vector<double>{0}};
    network.nodes.insert(network.nodes.begin(),
                         {"", "Unsqueeze", {"picture", "axis of the batch"}, {input.name}, {}});
    input = {"picture", {3, input.shape[2], input.shape[3]}};
    const detect::Detector<float> of_one(network, description);
    const auto picture = picture_of(whole, folder);
    CHECK((detect::forward(of_one, picture) == detect::forward(whole, picture)));
    network.inputs.front().shape.pop_back();
    CHECK_THROWS_WITH(detect::Detector<float>(network, description),
                      test::contains("expected one input [1, 3, H, W] or [3, H, W]"));
  });
}

TEST_CASE("results of whole detectors behind their suppression are read as they are", "[detect][exports]") {
  const auto [name, file] =
      GENERATE(std::pair("faster_rcnn", "leg17.onnx"), std::pair("mask_rcnn", "leg13.onnx"),
               std::pair("retinanet", "leg17.onnx"), std::pair("ssd", "leg17.onnx"));
  CAPTURE(name);
  with_export(name, [&, file = file](const files::path& folder) {
    const auto network = io::read_onnx(folder / file);
    const detect::Detector<double> detector(network, final_description(network));
    const auto picture = picture_of(detector, folder);
    detect::Pass<double> pass;
    detector.forward(picture, pass);
    require_results(folder, detector.detections(pass.logits, 0, 0.001, 1), true);
    require_slope(detector, picture, 1e-5);
  });
}

TEST_CASE("values without an axis for the picture are refused by their extents if they do not fit",
          "[detect][exports]") {
  nn::NetworkDescription network;
  network.path = "net.onnx";
  network.opset = 17;
  network.inputs = {{"x", {1, 3, 4, 4}}};
  for (const auto& [name, extents] :
       {std::pair("of boxes", std::vector<double>{4, 12}), std::pair("of scores", std::vector<double>{8, 6})})
    network.constants[name] = {{2}, nn::ElementType::integer, extents};
  network.nodes = {{"", "Reshape", {"x", "of boxes"}, {"boxes"}, {}},
                   {"", "Reshape", {"x", "of scores"}, {"scores"}, {}}};
  network.outputs = {"boxes", "scores"};
  detect::DetectorDescription description;
  description.head = detect::HeadKind::boxes_and_scores;
  description.decoded.boxes = "boxes";
  description.decoded.scores = "scores";
  CHECK_THROWS_WITH(detect::Detector<float>(network, description),
                    test::contains("output 'boxes'; expected [1, candidates, 4], found [1, 4, 12]"));
}
