// The main job: optimises a camouflage for a car against a detector, and measures what it does.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <optional>
#include <string>
#include <tapestry/camouflage/checkpoint.hpp>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/obj_writer.hpp>
#include <vector>

#include "support/inputs.hpp"
#include "support/measurement.hpp"
#include "support/program.hpp"
#include "support/progress.hpp"
#include "support/report.hpp"
#include "support/run_folder.hpp"
#include "support/settings.hpp"
#include "support/stop_signal.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::examples;
using Clock = std::chrono::steady_clock;

struct Options {
  SceneSettings scene;
  DetectorSettings detector;
  OptimisationSettings optimisation;
  std::string output;
  int threads = 0;
  std::size_t checkpoint_steps = 50;
  std::size_t keep_mib = 4096;
  bool resume = false;
  bool check = false;
  bool profile = false;
};

void describe(CLI::App& app, Options& options) {
  add_options(app, options.scene);
  add_options(app, options.detector);
  add_options(app, options.optimisation);
  app.add_option("--output", options.output, "run folder; runs/camouflage-001, -002, ... when left out");
  app.add_option("--threads", options.threads, "threads; 0: all cores. Results do not depend on it")
      ->capture_default_str();
  app.add_option("--checkpoint-steps", options.checkpoint_steps, "steps between checkpoints")
      ->capture_default_str();
  app.add_option("--keep-mib", options.keep_mib,
                 "memory for prepared views, MiB; those beyond are prepared anew")
      ->capture_default_str();
  app.add_flag("--resume", options.resume,
               "go on with the run in --output; settings not given are taken from it");
  app.add_flag("--check", options.check, "only check every input, report all problems, and leave");
  app.add_flag("--profile", options.profile, "print where the time of a step went");
}

Json settings_json(const Options& options) {
  Json json = Json::object();
  add_json(json, options.scene);
  add_json(json, options.detector);
  add_json(json, options.optimisation);
  return json;
}

/// Of a run to resume, the settings come from its manifest and are checked there.
void require_sound(const Options& options, ProblemList& list) {
  require_sound_thread_count(options.threads, list);
  list.require(options.checkpoint_steps > 0, "--checkpoint-steps must be at least 1");
  list.require(options.keep_mib <= std::size_t(1) << 24U, "--keep-mib must be at most 16777216");
  if (options.resume) return;
  require_sound(options.scene, list);
  require_sound(options.detector, list);
  require_sound(options.optimisation, list);
}

camouflage::ObjectiveOptions objective_options(const Options& options, std::size_t class_index) {
  const auto& o = options.optimisation;
  camouflage::ObjectiveOptions objective;
  objective.kind = loss::adversarial_loss_by_name(o.loss);
  objective.weights.iou = o.iou;
  objective.weights.objectness = o.objectness;
  objective.weights.classification = o.classification;
  objective.weights.max_score = o.max_score;
  objective.smoothness = o.smoothness;
  objective.smooth_texture = o.smooth_over == "texture";
  objective.class_index = class_index;
  return objective;
}

/// Drawn scenes are many and quick; frames may be few, or too many for more than the paper's five passes.
std::size_t default_epochs(std::size_t views, bool drawn) {
  return drawn ? 20 : std::max<std::size_t>(5, block_count(2400, views));
}

Array<float, 2> start_texture(const Options& options, const camouflage::PaintedMesh& car) {
  const std::size_t count = car.layout.texel_count(car.mesh);
  if (options.optimisation.start == "zero") return zeros<float, 2>({count, 3});
  if (options.optimisation.start == "own")
    return camouflage::parameter_of_colours(camouflage::own_colours<float>(car));
  Random random = Random(options.optimisation.seed).fork(0x7374617274ULL);
  return camouflage::parameter_of_colours(camouflage::random_colours<float>(count, random));
}

