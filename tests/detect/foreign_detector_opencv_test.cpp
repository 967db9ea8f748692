#include <tapestry/detect/detector.hpp>

#include <opencv2/dnn.hpp>

#include <string>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <utility>
#include <vector>

#include "../support/catch.hpp"
#include "../support/small_exports.hpp"
#include "../support/temporary_folder.hpp"

namespace detect = tapestry::detect;
namespace test = tapestry::test;
using Foreign = detect::Detector<float>;

namespace {
constexpr int size = 64;

/// A model that OpenCV runs, as an engine; docs/EMBEDDING.md shows the same.
detect::ForeignEngine opencv_engine(cv::dnn::Net net, std::vector<std::string> names) {
  return [net, names](const std::vector<float>& picture) mutable {
    const int extents[] = {1, 3, size, size};
    net.setInput(cv::Mat(4, extents, CV_32F, const_cast<float*>(picture.data())));
    std::vector<detect::ForeignOutput> outputs;
    for (const std::string& name : names) {
      const cv::Mat values = net.forward(name).clone();
      outputs.push_back({{values.size.p, values.size.p + values.dims},
                         {values.ptr<float>(), values.ptr<float>() + values.total()}});
    }
    return outputs;
  };
}

detect::DetectorDescription softmax_corners(const tapestry::nn::NetworkDescription& description) {
  detect::DetectorDescription kind{{}, {}, detect::HeadKind::boxes_and_scores};
  kind.decoded = {
      description.outputs[0],     description.outputs[1],   false, detect::BoxForm::corners_yx, true, false,
      detect::ScoreForm::softmax, detect::Background::first};
  return kind;
}
}  // namespace

TEST_CASE("a model that OpenCV runs gives the logits of our own graph", "[detect][foreign][opencv]") {
  const test::TemporaryFolder folder;
  const auto description = test::boxes_and_scores(size, 11);
  const auto kind = softmax_corners(description);
  tapestry::io::write_onnx(
      folder.path("net.onnx"), description,
      {{description.outputs[0], {1, 64, 4}}, {description.outputs[1], {1, 64, 1 + test::exported_classes}}});
  const Foreign foreign(opencv_engine(cv::dnn::readNetFromONNX(folder.path("net.onnx")), description.outputs),
                        kind, size, size);
  const detect::Detector<float> own(description, kind);
  REQUIRE(foreign.heads().size() == 1);
  CHECK(foreign.heads()[0].classes == test::exported_classes);
  const auto images = test::pictures<float>(2, size);
  detect::Pass<float> pass, own_pass;
  foreign.forward(images, pass);
  own.forward(images, own_pass);
  REQUIRE(pass.logits[0].shape() == own_pass.logits[0].shape());
  for (std::size_t i = 0; i < pass.logits[0].size(); ++i)
    CHECK(pass.logits[0].data()[i] == Approx(own_pass.logits[0].data()[i]).epsilon(1e-4).margin(1e-4));
}
