#pragma GCC diagnostic ignored "-Wshadow"  // darknet.h has global names such as image and layer

#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/image/batch.hpp>

#include "../support/differential.hpp"
#include "../support/random_array.hpp"
#include "../support/random_cfg.hpp"
#include "../support/random_model.hpp"
#include "../support/relative_distance.hpp"
#include "../support/temporary_folder.hpp"

extern "C" {
#include <darknet.h>
}

namespace detect = tapestry::detect;
namespace io = tapestry::io;
using namespace tapestry::test;

namespace {
/// Every box and probability that Darknet makes of a [region]'s input, compared with detect::decode() of the
/// same logits: σ, e^t and softmax in float.
void check_region_boxes(const detect::DarknetModel<float>& network, const float* raw, ::network* darknet) {
  const detect::Head& head = network.heads()[0];
  tapestry::Array<float, 4> logits({1, head.channel_count(), head.grid_height, head.grid_width});
  std::copy_n(raw, logits.size(), logits.data());
  const auto decoded = detect::decode<float>(head, logits, network.input_height(), network.input_width());
  const auto width = static_cast<double>(network.input_width()),
             height = static_cast<double>(network.input_height());
  const std::size_t count = head.candidate_count(), classes = head.classes;
  int found = 0;
  detection* const detections = get_network_boxes(darknet, darknet->w, darknet->h, 0, 0, nullptr, 1, &found);
  REQUIRE(static_cast<std::size_t>(found) == count);
  std::vector<float> ours, theirs, our_scores, their_scores;
  const auto scores = detect::confidences(decoded);
  for (std::size_t i = 0; i < count; ++i) {
    const ::box& box = detections[i].bbox;
    for (std::size_t k = 0; k < 4; ++k)
      ours.push_back(static_cast<float>(static_cast<double>(decoded.boxes.value()(0, i, k)) /
                                        (k % 2 == 0 ? width : height)));
    theirs.insert(theirs.end(), {box.x, box.y, box.w, box.h});
    for (std::size_t k = 0; k < classes; ++k) our_scores.push_back(scores.value()(0, i, k));
    their_scores.insert(their_scores.end(), detections[i].prob, detections[i].prob + classes);
  }
  free_detections(detections, found);
  const double box_distance = relative_distance(ours.data(), theirs.data(), ours.size());
  const double score_distance = relative_distance(our_scores.data(), their_scores.data(), our_scores.size());
  INFO("boxes " << box_distance << ", scores " << score_distance);
  CHECK(box_distance <= 1e-6);
  CHECK(score_distance <= 1e-6);
}

/// Raw inputs of Darknet's heads for the same files and pictures, compared head by head.
///
/// Darknet on a CPU divides by √variance + 1e-6 where Tapestry takes √(variance + 1e-5); with variances of
/// at least ½ the factor differs by at most 1e-5, so the written variances are moved to make up for it.
void check_against_darknet(const detect::DarknetModel<float>& network, const std::string& cfg_path,
                           double tolerance) {
  const TemporaryFolder folder;
  const std::string weights_path = folder.path("random.weights");
  auto moved = network;
  for (const auto& block : network.layout().blocks) {
    if (block.role != detect::ParameterRole::variance) continue;
    for (std::size_t i = 0; i < block.count; ++i) {
      const double variance = static_cast<double>(network.parameters()[block.offset + i]);
      const double root = std::sqrt(variance + network.config().batch_norm_epsilon) - 1e-6;
      moved.parameters()[block.offset + i] = static_cast<float>(root * root);
    }
  }
  io::write_weight_file(weights_path, moved);
  const auto images = random_array<float>({1, network.input_height(), network.input_width(), 3}, 7);
  const auto logits = detect::forward(network.detector(), images);

  std::string cfg_name = cfg_path, weights_name = weights_path;
  ::network* darknet = load_network(cfg_name.data(), weights_name.data(), 0);
  set_batch_network(darknet, 1);
  auto planes = tapestry::image::planes_of(images);
  network_predict(darknet, planes.data());
  std::size_t head = 0;
  for (int i = 0; i < darknet->n; ++i) {
    if (darknet->layers[i].type != YOLO && darknet->layers[i].type != REGION) continue;
    const ::layer& before = darknet->layers[i - 1];  // a linear convolution, whose output are the logits
    REQUIRE(static_cast<std::size_t>(before.outputs) == logits[head].size());
    const double distance = relative_distance(logits[head].data(), before.output, logits[head].size());
    INFO("head " << head << ": relative L2 distance " << distance);
    CHECK(distance <= tolerance);
    if (darknet->layers[i].type == REGION) check_region_boxes(network, before.output, darknet);
    ++head;
  }
  if (head == 0) {  // a classifier
    const double distance = relative_distance(logits[0].data(), darknet->output, logits[0].size());
    INFO("outputs: relative L2 distance " << distance);
    CHECK(distance <= tolerance);
    ++head;
  }
  CHECK(head == logits.size());
  free_network(darknet);
}

void check_cfg_text(const std::string& cfg) {
  const TemporaryFolder folder;
  const std::string path = folder.write("some.cfg", cfg);
  check_against_darknet(random_model<float>(io::read_network_config(path), 3), path, 5e-6);
}

/// Whether Debian's Darknet computes a network: it lacks later layers, options and activations, and loses the
/// extents behind a softmax. Boxes are compared of a single [region] only.
bool is_known_to_darknet(const detect::NetworkConfig& config) {
  using enum detect::LayerKind;
  using enum tapestry::nn::Activation;
  std::size_t heads = 0, regions = 0;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const detect::LayerConfig& layer = config.layers[i];
    heads += is_head(layer.kind) ? 1U : 0U;
    regions += layer.kind == region ? 1U : 0U;
    const auto is_one_of = [&](auto found, auto... known) { return ((found == known) || ...); };
    if (is_one_of(layer.kind, dropout, reorg3d, scale_channels, sam)) return false;
    if (is_one_of(layer.activation, swish, mish, hard_mish, relu6)) return false;
    if (layer.kind == softmax && i + 1 < config.layers.size()) return false;
    if (layer.kind == route && layer.groups > 1) return false;
    if (layer.kind == shortcut && layer.sources.size() > 1) return false;
    if (layer.dilation > 1) return false;
    // Darknet reads the pixels of these one after another, and ignores stride and padding.
    const bool has_steps = layer.stride > 1 || layer.padding > 0;
    if (layer.kind == convolutional && layer.size == 1 && has_steps) return false;
  }
  return regions == 0 || heads == 1;
}
}  // namespace