std::string history_csv(const std::vector<camouflage::ObjectiveTerms>& history) {
  std::string text = "step,iou,objectness,classification,max_score,smoothness,total\n";
  char line[256];
  for (std::size_t i = 0; i < history.size(); ++i) {
    const auto& t = history[i];
    std::snprintf(line, sizeof line, "%zu,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", i + 1, t.iou, t.objectness,
                  t.classification, t.max_score, t.smoothness, t.total);
    text += line;
  }
  return text;
}

/// One run in its folder.
class Run {
 public:
  Run(Options options, Inputs inputs, std::string resume_command)
      : options_(std::move(options)),
        inputs_(std::move(inputs)),
        resume_command_(std::move(resume_command)),
        train_(inputs_.car.painted, store_settings(), train_loaders(inputs_.frames, options_.scene.mask)),
        test_(inputs_.car.painted, store_settings(),
              frame_loaders(inputs_.frames.test, options_.scene.mask, inputs_.frames.posed)),
        objective_(inputs_.detector.network, inputs_.car.painted.layout,
                   objective_options(options_, inputs_.class_index)) {}

  /// \returns the exit code
  int execute() {
    try {
      run();
      return 0;
    } catch (const Stopped&) {
      const bool has_begun = std::filesystem::exists(path("manifest.json"));
      std::cerr << '\n' << (has_begun ? "stopped" : "stopped before the first step; nothing was written");
      if (saved_steps_ > 0) std::cerr << "; saved after step " << saved_steps_;
      if (has_begun) std::cerr << ". Resume with\n  " << resume_command_;
      std::cerr << '\n';
      return StopSignal::exit_code();
    }
  }

 private:
  void run() {
    const auto start = Clock::now();
    for (const auto& warning : inputs_.warnings) std::cerr << "warning: " << warning << '\n';
    inputs_.warnings.clear();
    const auto usable_train = usable_views(train_, inputs_.warnings);
    auto& test = test_store();
    const auto usable_test = inputs_.frames.held_out ? usable_views(test, inputs_.warnings) : usable_train;
    for (const auto& warning : inputs_.warnings) std::cerr << "warning: " << warning << '\n';
    if (usable_train.empty() || usable_test.empty())
      throw Error(ErrorKind::mismatch, options_.scene.frames + ": no frame shows the car");
    auto& epochs = options_.optimisation.epochs;
    if (epochs == 0) epochs = default_epochs(usable_train.size(), inputs_.frames.drawn > 0);
    open_folder();

    camouflage::TrainingOptions training_options;
    training_options.epochs = epochs;
    training_options.batch = options_.optimisation.batch;
    training_options.seed = options_.optimisation.seed;
    training_options.adam.learning_rate = options_.optimisation.learning_rate;
    camouflage::Training<float> training(objective_, train_, usable_train,
                                         start_texture(options_, inputs_.car.painted), training_options);
    if (options_.resume) restore(training);
    optimise(training);
    report(training, test, usable_test, start);
  }

  [[nodiscard]] camouflage::ViewStore<float>::Settings store_settings() const {
    return {inputs_.detector.network.input_height(), inputs_.detector.network.input_width(),
            options_.scene.samples, options_.keep_mib << 20U};
  }

  [[nodiscard]] camouflage::ViewStore<float>& test_store() {
    return inputs_.frames.held_out ? test_ : train_;
  }
  [[nodiscard]] std::string path(const char* name) const { return options_.output + "/" + name; }

  [[nodiscard]] std::vector<std::string> input_paths() const {
    std::vector<std::string> paths{options_.scene.mesh};
    const auto& detector = options_.detector;
    for (const auto& optional : {detector.cfg, detector.weights, detector.names, options_.scene.faces})
      if (!optional.empty()) paths.push_back(optional);
    paths.insert(paths.end(), inputs_.frames.test.begin(), inputs_.frames.test.end());
    if (inputs_.frames.held_out)
      paths.insert(paths.end(), inputs_.frames.train.begin(), inputs_.frames.train.end());
    return paths;
  }

