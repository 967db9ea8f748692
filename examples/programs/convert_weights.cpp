// Converts a Darknet detector, cfg and weights, to a single file that other tools can read, an ONNX model.
#include <tapestry/io/read_detector.hpp>

#include "shell/old_detector.hpp"
#include "shell/program.hpp"
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

/// Whether the weights are a file of the form that was written before 0.3.
bool is_old(const Options& options) { return options.weights.ends_with(".safetensors"); }

void describe(CLI::App& app, Options& options) {
  app.add_option("--cfg", options.cfg, "Darknet network description");
  app.add_option("--weights", options.weights,
                 "Darknet weights that belong to --cfg, or alone a .safetensors file, as releases before 0.3 "
                 "wrote them")
      ->required();
  app.add_option("--output", options.output, "file to write, NAME.onnx")->required();
  app.add_flag("--fold", options.fold,
               "multiply batch normalisation into the weights: the same boxes from a smaller file, which can "
               "no longer be trained with it");
  app.add_option("--batch-norm-epsilon", options.epsilon,
                 "added to variances inside the root: 1e-5 in Darknet on GPUs, 1e-6 in OpenCV");
  app.add_option(
      "--decode", options.decode,
      std::string(decode_help) +
          "; the output file states it from now on. Left out, the cfg decides: scaled for new_coords=1, else "
          "darknet");
}

void require_sound(const CLI::App& app, const Options& options) {
  ProblemList list;
  if (!options.decode.empty()) list.require_choice("--decode", options.decode, words_in(decode_help));
  list.require(options.epsilon > 0 && options.epsilon < 1, "--batch-norm-epsilon must lie between 0 and 1");
  list.require_kept("--output", options.output, {options.cfg, options.weights});
  list.require(options.output.ends_with(".onnx"), "--output " + options.output + " must end in .onnx");
  list.require(is_old(options) || !options.cfg.empty(),
               "--cfg is missing, which " + options.weights + " needs");
  for (const char* option : {"--cfg", "--decode", "--batch-norm-epsilon"})
    list.require(!is_old(options) || app.get_option(option)->count() == 0,
                 std::string(option) + " is for Darknet weights; " + options.weights + " states its own");
  list.throw_first();
}

ModelWithCfg read_source(const Options& options) {
  if (is_old(options)) return read_old_detector(options.weights);
  std::string cfg = io::read_text_file(options.cfg, std::uint64_t(4) << 20U);
  auto config = io::parse_network_config(cfg, options.cfg);
  if (!options.decode.empty())
    config = detect::with_decode(std::move(config), detect::decode_family_by_name(options.decode));
  config.batch_norm_epsilon = options.epsilon;
  print_warnings(config.warnings);
  print_warnings(detect::decode_warnings(config));
  const auto shapes = detect::infer_shapes(config, config.height, config.width);
  const auto weights =
      io::read_weight_file(options.weights, config, detect::parameter_layout(config, shapes));
  print_warnings(weights.warnings);
  detect::DarknetModel<float> model(std::move(config), weights.parameters);
  model.set_images_seen(weights.images_seen);
  return {std::move(model), std::move(cfg)};
}

detect::DarknetModel<float> folded(const detect::DarknetModel<float>& model) {
  detect::DarknetModel<float> result(
      detect::without_batch_norm(model.config()),
      detect::fold_batch_norm(model.config(), model.layout(), model.parameters()));
  result.set_images_seen(model.images_seen());
  return result;
}

int run(const CLI::App& app, const Options& options) {
  require_sound(app, options);
  const auto claims = claimed_files({options.output});
  auto [model, cfg] = read_source(options);
  if (options.fold) model = folded(model);
  if (const std::string beside = io::description_beside(options.output); !beside.empty())
    throw file_mismatch(
        {beside, "", "would be read as the description of " + options.output, "no such file"});
  const std::size_t nodes = io::write_detector_file(options.output, model, cfg);
  remark(options.output + ": " + std::to_string(nodes) + " nodes, from \"picture\", [1, " +
         std::to_string(model.input_channels()) + ", " + std::to_string(model.input_height()) + ", " +
         std::to_string(model.input_width()) + "], RGB in [0, 1]");
  for (const detect::Head& head : model.heads())
    remark("raw logits of a " + std::to_string(head.grid_height) + " x " + std::to_string(head.grid_width) +
           " grid");
  remark(std::string("batch normalisation ") + (options.fold ? "folded" : "kept") + ", decode " +
         std::string(detect::name_of(detect::decode_family_of(model.config()))));
  remark("cfg sha256 " + io::sha256(cfg));
  return 0;
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line(
      "Puts a Darknet detector, cfg and weights, into one .onnx file, which the other programs take as "
      "--weights without --cfg, and other tools as a network from a picture to raw logits.");
  describe(app, options);
  app.footer(
      "  convert_weights --cfg my.cfg --weights my.weights --output my.onnx\n"
      "  convert_weights --weights old.safetensors --output my.onnx");
  return run_program(app, argc, argv, [&] { return run(app, options); });
}
