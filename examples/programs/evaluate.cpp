// Measures a finished camouflage, with its own detector or another one, or a detector on labelled pictures.

#include "shell/dataset_evaluation.hpp"
#include "shell/protocol/foreign.hpp"
#include "shell/reshaped_views.hpp"
#include "shell/run_page.hpp"
#include "shell/side_by_side.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;

struct Options {
  CamouflageSource camouflage;
  std::string against;
  SceneSettings scene;
  DetectorSettings detector;
  DatasetSettings dataset;
  ProtocolSettings protocol;
  std::vector<double> sweep{0.05, 0.1, 0.25, 0.5, 0.75};
  std::vector<std::string> conditions;
  std::size_t draws = 4;
  std::string pictures;
  std::string detections;
  std::string output;
  std::string film;
  double seconds = 0.5;
  std::uint64_t seed = 1;
  bool clean_only = false;
  bool accept_changed_inputs = false;
  bool other_frames = false;  ///< others than the run's
  std::string command{};      ///< the command line
};

void describe_other_detectors(CLI::App& app, Options& options) {
  auto* const pictures = app.add_option(
      "--pictures", options.pictures,
      "folder to write every picture of --protocol to, digital when left out, as PNG, with COCO's labels "
      "(instances.json), for detectors of other programs; they are then measured as these files hold them");
  app.add_option(
         "--detections", options.detections,
         "COCO results (.json) of any program over the pictures that are in --pictures already: their "
         "tables, without a detector of our own")
      ->needs(pictures);
}

void describe_film(CLI::App& app, Options& options) {
  auto* const film = app.add_option(
      "--film", options.film,
      "animated PNG (APNG) to write: plain car, noise and paint side by side with the detector's boxes, "
      "one view after the other; of more than 24 views, evenly spread ones");
  app.add_option("--seconds", options.seconds, "that --film shows a view")
      ->needs(film)
      ->check(CLI::Range(0.01, 60.0));
}

void describe(CLI::App& app, Options& options) {
  app.option_defaults()->group("Measurement");
  auto* const run = app.add_option(
      "--run", options.camouflage.run,
      "run folder of camouflage, needed without --paint or --clean-only; its settings apply where none are "
      "given");
  app.add_option(
         "--paint", options.camouflage.picture,
         "picture of anyone's camouflage instead, on the painted faces by their uv; --texels: its rows, "
         "at most 1024, when left out")
      ->excludes(run);
  app.add_flag(
         "--accept-changed-inputs", options.accept_changed_inputs,
         "measure although mesh, weights, frames or paint of the run, or of that of --against, have changed, "
         "which is refused otherwise; the changes are written into the metrics")
      ->needs(run);
  app.add_option(
      "--against", options.against,
      "folder of another run of the same car, measured as 'other run', with the effect of --run beyond it");
  add_options(app, options.scene);
  add_options(app, options.detector);
  add_options(app, options.dataset);
  add_options(app, options.protocol, help_of(protocols()));
  app.option_defaults()->group("Measurement");
  app.add_option("--sweep", options.sweep, "confidence thresholds, 0 to 1, at which P@0.5 is listed as well");
  app.add_option("--conditions", options.conditions,
                 "conditions under which the views are photographed: " + conditions_help +
                     "; left out, they are measured as they are");
  app.add_option("--draws", options.draws, "photographs of each view under --conditions");
  describe_other_detectors(app, options);
  app.add_option(
      "--output", options.output,
      "folder for report.html, metrics.json, metrics.csv, views.csv and a contact sheet, or for the files of "
      "--protocol, which goes on there when it was interrupted; nothing is written when left out");
  describe_film(app, options);
  app.add_option("--seed", options.seed,
                 "seed of the random controls; use the run's seed to get the run's own controls again");
  add_threads_option(app);
  app.add_flag("--clean-only", options.clean_only, "no texture: measure photo, clean and the controls");
}