  /// The paths of the inputs in `some` that `others` lack, the first ten of them.
  static std::string names_of_missing(const Json& some, const Json& others) {
    std::string names;
    std::size_t count = 0;
    for (const auto& input : some) {
      if (std::find(others.begin(), others.end(), input) != others.end()) continue;
      if (++count <= 10) names += (names.empty() ? "" : ", ") + input.value("path", std::string("?"));
    }
    return count <= 10 ? names : names + ", ... (" + std::to_string(count) + " in all)";
  }

  /// A fresh folder gets its manifest; a folder to resume must hold one that agrees.
  void open_folder() {
    Json manifest{{"program", "camouflage"},
                  {"version", TAPESTRY_VERSION_TEXT},
                  {"compiler", __VERSION__},
                  {"seed", options_.optimisation.seed},
                  {"options", settings_json(options_)},
                  {"held_out", inputs_.frames.held_out},
                  {"inputs", input_hashes(input_paths())}};
    const Json identity{{"options", manifest["options"]}, {"inputs", manifest["inputs"]}};
    settings_ = exact_text(identity, -1);
    if (!options_.resume) {
      write_text(path("manifest.json"), exact_text(manifest) + "\n");
      return;
    }
    const Json saved = read_json(path("manifest.json"));
    std::string changed = names_of_missing(manifest["inputs"], saved["inputs"]);
    if (changed.empty()) changed = names_of_missing(saved["inputs"], manifest["inputs"]);
    if (!changed.empty())
      throw Error(ErrorKind::in_use, options_.output + ": cannot resume, inputs have changed: " + changed);
  }

  void restore(camouflage::Training<float>& training) {
    if (!std::filesystem::exists(path("checkpoint.npz"))) return;  // stopped before the first one
    auto checkpoint = camouflage::read_checkpoint<float>(path("checkpoint.npz"));
    if (checkpoint.settings != settings_)
      throw Error(ErrorKind::in_use, path("checkpoint.npz") + ": belongs to a run with other settings");
    training.restore(std::move(checkpoint.state));
    saved_steps_ = training.steps_taken();
  }

  void save(const camouflage::Training<float>& training) {
    camouflage::write_checkpoint(path("checkpoint.npz"), training.state(), settings_);
    write_text(path("history.csv"), history_csv(training.history()));
    saved_steps_ = training.steps_taken();
  }

  /// \throws Stopped after saving, when a signal arrives
  void optimise(camouflage::Training<float>& training) {
    ProgressLine progress;
    const auto start = Clock::now();
    std::size_t images = 0;
    const std::size_t first = training.steps_taken();
    while (!training.finished()) {
      try {
        images += training.step();
      } catch (const NumericError&) {
        save(training);  // the state before the step: the last good one
        throw;
      }
      const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
      show(progress, training, images, seconds, first);
      if (StopSignal::arrived()) {
        save(training);
        throw Stopped{};
      }
      if (training.steps_taken() % options_.checkpoint_steps == 0) save(training);
    }
    save(training);
    optimise_seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
    if (options_.profile) print_profile(training.steps_taken() - first);
  }

  static void show(ProgressLine& progress, const camouflage::Training<float>& training, std::size_t images,
                   double seconds, std::size_t first) {
    const auto& terms = training.history().back();
    const auto done = static_cast<double>(training.steps_taken() - first);
    const auto left = static_cast<double>(training.step_count() - training.steps_taken());
    char text[256];
    std::snprintf(text, sizeof text,
                  "step %llu/%zu  loss %.4f  iou %.3f  obj %.3f  cls %.3f  max %.3f  smooth %.1f  %.1f "
                  "images/s  %s left",
                  static_cast<unsigned long long>(training.steps_taken()), training.step_count(), terms.total,
                  terms.iou, terms.objectness, terms.classification, terms.max_score, terms.smoothness,
                  static_cast<double>(images) / seconds, duration_text(seconds / done * left).c_str());
    progress.show(text, training.finished());
  }

