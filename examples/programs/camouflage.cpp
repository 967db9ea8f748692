// The main program: optimises a camouflage for a car against a detector, and measures its effect.

#include "shell/camouflage_run.hpp"
#include "shell/wild_boxes.hpp"

namespace tapestry::shell {
struct CleanViews {
  std::size_t views = 0, found = 0;  ///< pictures; those with a found car
  /// Pictures where it finds another class there, by its name.
  std::map<std::string, std::size_t> others{};
  WildBoxes boxes{};
};

/// Runs the detector on clean views: at most eight of the measured ones, evenly spread.
/// \throws Error (mismatch) if none of them shows the car, and as views_with_car()
inline CleanViews examine_clean_views(const Inputs& inputs, const SceneSettings& scene,
                                      const DetectorSettings& settings) {
  const auto& detector = inputs.detector;
  camouflage::ViewStore<float> store(
      inputs.car.painted, store_settings(inputs, scene, settings, 1024),
      frame_loaders(thinned(inputs.frames.test, 8), inputs.mask, inputs.frames.posed));
  std::vector<std::string> warnings;  // a run repeats them
  const auto usable = views_with_car(store, scene.mesh, inputs.car, warnings);
  if (usable.empty()) throw no_car_shown(scene.frames, inputs.car);
  evaluate::Meter meter(detector, inputs.class_index, {settings.confidence, settings.nms});
  const auto clean = camouflage::without_paint(camouflage::own_colours<float>(inputs.car.painted));
  CleanViews seen{usable.size()};
  static_cast<void>(evaluate::measure("clean", meter, store, usable, &clean, [&](const auto& measured) {
    using evaluate::Fate;
    const auto& outcome = measured.result.outcome;
    if (outcome.fate == Fate::found) ++seen.found;
    if (outcome.fate == Fate::related || outcome.fate == Fate::renamed)
      ++seen.others[class_name(outcome.class_index, detector.names(), "class ")];
    seen.boxes.add(measured.result.detections, detector.input_height(), detector.input_width());
  }));
  return seen;
}

/// Prints the number of clean views with a found car, and other classes found there.
/// \throws Error (mismatch) if in none, or if most boxes are wild
inline void require_car_found(const Inputs& inputs, const SceneSettings& scene,
                              const DetectorSettings& settings, std::vector<std::string>& warnings) {
  const CleanViews seen = examine_clean_views(inputs, scene, settings);
  const std::string name = in_quotes(class_name(inputs.class_index, inputs.detector.names()));
  std::string others;
  std::size_t renamed = 0;
  for (const auto& [other, count] : seen.others) {
    others += ", as " + in_quotes(other) + " in " + std::to_string(count);
    renamed += count;
  }
  const std::string views = std::to_string(seen.views) + " clean views";
  if (const std::string wild = seen.boxes.word(); !wild.empty())
    throw Error(ErrorKind::mismatch, {settings.weights, ": of ", views, ", ", wild});
  if (seen.found == 0)
    throw Error(
        ErrorKind::mismatch,
        {settings.weights, ": the car is found as ", name, " in none of ", views, others,
         others.empty() ? ", and as nothing else; see --detector, --fit and --confidence" : "; see --class"});
  if (renamed > seen.found || 2 * seen.found < seen.views)
    warnings.push_back("the car is found as " + name + " in " + std::to_string(seen.found) + " of " + views +
                       " only" + others + ": are --class, --detector and --confidence right?");
  else
    remark("the car is found as " + name + " in " + std::to_string(seen.found) + " of " + views + others);
}
}  // namespace tapestry::shell