/// Takes settings that were not given from the run. A detector given here, as a cfg or a single file,
/// replaces the run's altogether. Darknet weights alone replace only the weights for the run's cfg.
void adopt_run(const CLI::App& app, Options& options) {
  const std::string manifest = manifest_path(options.camouflage.run);
  const Json saved = read_manifest(options.camouflage.run);
  std::vector<std::string> differing;
  adopt_saved(app, saved["options"], manifest, options.scene, differing);
  if (options.scene.mask != "u2net" && app.get_option("--segmenter")->count() == 0)
    options.scene.segmenter = "";
  const auto is_frames = [](const std::string& name) { return name.rfind("--frames ", 0) == 0; };
  options.other_frames = std::any_of(differing.begin(), differing.end(), is_frames);
  const bool other_detector =
      app.get_option("--cfg")->count() > 0 ||
      (app.get_option("--weights")->count() > 0 && io::is_onnx(options.detector.weights));
  if (!other_detector) adopt_saved(app, saved["options"], manifest, options.detector, differing);
  Json used = json_of_settings(options.scene, options.detector);
  if (!options.protocol.protocol.empty() && !is_on_photographs(options.protocol.protocol))
    used.erase("frames"), used.erase("segmenter");
  require_inputs_of_run(used, options.camouflage.run, saved, "give another by that option");
}

/// Takes over the start folder and the instruction set of the measured run, or of an interrupted
/// measurement, see run_origin.hpp; warns of files that the run has not written. Must be called before
/// anything is recorded or computed.
void take_over_run(Options& options) {
  auto& [run, picture] = options.camouflage;
  SceneSettings& scene = options.scene;
  DetectorSettings& detector = options.detector;
  std::vector<std::string*> paths{&run,          &picture,         &options.against, &options.output,
                                  &options.film, &options.pictures};
  for (auto* path : {&scene.mesh, &scene.faces, &scene.frames, &scene.segmenter, &detector.cfg,
                     &detector.weights, &detector.names})
    paths.push_back(path);
  for (auto& weights : options.protocol.further_weights) paths.push_back(&weights);
  if (options.detector.detector.find_first_of("./") != std::string::npos)  // else it is the word of a family
    paths.push_back(&options.detector.detector);
  const auto folder = go_where_it_began(run, "camouflage", paths);
  if (!folder.empty()) remark("paths of the run start in " + folder);
  if (!options.protocol.protocol.empty() && !options.output.empty())
    adopt_instruction_set(options.output + "/settings.json");
  for (const std::string& measured : {run, options.against}) {
    if (measured.empty()) continue;
    require_file_of(measured, "manifest.json", "camouflage");
    adopt_instruction_set(manifest_path(measured));
    if (!options.clean_only) print_warnings(warnings_about_outputs(measured, "texture.npz"));
    const auto build = other_facts(read_manifest(measured), facts_of_bits);
    if (!build.empty()) print_warnings({measured + " was made by another build: " + build});
  }
}

void require_no_run(const Options& options) {
  if (!options.output.empty() && is_there(manifest_path(options.output), ErrorKind::write))
    throw Error(ErrorKind::in_use,
                options.output + " holds a run, whose metrics would be lost; give another --output");
}

/// Checks the options after the run's settings are adopted.
void require_sound(const CLI::App& app, const Options& options) {
  ProblemList list;
  require_protocol_options(app, options.protocol, is_on_photographs(options.protocol.protocol),
                           is_before_plain_background(options.protocol.protocol), options.clean_only, list);
  require_sound(options.protocol, names_of(protocols()), list);
  list.attempt([&] { (void)heat_map_by_name(options.protocol.heat_map_kind); });
  require_sound(options.scene, list);
  require_sound(options.detector, list);
  list.attempt([&] { (void)image::conditions_by_names(options.conditions); });
  list.require(!options.conditions.empty() || app.get_option("--draws")->count() == 0,
               "--draws needs --conditions");
  list.require(options.draws >= 1 && options.draws <= 1000, "--draws must be 1 to 1000");
  list.require(options.camouflage.picture.empty() || options.scene.texture == "atlas",
               "--paint needs --texture atlas");
  for (const double threshold : options.sweep)
    list.require(threshold >= 0 && threshold <= 1, "--sweep thresholds lie in 0 to 1");
  list.require(options.pictures.empty() || options.pictures != options.output,
               "--pictures and --output are the same folder");
  list.require(options.film.empty() || options.film.ends_with(".png"),
               "--film takes a name that ends with .png");
  list.require(options.film.empty() || options.protocol.protocol.empty(), "--film is of no --protocol");
  list.throw_first();
  require_no_run(options);
}

