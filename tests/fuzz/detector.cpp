// Darknet's network descriptions and weights, and detectors of earlier releases.
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/exported_names.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/text_lists.hpp>

#include "../support/old_detector.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;

const std::string small_cfg =
    "[net]\nwidth=32\nheight=32\nchannels=3\n"
    "[convolutional]\nbatch_normalize=1\nfilters=2\nsize=3\nstride=2\npad=1\nactivation=leaky\n"
    "[maxpool]\nsize=2\nstride=2\n"
    "[convolutional]\nfilters=12\nsize=1\nstride=1\npad=1\nactivation=linear\n"
    "[yolo]\nmask=0,1\nanchors=4,4, 8,8\nclasses=1\nnum=2\n";
const std::string branched_cfg =
    "[net]\nwidth=32\nheight=32\nchannels=3\nletter_box=1\n"
    "[convolutional]\nfilters=4\nsize=3\nstride=2\ngroups=1\npad=1\nactivation=mish\n"
    "[route]\nlayers=-1\ngroups=2\ngroup_id=1\n[upsample]\nstride=2\n"
    "[convolutional]\nfilters=4\nsize=1\nactivation=swish\n[shortcut]\nfrom=-1\nactivation=linear\n"
    "[reorg]\nstride=2\n[dropout]\nprobability=.5\n[avgpool]\n[softmax]\n";

void read_cfg(const std::string& bytes) {
  const auto config = io::parse_network_config(bytes, "a.cfg");
  (void)detect::decode_warnings(config);
  (void)detect::parameter_layout(config, detect::infer_shapes(config, config.height, config.width));
}

void read_classifier(const std::string& bytes) {
  const auto config = io::parse_classifier_config(bytes, "a.cfg");
  (void)detect::parameter_layout(config, detect::infer_shapes(config, config.height, config.width));
}

struct SmallDetector {
  detect::NetworkConfig config = io::parse_network_config(small_cfg, "a.cfg");
  detect::ParameterLayout layout =
      detect::parameter_layout(config, detect::infer_shapes(config, config.height, config.width));
  Array<float, 1> parameters = Array<float, 1>(Extents<1>{layout.count});
  SmallDetector() { std::fill(parameters.begin(), parameters.end(), 0.5F); }
};

void read_weights(const std::string& bytes) {
  static const SmallDetector detector;
  (void)io::read_weight_file(fuzz::folder().write("a.weights", bytes), detector.config, detector.layout);
}

std::vector<std::string> weight_seeds() {
  io::write_weight_file(fuzz::folder().path("seed.weights"), 5, SmallDetector().parameters);
  return {fuzz::folder().read("seed.weights")};
}

void read_old_detector(const std::string& bytes) {
  (void)shell::read_old_detector(fuzz::folder().write("a.safetensors", bytes));
}

std::vector<std::string> old_detector_seeds() {
  return {test::old_detector(detect::DarknetModel<float>(SmallDetector().config), small_cfg)};
}

void read_detector(const std::string& bytes) {
  (void)io::darknet_model<float>(io::parse_onnx(bytes, "a.onnx"));
}

std::vector<std::string> detector_seeds() {
  const std::string path = fuzz::folder().path("seed.onnx");
  (void)io::write_detector_file(path, detect::DarknetModel<float>(SmallDetector().config), small_cfg);
  return {fuzz::folder().read("seed.onnx")};
}

/// The length of the header: all of it up to the last brace.
std::string with_header_length(std::string file) {
  const auto end = file.rfind('}');
  if (file.size() < 8 || end == std::string::npos || end < 8) return file;
  for (std::size_t i = 0; i < 8; ++i) file[i] = static_cast<char>((end - 7) >> (8 * i) & 0xFFU);
  return file;
}

void read_names(const std::string& bytes) {
  (void)io::read_class_names(fuzz::folder().write("a.names", bytes), 3);
}

void read_exported_names(const std::string& bytes) { (void)io::parse_exported_names(bytes, 4); }

const fuzz::Registered cfg({"cfg", read_cfg, [] { return std::vector{small_cfg}; }});
const fuzz::Registered classifier({"classifier_cfg", read_classifier,
                                   [] { return std::vector{branched_cfg}; }});
const fuzz::Registered weights({"weights", read_weights, weight_seeds});
const fuzz::Registered old_detector({"old_detector", read_old_detector, old_detector_seeds,
                                     with_header_length});
const fuzz::Registered detector({"detector", read_detector, detector_seeds});
const fuzz::Registered names({"names", read_names,
                              [] { return std::vector<std::string>{"car\nvan\na b\n"}; }});
const fuzz::Registered exported_names(
    {"exported_names", read_exported_names, [] {
       return std::vector<std::string>{"{0: 'a\\u0142', 2: \"b's\"}", "['car', 'c\\\\d']"};
     }});
}  // namespace
