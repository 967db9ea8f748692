// A detector that torchvision exported whole, with its own resizing and suppression: its candidates are
// values before the suppression.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <tapestry/detect/detector.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <vector>

#include "../support/catch.hpp"
#include "../support/paths.hpp"
#include "../support/raw_numbers.hpp"

namespace detect = tapestry::detect;
namespace files = std::filesystem;
namespace io = tapestry::io;
using namespace tapestry;

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

/// The picture that the framework was given.
template <class T>
Array<T, 4> picture_of(const detect::Detector<T>& detector, const files::path& folder) {
  const std::size_t height = detector.input_height(), width = detector.input_width();
  const auto planes = tapestry::test::raw_numbers<float>(folder / "in.bin");
  Array<T, 4> picture(Extents<4>{1, height, width, 3});
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = 0; i < height * width; ++i)
      picture.data()[3 * i + c] = static_cast<T>(planes[c * height * width + i]);
  return picture;
}
}  // namespace

TEST_CASE("candidates of a whole SSD, before its suppression, give the framework's boxes and scores",
          "[detect][exports]") {
  const files::path folder = test::in_shared("data/exports/ssd");
  if (!files::exists(folder)) {
    WARN("skipped: no exports in TAPESTRY_SHARED");
    return;
  }
  const detect::Detector<float> detector(io::read_onnx(folder / "leg17.onnx"), ssd_description());
  detect::Pass<float> pass;
  detector.forward(picture_of(detector, folder), pass);
  const auto candidates = detector.detections(pass.logits, 0, 0.01, 1);
  const auto boxes = tapestry::test::raw_numbers<double>(folder / "out.0.bin"),
             scores = tapestry::test::raw_numbers<double>(folder / "out.1.bin");
  REQUIRE(!scores.empty());
  for (std::size_t i = 0; i < scores.size(); ++i) {
    CAPTURE(i, scores[i]);
    const auto is_same = [&](const detect::Detection& found) {
      const auto& box = found.box;
      return std::abs(found.confidence - scores[i]) <= 1e-5 &&
             std::abs(box.cx - (boxes[4 * i] + boxes[4 * i + 2]) / 2) <= 1e-3 &&
             std::abs(box.cy - (boxes[4 * i + 1] + boxes[4 * i + 3]) / 2) <= 1e-3 &&
             std::abs(box.w - (boxes[4 * i + 2] - boxes[4 * i])) <= 1e-3 &&
             std::abs(box.h - (boxes[4 * i + 3] - boxes[4 * i + 1])) <= 1e-3;
    };
    CHECK(std::ranges::any_of(candidates, is_same));
  }
}

TEST_CASE("the gradient of a whole SSD's logits by the picture equals differences", "[detect][exports]") {
  const files::path folder = test::in_shared("data/exports/ssd");
  if (!files::exists(folder)) {
    WARN("skipped: no exports in TAPESTRY_SHARED");
    return;
  }
  const detect::Detector<double> detector(io::read_onnx(folder / "leg17.onnx"), ssd_description());
  const Array<double, 4> picture = picture_of(detector, folder);
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
  CHECK((at(h) - at(-h)) / (2 * h) == Approx(length).epsilon(1e-6));
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
  CHECK_THROWS_WITH(
      detect::Detector<float>(network, description),
      test::contains("output 'boxes of one picture'; expected [1, candidates, 4], found [1, 4, 12]"));
}