evaluate::Photography photography_of(const Options& options) {
  evaluate::Photography photography;
  if (options.conditions.empty()) return photography;
  photography.conditions = image::conditions_by_names(options.conditions);
  photography.draws = options.draws;
  photography.seed = options.seed;
  return photography;
}

/// Prints how often the car was found at each threshold of the sweep, and adds it to the metrics.
void print_sweep(const std::vector<double>& sweep, const RunReport& report, Json& metrics) {
  std::printf("P@0.5 by confidence threshold\n  %-13s", "");
  for (const double threshold : sweep) std::printf(" %7.2f", threshold);
  std::printf("\n");
  const auto print_row = [&](const evaluate::Measurement& row) {
    std::printf("  %-13s", row.name.c_str());
    for (std::size_t i = 0; i < sweep.size(); ++i) {
      std::printf(" %5.1f %%", 100 * row.sweep[i].p_at_50);
      metrics["sweep"][row.name].push_back({{"confidence", sweep[i]}, {"p_at_50", row.sweep[i].p_at_50}});
    }
    std::printf("\n");
  };
  for (const auto* row : rows_of(report)) print_row(*row);
}

/// Inputs that have changed since the measured runs, each file once.
/// \throws Error (in_use) unless changes are accepted
std::vector<ChangedInput> changed_since_runs(const Options& options, Inputs& inputs) {
  note_frames(inputs.frames.test, inputs.mask);
  std::vector<ChangedInput> changed;
  for (const std::string& run : {options.camouflage.run, options.against})
    for (const ChangedInput& input :
         require_run_inputs({run, options.accept_changed_inputs, !options.clean_only}, options.scene,
                            inputs.car, inputs.frames.test, inputs.warnings))
      if (std::ranges::find(changed, input) == changed.end()) changed.push_back(input);
  return changed;
}

/// \throws Error (usage) for options that do not go together
void require_consistent(const CLI::App& app, const Options& options) {
  for (const char* option :
       {"--images", "--dataset-names", "--classes", "--most-detections", "--results", "--csv", "--json"})
    if (app.get_option(option)->count() > 0)
      throw Error(ErrorKind::usage, std::string(option) + " needs --dataset");
  if (!options.camouflage.is_given() && !options.clean_only)
    throw Error(ErrorKind::usage, "give --run, the folder of a camouflage run, --paint, or --clean-only");
  if (!options.against.empty() && options.clean_only)
    throw Error(ErrorKind::usage, "--against needs --run, which it is compared with");
}

/// The frames as the detector receives them, with the car in the shape that the runs optimised.
struct MeasuredViews {
  MeasuredViews(const Options& options, Inputs& inputs)
      : car(inputs.car.painted),
        settings(store_settings(inputs, options.scene, options.detector, 4096)),
        loaders(frame_loaders(inputs.frames.test, inputs.mask, inputs.frames.posed)),
        store(car, settings, loaders),
        usable(views_with_car(store, options.scene.mesh, inputs.car, inputs.warnings,
                              !options.camouflage.run.empty())),
        reshaped(reshaped_by(options.clean_only ? CamouflageSource() : options.camouflage)),
        reshaped_by_other(reshaped_by({options.against, ""})) {
    print_warnings(inputs.warnings);
    if (usable.empty()) throw no_car_shown(options.scene.frames, inputs.car);
  }

  std::optional<ReshapedViews> reshaped_by(const CamouflageSource& source) {
    std::optional<ReshapedViews> views;
    const auto offsets = read_offsets_of(source, car);
    if (offsets.size() == 0) return views;
    views.emplace(car, offsets, settings, loaders);
    usable = views->also_with_car(usable);
    return views;
  }

  const raster::PaintedMesh& car;
  camouflage::ViewStore<float>::Settings settings;
  std::vector<camouflage::ViewStore<float>::Loader> loaders;
  camouflage::ViewStore<float> store;
  std::vector<std::size_t> usable;  ///< views that show the car in all of its shapes
  std::optional<ReshapedViews> reshaped, reshaped_by_other;
};

