#include <tapestry/image/batch.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

#include <opencv2/dnn.hpp>

#include "../support/differential.hpp"
#include "../support/random_array.hpp"
#include "../support/random_cfg.hpp"
#include "../support/random_model.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
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
void check_against_opencv(const detect::DarknetModel<float>& network, const std::string& cfg_path,
                          double tolerance) {
  const TemporaryFolder folder;
  const std::string weights_path = folder.path("random.weights");
  io::write_weight_file(weights_path, network);
  const auto images = random_array<float>({1, network.input_height(), network.input_width(), 3}, 7);
  const auto logits = detect::forward(network.detector(), images);

  auto net = cv::dnn::readNetFromDarknet(cfg_path, weights_path);
  net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  const int extents[4] = {1, 3, static_cast<int>(network.input_height()),
                          static_cast<int>(network.input_width())};
  auto planes = image::planes_of(images);
  net.setInput(cv::Mat(4, extents, CV_32F, planes.data()));
  std::vector<cv::String> names;
  for (std::size_t i = 0; i < network.config().layers.size(); ++i)
    if (is_head(network.config().layers[i].kind)) names.push_back("conv_" + std::to_string(i - 1));
  std::vector<cv::Mat> outputs;
  net.forward(outputs, names);
  REQUIRE(outputs.size() == logits.size());
  for (std::size_t h = 0; h < outputs.size(); ++h) {
    REQUIRE(outputs[h].total() == logits[h].size());
    const double distance = relative_distance(logits[h].data(), outputs[h].ptr<float>(), outputs[h].total());
    INFO("head " << h << ": relative L2 distance " << distance);
    CHECK(distance <= tolerance);
  }
}

void check_cfg_text(const std::string& cfg, double tolerance) {
  const TemporaryFolder folder;
  const std::string path = folder.write("some.cfg", cfg);
  check_against_opencv(random_model<float>(opencv_config(path), 3), path, tolerance);
}

/// Whether OpenCV computes a detector as Darknet does: the layers, options and activations that it knows. A
/// head's input has in OpenCV the name that it has without an activation.
bool is_known_to_opencv(const detect::NetworkConfig& config) {
  using enum detect::LayerKind;
  using enum nn::Activation;
  const auto is_one_of = [](auto found, auto... known) { return ((found == known) || ...); };
  const auto shapes = detect::infer_shapes(config, config.height, config.width);
  bool has_head = false;
  if (config.layers.front().kind != convolutional) return false;  // OpenCV looks for a layer before others
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const detect::LayerConfig& layer = config.layers[i];
    has_head = has_head || is_head(layer.kind);
    if (is_head(layer.kind) && config.layers[i - 1].activation != linear) return false;
    if (is_one_of(layer.kind, reorg3d, softmax, region)) return false;
    if (!is_one_of(layer.activation, linear, leaky, relu, logistic, swish, mish)) return false;
    if (layer.kind == shortcut && layer.sources.size() > 1) return false;
    if (layer.kind == shortcut && (shapes[layer.sources.front()].height != shapes[i].height ||
                                   shapes[layer.sources.front()].width != shapes[i].width))
      return false;
    if (layer.kind == route && layer.groups > 1 && layer.sources.size() > 1) return false;
    if (layer.scale_wh || layer.dilation > 1) return false;
    if (layer.kind == upsample && layer.scale != 1) return false;
  }
  return has_head;
}
}  // namespace

TEST_CASE("logits of random networks equal those of OpenCV", "[detect][opencv][differential]") {
  DifferentialRun run("random networks against OpenCV", 4);
  while (run.next()) {
    const auto cfg = random_cfg_where(is_known_to_opencv, run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const TemporaryFolder folder;
    auto config = cfg.config();
    config.batch_norm_epsilon = opencv_epsilon;
    // Rounding of at most a dozen layers; some cancels. A wrong layer differs by O(1).
    check_against_opencv(random_model<float>(config, run.seed()), folder.write("some.cfg", cfg.text()), 1e-4);
  }
}

TEST_CASE("random Darknet networks written as ONNX models have their logits in OpenCV",
          "[detect][opencv][onnx][differential]") {
  DifferentialRun run("Darknet networks as ONNX models in OpenCV", 4);
  std::size_t compared = 0, refused = 0;  // OpenCV 4.6 has no product of two maps of one value
  while (run.next()) {
    const auto cfg = random_cfg_where(is_known_to_opencv, run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const auto network = random_model<float>(cfg.config(), run.seed());
    const auto images = random_array<float>({1, network.input_height(), network.input_width(), 3}, 7);
    const auto logits = detect::forward(network.detector(), images);
    const TemporaryFolder folder;
    const auto description = detect::network_description(network.config(), network.parameters());
    std::map<std::string, nn::Shape> shapes;
    for (std::size_t h = 0; h < logits.size(); ++h)
      shapes[description.outputs[h]] = {logits[h].shape().begin(), logits[h].shape().end()};
    io::write_onnx(folder.path("some.onnx"), description, shapes);
    cv::dnn::Net net;
    try {
      net = cv::dnn::readNetFromONNX(folder.path("some.onnx"));
    } catch (const cv::Exception& error) {
      INFO(error.what());
      REQUIRE(std::string(error.what()).find("Mul@ai.onnx") != std::string::npos);
      ++refused;
      continue;
    }
    ++compared;
    const int extents[4] = {1, 3, static_cast<int>(network.input_height()),
                            static_cast<int>(network.input_width())};
    auto planes = image::planes_of(images);
    net.setInput(cv::Mat(4, extents, CV_32F, planes.data()));
    std::vector<cv::Mat> outputs;
    net.forward(outputs, std::vector<cv::String>(description.outputs.begin(), description.outputs.end()));
    REQUIRE(outputs.size() == logits.size());
    for (std::size_t h = 0; h < outputs.size(); ++h) {
      REQUIRE(outputs[h].total() == logits[h].size());
      CHECK(relative_distance(logits[h].data(), outputs[h].ptr<float>(), outputs[h].total()) <= 1e-4);
    }
  }
  CHECK(refused <= compared / 20);
}

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
  if (is_absent(path)) return;
  check_against_opencv(random_model<float>(opencv_config(path), 3), path, 5e-6);
}
