// Fine-tunes a detector against optimised car paint, and measures what that bought.
#include <iostream>
#include <string>
#include <tapestry/core/parallel.hpp>
#include <utility>

#include "shell/harden_options.hpp"
#include "shell/hardening_run.hpp"
#include "shell/inputs.hpp"
#include "shell/program.hpp"
#include "shell/run_folder.hpp"
#include "shell/stop_signal.hpp"
#include "shell/trained_network.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

/// The weights of these networks can learn by loss::yolo_training().
void require_trainable(const HardenOptions& options) {
  if (options.detector.precision != "float")
    throw Error(ErrorKind::usage, "--precision " + options.detector.precision +
                                      " has no part in harden, whose weights learn in float");
  if (is_onnx(options.detector.weights))
    throw Error(ErrorKind::usage, options.detector.weights +
                                      " is an .onnx model, whose weights are not fine-tuned here; give "
                                      "Darknet --weights or a detector that convert_weights made");
}

void require_trainable_heads(const Inputs& inputs, const HardenOptions& options) {
  const auto& heads = inputs.detector.network->heads();
  loss::require_raw_logits("harden", heads);
  for (const auto& head : heads)
    if (!detect::has_anchors(head.decode))
      throw FileError(ErrorKind::mismatch, {options.detector.weights, "", "a head that cannot be trained",
                                            "heads with anchors", std::string(detect::name_of(head.decode))});
}

int run(const CLI::App& app, const char* program, HardenOptions& options) {
  if (options.quick && !options.resume) adopt_quick(app, options);
  ProblemList problems;
  require_sound(options, problems);
  problems.throw_first();
  if (options.threads > 0) limit_threads(options.threads);
  const StopSignal stop_signal;
  if (options.resume)
    adopt_run_settings(app, options, "harden", options.scene, options.detector, options.harden);
  require_trainable(options);
  require_free_folder(options);
  Inputs inputs = load_inputs(options.scene, options.detector);
  std::string cfg = trainable_cfg(options.detector.cfg, options.detector.weights);
  require_trainable_heads(inputs, options);
  require_one_scale(inputs.frames);
  const bool is_new = options.output.empty() || !is_there(options.output, ErrorKind::write);
  if (options.output.empty()) options.output = make_next_folder("runs/harden");
  const RunFolder folder(options.output, is_new);
  require_free_folder(options);  // another process may have begun and ended a run there meanwhile
  const std::string resume = resume_line(app, program, options, settings_json(options), {"quick"});
  return HardeningRun(std::move(options), std::move(inputs), std::move(cfg), resume).execute();
}
}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  HardenOptions options;
  auto app = command_line(
      "Fine-tunes a detector against optimised car paint (adversarial training), for robustness research, "
      "and measures it beside the undefended one: clean, under a paint made for the undefended one, and "
      "under a fresh attack on each.");
  describe(app, options);
  app.footer(
      "  harden --quick\n"
      "  harden --resume --output runs/harden-001");
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
