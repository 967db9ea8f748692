// Fine-tunes a detector against optimised car paint, and measures the gain.

#include "shell/hardening_run.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

int run(const CLI::App& app, const char* program, HardenOptions& options) {
  if (options.quick && !options.resume) adopt_quick(app, options);
  ProblemList problems;
  require_sound(options, problems);
  problems.throw_first();
  take_over_run(options, "harden");
  const StopSignal stop_signal;
  io::InputLedger ledger;
  ledger.leave_out(options.output);
  if (options.resume)
    adopt_run_settings(app, options, "harden", options.scene, options.detector, options.harden);
  if (options.detector.precision != "float")
    throw Error(ErrorKind::usage, "--precision " + options.detector.precision +
                                      " has no part in harden, whose weights learn in float");
  require_free_folder(options);
  Inputs inputs = load_inputs(options.scene, options.detector);
  require_trainable_heads("harden", inputs.detector, options.detector.weights);
  auto detector = learning_detector(inputs.detector, options.detector);
  require_one_scale(inputs.frames);
  const auto folder = claim_folder(options, "runs/harden", ledger);
  const std::string resume = resume_line(app, program, options, settings_json(options), {"quick"});
  return HardeningRun(std::move(options), std::move(inputs), std::move(detector), resume).execute();
}
}  // namespace

int main(int argc, char** argv) {
  HardenOptions options;
  auto app = command_line(
      "Fine-tunes a detector against optimised car paint (adversarial training), for robustness research, "
      "and measures it beside the undefended one: clean, under a paint made for the undefended one, and "
      "under a fresh attack on each. Takes Darknet networks and ONNX models with raw heads, and writes "
      "hardened.onnx.");
  describe(app, options);
  app.footer(
      "  harden --quick\n"
      "  harden --resume --output runs/harden-001");
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
