// Converts a Darknet detector, cfg and weights, to a single file that other tools can read: .safetensors or
// .onnx.
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/read_detector.hpp>

#include "shell/output_claim.hpp"
#include "shell/problem_list.hpp"
#include "shell/program.hpp"
#include "shell/run_folder.hpp"
#include "shell/settings.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  std::string cfg;
  std::string weights;
  std::string output;
  std::string decode;
  double epsilon = 1e-5;
  bool fold = false;
};

bool wants_onnx(const Options& options) { return options.output.ends_with(".onnx"); }

void describe(CLI::App& app, Options& options) {
  app.add_option("--cfg", options.cfg, "Darknet network description")->required();
  app.add_option("--weights", options.weights, "Darknet weights that belong to --cfg")->required();
  app.add_option("--output", options.output, "file to write, NAME.safetensors or NAME.onnx")->required();
  app.add_flag("--fold", options.fold,
               "multiply batch normalisation into the weights: the same boxes from a smaller .safetensors "
               "file, which can no longer be trained with it");
  app.add_option("--batch-norm-epsilon", options.epsilon,
                 "added to variances inside the root: 1e-5 in Darknet on GPUs, 1e-6 in OpenCV");
  app.add_option("--decode", options.decode,
                 "how logits become boxes: darknet, ultralytics or scaled; the output file states it from "
                 "now on. Left out, the cfg decides: scaled for new_coords=1, else darknet");
}

void require_sound(const Options& options) {
  ProblemList list;
  if (!options.decode.empty()) list.require_choice("--decode", options.decode, decode_choices());
  list.require(options.epsilon > 0 && options.epsilon < 1, "--batch-norm-epsilon must lie between 0 and 1");
  list.require_kept("--output", options.output, {options.cfg, options.weights});
  list.require(!wants_onnx(options) || (!options.fold && options.decode.empty()),
               "--fold and --decode are for .safetensors; an .onnx file holds the raw logits of the heads");
  list.throw_first();
}

/// Description of a model's heads, for io::read_detector_description(); nothing if a description cannot
/// express it.
std::optional<Json> described(const detect::DarknetModel<float>& model) {
  const auto& layers = model.config().layers;
  const auto is_region = [](const detect::LayerConfig& layer) {
    return layer.kind == detect::LayerKind::region;
  };
  if (std::ranges::any_of(layers, is_region)) return std::nullopt;
  std::map<std::size_t, std::vector<double>> anchors;  // of each stride, finest first
  for (const detect::Head& head : model.heads()) {
    const std::size_t stride = model.input_height() / head.grid_height;
    const bool is_plain = head.decode == detect::DecodeFamily::darknet && head.scale_x_y == 1 &&
                          !head.exclusive_classes && head.grid_height * stride == model.input_height() &&
                          head.grid_width * stride == model.input_width();
    if (!is_plain) return std::nullopt;
    for (const auto& [width, height] : head.anchors)
      anchors[stride].insert(anchors[stride].end(), {width, height});
  }
  Json description{{"head", "darknet"},
                   {"input", {{"fit", image::name_of(detect::fit_of(model.config()).kind)}}}};
  for (const auto& [stride, of_head] : anchors) {
    description["strides"].push_back(stride);
    description["anchors"].push_back(of_head);
  }
  return description;
}

/// Refuses to write a model beside a description that is not its own: readers would refuse the model, or obey
/// that description where the model has none.
/// \param own  text of the model's description; empty if it has none
void require_own_beside(const std::string& model, const std::string& own) {
  const std::string beside = io::description_beside(model);
  if (beside.empty()) return;
  const auto other = io::read_detector_description(beside);
  if (!own.empty() && other == io::parse_detector_description(own, model)) return;
  throw FileError(ErrorKind::mismatch, {beside, "", "would be read as the description of " + model,
                                        "the same one, or no such file", "another"});
}

/// Writes the network's operators, from a picture to the raw logits of each head, and among the model's
/// metadata a description of the outputs.
void write_onnx_model(const Options& options, const detect::DarknetModel<float>& model) {
  auto network = model.description();
  const auto description = described(model);
  if (description) network.metadata[io::description_key] = description->dump();
  require_own_beside(options.output, description ? description->dump() : "");
  std::map<std::string, nn::Shape> outputs;
  for (std::size_t h = 0; h < model.heads().size(); ++h) {
    const detect::Head& head = model.heads()[h];
    outputs[network.outputs.at(h)] = {1, head.channel_count(), head.grid_height, head.grid_width};
  }
  io::write_onnx(options.output, network, outputs);
  remark(options.output + ": " + std::to_string(network.nodes.size()) + " nodes, from \"picture\", [1, " +
         std::to_string(model.input_channels()) + ", " + std::to_string(model.input_height()) + ", " +
         std::to_string(model.input_width()) + "], RGB in [0, 1]");
  for (const auto& [name, shape] : outputs)
    remark("raw logits \"" + name + "\" of a " + std::to_string(shape[2]) + " x " + std::to_string(shape[3]) +
           " grid");
  remark(description
             ? "its metadata describe its heads"
             : "no description can state its heads: scale_x_y, classes by softmax, or another decode family");
}

int run(const Options& options) {
  require_sound(options);
  const auto claims = claimed_files({options.output});
  io::DetectorMetadata metadata;
  metadata.cfg = io::read_text_file(options.cfg, std::uint64_t(4) << 20U);
  metadata.is_folded = options.fold;
  metadata.batch_norm_epsilon = options.epsilon;
  auto config = io::parse_network_config(metadata.cfg, options.cfg);
  if (!options.decode.empty())
    config = detect::with_decode(std::move(config), detect::decode_family_by_name(options.decode));
  metadata.decode = detect::decode_family_of(config);
  print_warnings(config.warnings);
  print_warnings(detect::decode_warnings(config));
  const auto shapes = detect::infer_shapes(config, config.height, config.width);
  const auto weights =
      io::read_weight_file(options.weights, config, detect::parameter_layout(config, shapes));
  print_warnings(weights.warnings);
  if (wants_onnx(options)) {
    config.batch_norm_epsilon = options.epsilon;
    write_onnx_model(options, detect::DarknetModel<float>(config, weights.parameters));
    return 0;
  }
  metadata.images_seen = weights.images_seen;
  const std::size_t tensors =
      io::write_detector_file(options.output, metadata, weights.parameters, options.cfg);
  remark(options.output + ": " + std::to_string(tensors) + " tensors, batch normalisation " +
         (options.fold ? "folded" : "kept") + ", decode " + std::string(detect::name_of(metadata.decode)));
  remark("cfg sha256 " + io::sha256(metadata.cfg));
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line(
      "Puts a Darknet detector, cfg and weights, into one .safetensors file, which the other programs take "
      "as --weights without --cfg, or into an .onnx file for other tools.");
  describe(app, options);
  app.footer(
      "  convert_weights --cfg my.cfg --weights my.weights --output my.safetensors\n"
      "  convert_weights --cfg my.cfg --weights my.weights --output my.onnx");
  return run_program(app, argc, argv, [&] { return run(options); });
}