TEST_CASE("logits of random networks equal those of Darknet", "[detect][darknet][differential]") {
  DifferentialRun run("random networks against Darknet", 4);
  while (run.next()) {
    const auto cfg = random_cfg_where(is_known_to_darknet, run.seed());
    INFO(run.repeat() << "\n" << cfg.text());
    const TemporaryFolder folder;
    // Rounding of at most a dozen layers; some cancels. A wrong layer differs by O(1).
    check_against_darknet(random_model<float>(cfg.config(), run.seed()), folder.write("some.cfg", cfg.text()),
                          1e-4);
  }
}

TEST_CASE("logits equal those of Darknet for every common layer", "[detect][darknet]") {
  check_cfg_text(common_layers);
}

TEST_CASE("less common activations equal those of Darknet", "[detect][darknet]") {
  const std::string name =
      GENERATE(std::string("elu"), std::string("tanh"), std::string("relu"), std::string("logistic"));
  std::string cfg = common_layers;
  for (auto at = cfg.find("leaky"); at != std::string::npos; at = cfg.find("leaky")) cfg.replace(at, 5, name);
  CAPTURE(name);
  check_cfg_text(cfg);
}

TEST_CASE("unequal shortcuts and scaled upsampling equal those of Darknet", "[detect][darknet]") {
  std::string cfg = unequal_layers;
  cfg.insert(cfg.find("[upsample]") + 11, "scale=-.75\n");  // which OpenCV passes over
  check_cfg_text(cfg);
}

TEST_CASE("shortcuts over a stride equal those of Darknet", "[detect][darknet]") {
  std::string cfg = tapestry::test::cfg_text("strided_shortcuts");
  cfg.replace(cfg.find("width=16"), 8, "width=48");
  check_cfg_text(cfg);
}

TEST_CASE("reorg and region equal those of Darknet, box by box", "[detect][darknet]") {
  std::string cfg = region_layers;
  if (GENERATE(true, false)) cfg.replace(cfg.find("softmax=1"), 9, "softmax=0");
  cfg.replace(cfg.find("width=16"), 8, "width=80");  // not square
  cfg.replace(cfg.find("height=16"), 9, "height=48");
  check_cfg_text(cfg);
}

TEST_CASE("a classifier's probabilities equal those of Darknet", "[detect][darknet]") {
  const TemporaryFolder folder;
  std::string cfg = classifier_layers;
  cfg.erase(cfg.find("[dropout]"));
  const std::string path = folder.write("some.cfg", cfg);
  check_against_darknet(random_model<float>(io::read_classifier_config(path), 3), path, 5e-6);
}

TEST_CASE("logits of Debian's classifiers equal those of Darknet", "[detect][darknet]") {
  const std::string path =
      std::string("/usr/share/darknet/cfg/") +
      GENERATE("darknet19", "darknet53", "densenet201", "extraction", "cifar", "resnet18", "resnext50") +
      ".cfg";
  if (is_absent(path)) return;
  std::string cfg = io::read_text_file(path);
  cfg.erase(cfg.find("[softmax]"));  // behind a softmax random logits leave one class
  const TemporaryFolder folder;
  const std::string cut = folder.write("cut.cfg", cfg);
  check_against_darknet(random_model<float>(io::read_classifier_config(cut), 3), cut, 5e-6);
}

TEST_CASE("logits of Debian's cfg files equal those of Darknet", "[detect][darknet]") {
  const std::string path = std::string("/usr/share/darknet/cfg/") +
                           GENERATE("yolov3-tiny", "yolov2-tiny", "yolov2-tiny-voc", "yolov2", "yolov2-voc") +
                           ".cfg";
  if (is_absent(path)) return;
  check_against_darknet(random_model<float>(io::read_network_config(path), 3), path, 5e-6);
}