namespace {
using namespace tapestry;
using namespace tapestry::shell;

/// Reads the inputs of a run with all detectors, and checks that they meet the method's needs.
Inputs load_all(CamouflageOptions& options) {
  std::vector<std::string> layers;
  const auto& method = camouflage::method_row<float>(options.optimisation.method);
  const std::string named = "--method " + method.name;
  if (method.traits.maps_attention) layers.emplace_back();  // the last one of all heads
  Inputs inputs = load_inputs(options.scene, options.detector, layers);
  if (!options.resume && method.traits.tells_texels_apart) require_texels(options.scene, inputs.car);
  if (method.traits.maps_attention && options.optimisation.objective.smoothness > 0)
    inputs.warnings.push_back(named +
                              ": smoothness outweighs the loss of attention by far; DAS has no such term, "
                              "see --smoothness-weight 0");
  if (method.traits.moves_shape && inputs.car.painted.pictures &&
      options.scene.filter != raster::name_of(raster::TextureFilter::bilinear))
    throw Error(ErrorKind::usage,
                named + " moves the mesh with its own textures (map_Kd); it needs --filter bilinear");
  loss::require_raw_logits("camouflage", inputs.detector.heads());
  inputs.ensemble =
      load_ensemble(options.optimisation.ensemble, options.detector, inputs.detector, inputs.warnings);
  (void)chosen_method(options.optimisation, inputs.car.painted, options.scene.mesh);
  inputs.palette = palette_of(options.optimisation);
  return inputs;
}

/// Reports every problem of the inputs.
/// \returns the exit code
int check_only(CamouflageOptions options, ProblemList& list) {
  std::vector<std::string> warnings;
  check_inputs(options.scene, options.detector, list, warnings);
  list.attempt([&] { (void)palette_of(options.optimisation); });
  list.attempt([&] { require_free_folder(options); });
  list.attempt([&] { require_makeable_folder(options.output.empty() ? "runs" : options.output); });
  try {
    if (list.problems().empty())
      list.attempt([&] {
        const Inputs inputs = load_all(options);
        require_car_found(inputs, options.scene, options.detector, warnings);
      });
  } catch (const Stopped&) {
    return StopSignal::exit_code();
  }
  print_warnings(warnings);
  const auto& problems = list.problems();
  for (const auto& problem : problems) std::cerr << "error: " << line_of(problem) << '\n';
  if (problems.empty())
    remark(warnings.empty() ? "all inputs are sound" : "all inputs can be used; see the warnings");
  int code = 0;  // of the problem that a run would meet first: unreadable before unfit
  for (const auto& problem : problems)
    code = code == 0 ? static_cast<int>(problem.kind()) : std::min(code, static_cast<int>(problem.kind()));
  return code;
}

int run(const CLI::App& app, const char* program, CamouflageOptions& options) {
  if (options.lists_methods) {
    for (const auto& method : camouflage::methods<float>())
      std::cout << method.name << ' ' << method.traits.usual_options << '\n';
    return 0;
  }
  ProblemList problems;
  require_sound(options, problems);
  if (options.check && !options.resume) return check_only(options, problems);
  problems.throw_first();
  take_over_run(options, "camouflage");
  const StopSignal stop_signal;
  io::InputLedger ledger;
  ledger.leave_out(options.output);
  if (options.resume)
    adopt_run_settings(app, options, "camouflage", options.scene, options.detector, options.optimisation,
                       options.survey);
  if (options.check) return check_only(options, problems);
  require_free_folder(options);
  Inputs inputs = load_all(options);
  require_one_scale(inputs.frames);
  if (!Ranks::all().is_first()) return CamouflageRun(std::move(options), std::move(inputs), "").execute();
  const auto folder = claim_folder(options, "runs/camouflage", ledger);
  const auto& ranks = Ranks::all();
  const std::string resume =
      (ranks.count() > 1 ? "mpirun -n " + std::to_string(ranks.count()) + " " : std::string()) +
      resume_line(app, program, options, settings_json(options));
  return CamouflageRun(std::move(options), std::move(inputs), resume).execute();
}
}  // namespace

int main(int argc, char** argv) {
  CamouflageOptions options;
  auto app = command_line(
      "Optimises a full-coverage camouflage for a car against a detector, for robustness research, and "
      "measures it beside the untouched photo, the clean car, noise matched to it, random noise and solid "
      "colours.");
  describe(app, options);
  app.footer(
      "  camouflage --output first\n"
      "  camouflage --resume --output first\n"
      "  camouflage --config settings.toml --check");
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