  void print_profile(std::size_t steps) {
    const auto& t = objective_.times();
    const std::vector<std::pair<const char*, double>> parts{{"render", t.render},
                                                            {"composite", t.compose},
                                                            {"detector forward", t.detector_forward},
                                                            {"detector backward", t.detector_backward},
                                                            {"losses", t.losses},
                                                            {"update", t.update}};
    const double total = optimise_seconds_;
    double accounted = 0;
    std::printf("time of a step, %zu steps\n", steps);
    for (const auto& [name, seconds] : parts) {
      std::printf("  %-18s %9.3f ms  %5.1f %%\n", name, 1e3 * seconds / static_cast<double>(steps),
                  100 * seconds / total);
      accounted += seconds;
    }
    std::printf("  %-18s %9.3f ms  %5.1f %%\n", "other",
                1e3 * (total - accounted) / static_cast<double>(steps), 100 * (total - accounted) / total);
    const double outside = 1 - (t.detector_forward + t.detector_backward) / total;
    std::printf("  outside the detector %.1f %%\n", 100 * outside);
  }

  void report(const camouflage::Training<float>& training, camouflage::ViewStore<float>& test,
              const std::vector<std::size_t>& usable, Clock::time_point start) {
    const auto colours = camouflage::texture_colours(training.parameter());
    const auto clean_colours = camouflage::own_colours<float>(inputs_.car.painted);
    Meter meter(inputs_.detector.network, inputs_.class_index, options_.detector);
    std::vector<Bitmap> before;
    std::vector<Bitmap> after;
    RunReport report;
    report.photo = measure("photo", meter, test, usable, nullptr);
    report.clean = measure("clean", meter, test, usable, &clean_colours, &before);
    report.adversarial = measure("adversarial", meter, test, usable, &colours, &after);
    for (const auto& control : make_controls(colours.shape(0), options_.optimisation.seed))
      report.controls.push_back(measure(control.name, meter, test, usable, &control.colours));
    report.asr = evaluate::attack_success_rate(report.clean.found, report.adversarial->found);
    write_textures(training.parameter(), colours);
    const std::size_t columns = before.size() > 12 ? 8 : 3;
    StopSignal::throw_if_arrived();  // a large sheet takes seconds to compress
    io::write_image(path("before.png"), contact_sheet(before, columns));
    StopSignal::throw_if_arrived();
    io::write_image(path("after.png"), contact_sheet(after, columns));
    io::write_image(path("result.png"), comparison(before, after, 6));
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    report.held_out = inputs_.frames.held_out;
    report.history = training.history();
    report.options = settings_json(options_);
    write_text(path("report.html"), report_html(report));
    write_text(path("metrics.json"), report_text(metrics_json(report)));
    std::cout << summary_text(report) << "report: " << path("report.html") << '\n';
  }

  void write_textures(const Array<float, 2>& parameter, const Array<float, 2>& colours) const {
    const auto& car = inputs_.car.painted;
    io::NpzWriter raw;
    raw.add("parameter", parameter);
    raw.add("colours", colours);
    raw.write(path("texture.npz"));
    const auto atlas = camouflage::atlas_of<float>(car, colours);
    io::write_image(path("texture.png"), atlas);
    io::write_painted_obj(path("painted.obj"), car.mesh, car.painted, atlas, car.layout.u_extent);
  }

  Options options_;
  Inputs inputs_;
  std::string resume_command_;
  camouflage::ViewStore<float> train_;
  camouflage::ViewStore<float> test_;
  camouflage::Objective<float> objective_;
  std::string settings_;
  double optimise_seconds_ = 0;
  std::uint64_t saved_steps_ = 0;
};

/// A folder that already holds a run is only touched to resume it.
void require_free_folder(const Options& options) {
  if (!options.resume && !options.output.empty() &&
      std::filesystem::exists(options.output + "/manifest.json"))
    throw Error(ErrorKind::in_use,
                options.output + " already holds a run; give --resume to go on with it, or another --output");
}