/// The car's own colours, the run's paint and the controls, in the shapes of the runs.
evaluate::SurveyedTextures surveyed_textures(const Options& options, const Car& loaded,
                                             MeasuredViews& views) {
  const auto& car = loaded.painted;
  evaluate::SurveyedTextures textures{camouflage::without_paint(camouflage::own_colours<float>(car)), {}, {}};
  const std::size_t texel_count = textures.clean.colours.shape(0);
  if (!options.clean_only)
    textures.adversarial = read_camouflage(options.camouflage, loaded, options.scene.mesh);
  textures.controls = textures.adversarial ? evaluate::make_controls(car, *textures.adversarial, options.seed)
                                           : evaluate::plain_controls(texel_count, options.seed);
  if (!options.against.empty())
    textures.controls.push_back(
        {evaluate::other_run_name, read_camouflage({options.against, ""}, loaded, "")});
  if (views.reshaped) textures.reshaped = &views.reshaped->store();
  if (views.reshaped_by_other) textures.reshaped_by_other = &views.reshaped_by_other->store();
  return textures;
}

void add_facts(const Options& options, const Inputs& inputs, const evaluate::SurveyedTextures& textures,
               RunReport& report) {
  report.noise_in_place = evaluate::noise_in_place(textures.controls);
  report.held_out = inputs.frames.held_out || options.other_frames || options.camouflage.run.empty();
  add_json(report.options, options.scene);
  add_json(report.options, options.detector);
  if (!options.camouflage.picture.empty()) report.options["paint"] = options.camouflage.picture;
  report.options["seed"] = options.seed;
  if (options.conditions.empty()) return;
  report.options["conditions"] = options.conditions;
  report.options["draws"] = options.draws;
}

/// Everything that is written to the folder; the metrics come last.
struct Written {
  const RunReport& report;
  const Json& metrics;
  const std::vector<ChangedInput>& changed;
  const evaluate::SurveyedTextures& textures;
  const raster::PaintedMesh& car;  ///< in the shape that the run optimised
};

void write_folder(const Options& options, const Written& what, const raster::PaintedMesh& own_car,
                  const std::vector<MarkedPicture>& pictures, const SideBySide& side_by_side, ViewList list) {
  const char* const shown = options.clean_only ? "clean" : "adversarial";
  const std::string sheet = std::string(shown) + ".png";
  io::write_image(options.output + "/" + sheet, contact_sheet(pictures, sheet_columns(pictures.size())));
  io::write_image(options.output + "/side_by_side.png", side_by_side.sheet(list.views));
  auto page = page_of(what.report, "Evaluation", options.command, std::move(list));
  remark_on_photographs(page);
  if (!what.changed.empty())
    page.findings = "<p><b>Inputs have changed since the run: " + escaped(text_of(what.changed)) +
                    ".</b></p>\n" + page.findings;
  page.pictures = side_by_side.pictures();
  const auto& paint = what.textures.adversarial ? *what.textures.adversarial : what.textures.clean;
  const auto atlas = camouflage::atlas_of<float>(own_car, paint.colours);
  page.atlases = {{shown, image::to_bytes(atlas)}};
  io::write_painted_glb(options.output + "/painted.glb", what.car, atlas);
  page.glb = io::read_text_file(options.output + "/painted.glb");
  page.files = {"painted.glb", sheet, "side_by_side.png", "metrics.csv", "views.csv", "metrics.json"};
  write_text(options.output + "/metrics.csv", metrics_csv(what.report));
  write_text(options.output + "/views.csv", views_csv(page.list));
  write_text(options.output + "/report.html", page_html(page));
  write_text(options.output + "/metrics.json", report_text(what.metrics));
  remark("report: " + options.output + "/report.html");
}

/// Measures the frames and writes the results to the folder of --output.
int survey_frames(Options& options) {
  Inputs inputs = load_inputs(options.scene, options.detector);
  const auto changed = changed_since_runs(options, inputs);
  const auto& car = inputs.car.painted;
  MeasuredViews views(options, inputs);
  const auto textures = surveyed_textures(options, inputs.car, views);
  std::optional<RunFolder> claim;
  if (!options.output.empty()) {
    claim.emplace(options.output, !is_there(options.output, ErrorKind::write));
    require_no_run(options);  // another process may have begun one there meanwhile
  }
  evaluate::Meter meter(inputs.detector, inputs.class_index,
                        {options.detector.confidence, options.detector.nms, options.sweep});
  std::vector<MarkedPicture> shown;
  const auto start = std::chrono::steady_clock::now();
  const auto photography = photography_of(options);
  const std::size_t pictures = views.usable.size() * photography.draws;
  SurveyWatch watch(meter, textures.pictures_a_view() * pictures,
                    std::max(inputs.detector.input_height(), inputs.detector.input_width()));
  watch.collect(options.clean_only ? "clean" : "adversarial", shown, pictures);
  const SideBySide side_by_side(watch, pictures);
  RunReport report;
  report.survey = evaluate::survey(meter, views.store, views.usable, textures, std::ref(watch), photography);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  add_facts(options, inputs, textures, report);
  std::cout << summary_text(report);
  Json metrics = metrics_json(report);
  metrics["inputs"] = recorded_inputs();
  if (!changed.empty()) metrics["changed_inputs"] = json_of(changed);
  print_sweep(options.sweep, report, metrics);
  if (!options.output.empty())
    write_folder(options, {report, metrics, changed, textures, views.reshaped ? views.reshaped->car() : car},
                 car, shown, side_by_side, list_of(report, watch.views()));
  if (!options.film.empty()) side_by_side.write_film(options.film, options.seconds);
  return 0;
}

