#include <tapestry/detect/network.hpp>
#include <tapestry/image/planes.hpp>
#include <tapestry/io/darknet/cfg_file.hpp>
#include <tapestry/io/darknet/weight_file.hpp>

#include <opencv2/dnn.hpp>

#include <filesystem>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/random_detector.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

namespace detect = tapestry::detect;
namespace io = tapestry::io;
using namespace tapestry::test;

namespace {
/// OpenCV adds this to variances.
constexpr double opencv_epsilon = 1e-6;

detect::NetworkConfig opencv_config(const std::string& path) {
  auto config = io::read_network_config(path);
  config.batch_norm_epsilon = opencv_epsilon;
  return config;
}

/// Logits of OpenCV's DNN module for the same files and pictures, compared head by head.
void check_against_opencv(const detect::Network<float>& network, const std::string& cfg_path,
                          double tolerance) {
  const TemporaryFolder folder;
  const std::string weights_path = folder.path("random.weights");
  io::write_weight_file(weights_path, network);
  const auto images = random_array<float>({1, network.input_height(), network.input_width(), 3}, 7);
  detect::Pass<float> pass;
  network.forward(images, pass);

  auto net = cv::dnn::readNetFromDarknet(cfg_path, weights_path);
  net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  const int extents[4] = {1, 3, static_cast<int>(network.input_height()),
                          static_cast<int>(network.input_width())};
  auto planes = tapestry::image::planes_of(images);
  net.setInput(cv::Mat(4, extents, CV_32F, planes.data()));
  std::vector<cv::String> names;
  for (std::size_t i = 0; i < network.config().layers.size(); ++i)
    if (network.config().layers[i].kind == detect::LayerKind::yolo)
      names.push_back("conv_" + std::to_string(i - 1));
  std::vector<cv::Mat> outputs;
  net.forward(outputs, names);
  REQUIRE(outputs.size() == pass.logits.size());
  for (std::size_t h = 0; h < outputs.size(); ++h) {
    REQUIRE(outputs[h].total() == pass.logits[h].size());
    const double distance =
        relative_distance(pass.logits[h].data(), outputs[h].ptr<float>(), outputs[h].total());
    INFO("head " << h << ": relative L2 distance " << distance);
    CHECK(distance <= tolerance);
  }
}

void check_cfg_text(const std::string& cfg, double tolerance) {
  const TemporaryFolder folder;
  const std::string path = folder.write("some.cfg", cfg);
  check_against_opencv(random_detector<float>(opencv_config(path), 3), path, tolerance);
}
}  // namespace

TEST_CASE("logits equal those of OpenCV for every common layer", "[detect][opencv]") {
  check_cfg_text(common_layers, 5e-6);
}

TEST_CASE("logits equal those of OpenCV for the layers of small relatives", "[detect][opencv]") {
  check_cfg_text(relatives_layers, 5e-6);
}

TEST_CASE("shortcuts of unequal channels add what OpenCV adds", "[detect][opencv]") {
  check_cfg_text(unequal_layers, 5e-6);
}

TEST_CASE("layers that multiply others equal those of OpenCV", "[detect][opencv]") {
  std::string cfg = product_layers;
  const auto per_pixel = cfg.find("# A factor for each pixel");  // which OpenCV does not know
  cfg.erase(per_pixel, cfg.find("# The head") - per_pixel);
  check_cfg_text(cfg, 5e-6);
}

TEST_CASE("logits of yolov3-tiny equal those of OpenCV", "[detect][opencv]") {
  const std::string path = "/usr/share/darknet/cfg/yolov3-tiny.cfg";
  if (!std::filesystem::exists(path)) {
    WARN("skipped: no " << path);
    return;
  }
  check_against_opencv(random_detector<float>(opencv_config(path), 3), path, 5e-6);
}