/// Takes the settings of a run to resume from its folder.
void adopt_run(const CLI::App& app, Options& options) {
  if (options.output.empty()) throw Error(ErrorKind::usage, "--resume needs --output, the folder of the run");
  const std::string manifest = options.output + "/manifest.json";
  if (!std::filesystem::exists(manifest))
    throw FileError(ErrorKind::malformed, {manifest, "", "no run to resume: the file is missing"});
  const Json saved = read_json(manifest);
  const auto& inputs = saved.is_object() && saved.contains("inputs") ? saved["inputs"] : Json();
  const auto is_input = [](const Json& input) {
    return input.is_object() && input.contains("path") && input["path"].is_string();
  };
  if (!inputs.is_array() || !std::all_of(inputs.begin(), inputs.end(), is_input) ||
      !saved.contains("options"))
    throw FileError(ErrorKind::malformed, {manifest, "", "not the manifest of a run"});
  std::vector<std::string> differing;
  adopt_saved(app, saved["options"], manifest, options.scene, differing);
  adopt_saved(app, saved["options"], manifest, options.detector, differing);
  adopt_saved(app, saved["options"], manifest, options.optimisation, differing);
  if (differing.empty()) return;
  std::string list;
  for (const auto& name : differing) list += (list.empty() ? "" : ", ") + name;
  throw Error(ErrorKind::in_use, options.output + ": cannot resume with other settings: " + list);
}

int check_only(const Options& options, ProblemList& list) {
  SceneSettings scene = options.scene;
  fill_in_bundled(scene);
  for (const auto& warning : warnings_about(scene)) std::cerr << "warning: " << warning << '\n';
  check_inputs(options.scene, options.detector, list);
  const auto& problems = list.problems();
  for (const auto& problem : problems) std::cerr << "error: " << problem.what() << '\n';
  if (problems.empty()) std::cout << "all inputs are sound\n";
  int code = 0;  // of several, the one a run would meet first: unreadable before unfit
  for (const auto& problem : problems)
    code = code == 0 ? static_cast<int>(problem.kind()) : std::min(code, static_cast<int>(problem.kind()));
  return code;
}

/// What to type to go on; settings come from the manifest.
std::string resume_command(const CLI::App& app, const char* program, const Options& options) {
  std::vector<std::string> words{program, "--resume", "--output", options.output};
  std::vector<std::string> from_manifest{"resume", "output"};
  const Json settings = settings_json(options);
  for (const auto& setting : settings.items()) from_manifest.push_back(setting.key());
  for (auto& word : given_options(app, from_manifest)) words.push_back(std::move(word));
  return shell_line(words);
}

int run(const CLI::App& app, const char* program, Options& options) {
  ProblemList problems;
  require_sound(options, problems);
  if (options.check && !options.resume) return check_only(options, problems);
  problems.throw_first();
  if (options.threads > 0) limit_threads(options.threads);
  const StopSignal stop_signal;
  if (options.resume) adopt_run(app, options);
  if (options.check) return check_only(options, problems);
  require_free_folder(options);
  Inputs inputs = load_inputs(options.scene, options.detector);
  require_one_scale(inputs.frames);
  const bool is_new = options.output.empty() || !std::filesystem::exists(options.output);
  if (options.output.empty()) options.output = make_next_folder("runs/camouflage");
  const RunFolder folder(options.output, is_new);
  require_free_folder(options);  // another process may have begun and ended a run there meanwhile
  const std::string resume = resume_command(app, program, options);
  return Run(std::move(options), std::move(inputs), resume).execute();
}

int camouflage_main(int argc, char** argv) {
  keep_freed_memory();
  Options options;
  CLI::App app(
      "Optimises a full-coverage camouflage for a car against a detector, for robustness research, and "
      "measures it beside the untouched photo, the clean car, random noise and solid colours.");
  describe(app, options);
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
}  // namespace

int main(int argc, char** argv) { return camouflage_main(argc, argv); }