/// Writes tables of another program's detections.
int evaluate_detections(const CLI::App& app, const Options& options) {
  for (const auto* option : app.get_options()) {
    const std::vector<std::string> known{"--pictures", "--detections", "--confidence", "--nms",    "--output",
                                         "--run",      "--threads",    "--quiet",      "--verbose"};
    if (option->count() > 0 && option->get_configurable() &&
        std::ranges::find(known, option->get_name()) == known.end())
      throw Error(ErrorKind::usage, option->get_name() + " has no part in --detections");
  }
  ProblemList problems;
  require_sound(options.detector, problems);
  problems.throw_first();
  const io::InputLedger ledger;
  auto exported = read_exported_pictures(options.pictures);
  if (!options.camouflage.run.empty())
    require_pictures_of(options.camouflage.run, exported.about, options.pictures);
  std::optional<double> nms;
  if (app.get_option("--nms")->count() > 0) nms = options.detector.nms;
  read_detections(options.detections, exported, nms);
  require_no_run(options);
  return evaluate_foreign_protocol(
      {options.pictures, options.detections, options.detector.confidence, nms, options.output}, exported);
}

int run(const CLI::App& app, Options& options) {
  if (!options.pictures.empty() && options.protocol.protocol.empty()) options.protocol.protocol = "digital";
  if (Ranks::all().count() > 1 && (options.protocol.protocol.empty() || !options.pictures.empty()))
    throw Error(ErrorKind::usage,
                "several ranks of mpirun can share the work of --protocol without --pictures only");
  if (!options.dataset.dataset.empty()) return evaluate_dataset(app, options.dataset, options.detector);
  if (!options.detections.empty()) return evaluate_detections(app, options);
  require_consistent(app, options);
  take_over_run(options);
  io::InputLedger ledger;
  ledger.leave_out(options.output);
  if (!options.camouflage.run.empty()) adopt_run(app, options);
  if (!options.camouflage.picture.empty() && options.scene.texels == 0)
    options.scene.texels = std::min<std::size_t>(1024, io::read_texture(options.camouflage.picture).shape(0));
  require_sound(app, options);
  if (options.protocol.protocol.empty()) return survey_frames(options);
  return evaluate_protocol({options.protocol,
                            options.scene,
                            options.detector,
                            options.clean_only ? CamouflageSource() : options.camouflage,
                            options.seed,
                            options.output,
                            options.pictures,
                            {options.camouflage.run, options.accept_changed_inputs, !options.clean_only}});
}
}  // namespace

int main(int argc, char** argv) {
  Options options;
  auto app = command_line(
      "Measures how often a detector finds a car: the untouched photo, the clean car, a camouflage and the "
      "controls; with --cfg or converted --weights, how well a camouflage transfers to another detector. "
      "With --protocol, the same over renders from all around, or of a partly hidden car. Or, with "
      "--dataset, average precision on labelled pictures.");
  describe(app, options);
  app.footer(
      "  evaluate --run runs/camouflage-001\n"
      "  evaluate --run runs/camouflage-001 --weights yolox_nano.onnx --class 2\n"
      "  evaluate --dataset labels/instances.json --weights yolox_nano.onnx");
  auto words = platform::command_line_words(argc, argv);
  words.front() = "evaluate";
  options.command = shell_line(words);
  return run_program(app, argc, argv, [&] { return run(app, options); });
}
