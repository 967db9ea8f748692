// Fine-tunes a detector against optimised car paint, and measures the gain.

#include "shell/hardening.hpp"
#include "shell/hardening_report.hpp"
#include "shell/run_page.hpp"
#include "shell/step_log.hpp"
#include "shell/survey_watch.hpp"
#include "shell/texture_training.hpp"

namespace tapestry::shell {
/// One run of harden in its folder: the rounds, then the attacks that are measured, then the report. Each
/// part saves its own checkpoint, so that a run can be resumed after any interruption.
class HardeningRun {
 public:
  /// \param hardened a copy of the inputs' detector, to train
  HardeningRun(HardenOptions options, Inputs inputs, std::unique_ptr<LearningDetector> hardened,
               std::string resume_command)
      : options_(std::move(options)),
        inputs_(std::move(inputs)),
        resume_command_(std::move(resume_command)),
        undefended_(inputs_.detector),
        hardened_(std::move(hardened)),
        train_(inputs_.car.painted, store_settings(), train_loaders(inputs_.frames, inputs_.mask)),
        test_(inputs_.car.painted, store_settings(),
              frame_loaders(inputs_.frames.test, inputs_.mask, inputs_.frames.posed)) {}

  /// \returns the exit code
  int execute() {
    return run_resumable(
        options_.output, resume_command_, [&] { run(); }, [] { return ""; });
  }

 private:
  using Clock = std::chrono::steady_clock;
  using Colours = Array<float, 2>;

  /// Colours of the paints that are measured.
  struct Attacks {
    Colours transfer, on_undefended, on_hardened;
  };

  void run() {
    const auto start = Clock::now();
    print_warnings(inputs_.warnings);
    std::vector<std::string> warnings;
    const auto with_car = [&](camouflage::ViewStore<float>& store) {
      return views_with_car(store, options_.scene.mesh, inputs_.car, warnings);
    };
    usable_train_ = with_car(train_);
    usable_test_ = inputs_.frames.held_out ? with_car(test_) : usable_train_;
    print_warnings(warnings);
    if (usable_train_.empty() || usable_test_.empty()) throw no_car_shown(options_.scene.frames, inputs_.car);
    if (options_.harden.epochs == 0)
      options_.harden.epochs = default_epochs(usable_train_.size(), inputs_.frames.drawn > 0);
    identity_ = open_run(options_, "harden", settings_json(options_), options_.harden.seed,
                         inputs_.frames.held_out, "hardened.onnx");
    harden();
    if (options_.harden.attacks == "none") return report(std::nullopt, start);
    Random seeds = Random(options_.harden.seed).fork(0x61747461636BULL);
    const std::uint64_t transfer_seed = seeds.bits(), fresh_seed = seeds.bits();
    Attacks attacks;
    attacks.transfer = attack("transfer", "undefended", undefended_, transfer_seed);
    attacks.on_undefended = attack("adaptive_undefended", "undefended", undefended_, fresh_seed);
    attacks.on_hardened = attack("adaptive_hardened", "hardened", hardened_->detector(), fresh_seed);
    report(attacks, start);
  }

  [[nodiscard]] camouflage::ViewStore<float>::Settings store_settings() const {
    return shell::store_settings(inputs_, options_.scene, options_.detector, options_.keep_mib);
  }

  [[nodiscard]] std::string path(const std::string& name) const { return options_.output + "/" + name; }

  /// Whether the detector has the classes that drawn scenes are labelled with, and no others.
  [[nodiscard]] bool knows_scenes() const {
    return inputs_.detector.names() == std::vector<std::string>{"car", "van", "clutter"};
  }

  /// Labelled street scenes for the detector's input; none unless that is square.
  [[nodiscard]] std::vector<scenes::LabelledScene> scenes_of(std::uint64_t stream, std::size_t count) const {
    const std::size_t size = undefended_.input_width();
    std::vector<scenes::LabelledScene> drawn(undefended_.input_height() == size ? count : 0);
    const Random source = Random(options_.harden.seed).fork(stream);
    parallel_for(drawn.size(), [&](std::size_t i) {
      StopSignal::throw_if_arrived();
      drawn[i] = scenes::draw_labelled(source.fork(i), {}, size);
    });
    return drawn;
  }

  void harden() {
    const CleanSource clean{scenes_of(0x636C65616EULL, knows_scenes() ? options_.harden.clean_scenes : 0),
                            camouflage::own_colours<float>(inputs_.car.painted),
                            view_truths(undefended_, inputs_.class_index, train_, usable_train_,
                                        options_.detector.confidence, options_.detector.nms)};
    Hardening hardening(*hardened_, options_.harden,
                        {inputs_.car.painted, train_, usable_train_, clean, inputs_.class_index});
    const std::string checkpoint = path("checkpoint.npz");
    if (options_.resume && is_there(checkpoint, ErrorKind::malformed))
      hardening.restore(checkpoint, read_hardening(checkpoint, identity_, hardening.state()));
    const auto save = [&] { write_hardening(checkpoint, hardening.state(), identity_); };
    take_steps(hardening, options_.checkpoint_steps, save,
               [&] { return "hardening: " + hardening.progress_text(); });
    history_ = hardening.history();
    write_text(path("history.csv"), history_csv(history_));
    hardened_->save(path("hardened.onnx"));
  }

  /// Optimises a paint against a detector with the budget of --epochs.
  /// \returns its colours
  Colours attack(const std::string& name, const std::string& detector_name,
                 const detect::Detector<float>& detector, std::uint64_t seed) {
    camouflage::Objective<float> objective(detector, objective_options(options_.harden, inputs_.class_index));
    camouflage::TrainingOptions options;
    options.epochs = options_.harden.epochs;
    options.batch = options_.harden.batch;
    options.seed = seed;
    options.adam.learning_rate = options_.harden.learning_rate;
    const std::size_t texels = inputs_.car.painted.layout.texel_count(inputs_.car.painted.mesh);
    camouflage::Training<float> training(objective, train_, usable_train_, zeros<float, 2>({texels, 3}),
                                         options);
    const std::string checkpoint = path(name + ".npz");
    if (options_.resume) restore_training(checkpoint, identity_, training);
    take_steps(
        training, options_.checkpoint_steps,
        [&] { camouflage::write_checkpoint(checkpoint, training.state(), identity_); },
        [&] {
          return formatted("attacking the %s detector (%s): step %llu of %zu, loss %.3f",
                           detector_name.c_str(), name.c_str(),
                           static_cast<unsigned long long>(training.steps_taken()), training.step_count(),
                           training.history().empty() ? 0 : training.history().back().total);
        });
    auto colours = camouflage::texture_colours(training.parameter());
    write_described_texture(path(name + ".png"), atlas_of(colours),
                            exported_description(inputs_.car.painted, inputs_.car.description));
    return colours;
  }

  [[nodiscard]] Array<float, 3> atlas_of(const Colours& colours) const {
    return camouflage::atlas_of<float>(inputs_.car.painted, colours);
  }

  /// Detections of a detector, the views it was measured on, and pictures of them under its adaptive attack.
  struct Examined {
    DetectorFindings found;
    std::vector<ViewFacts> views;
    std::vector<MarkedPicture> attacked;
  };

  /// \param attacks   null: none are measured
  /// \param adaptive  of the attacks, that on this detector
  [[nodiscard]] Examined examined(const std::string& name, const detect::Detector<float>& detector,
                                  const std::optional<Attacks>& attacks, Colours Attacks::*adaptive,
                                  const std::vector<scenes::LabelledScene>& test_scenes) {
    auto& store = inputs_.frames.held_out ? test_ : train_;
    const auto& car = inputs_.car.painted;
    const std::uint64_t seed = options_.harden.seed;
    using Paint = camouflage::Paint<float>;
    const Paint clean = camouflage::without_paint(camouflage::own_colours<float>(car));
    const Paint random = evaluate::plain_controls(clean.colours.shape(0), seed).front().paint;
    std::map<std::string, Paint> paints{{"clean", clean}, {"random", random}};
    const auto add_attack = [&](const std::string& row, const Colours& colours) {
      paints[row] = {colours};
      paints[row + " noise"] = evaluate::matched_controls(car, {colours}, seed).front().paint;
    };
    if (attacks) add_attack("transfer", attacks->transfer);
    if (attacks) add_attack("adaptive", (*attacks).*adaptive);
    evaluate::Meter meter(detector, inputs_.class_index,
                          {options_.detector.confidence, options_.detector.nms});
    SurveyWatch watch(meter, (1 + paints.size()) * usable_test_.size(),
                      std::max(detector.input_height(), detector.input_width()));
    Examined result{{name, {}, {}}, {}, {}};
    watch.collect("adaptive", result.attacked, usable_test_.size(), most_large_views);
    for (const auto& [row, what] : hardening_rows) {
      const auto paint = paints.find(row);
      if (paint == paints.end() && row != "photo") continue;
      result.found.rows.push_back(evaluate::measure(row, meter, store, usable_test_,
                                                    paint == paints.end() ? nullptr : &paint->second, watch));
    }
    if (!test_scenes.empty())
      result.found.precision = scene_precision(
          detector, options_.detector.nms, options_.detector.confidence,
          knows_scenes() ? SceneClasses{0, 1, 2} : SceneClasses{inputs_.class_index}, test_scenes);
    result.views = watch.views();
    return result;
  }

  void add_attacks(ReportPage& page, const Attacks& attacks, std::vector<MarkedPicture> before,
                   std::vector<MarkedPicture> after) const {
    page.pictures.places = shown_places(before.size(), usable_test_.size());
    page.pictures.ways = {{"the undefended detector, under the attack made against it", std::move(before)},
                          {"the hardened detector, under the attack made against that", std::move(after)}};
    const auto hardened = atlas_of(attacks.on_hardened);
    page.atlases = {{"transfer", image::to_bytes(atlas_of(attacks.transfer))},
                    {"adaptive, undefended", image::to_bytes(atlas_of(attacks.on_undefended))},
                    {"adaptive, hardened", image::to_bytes(hardened)}};
    io::write_painted_glb(path("adaptive_hardened.glb"), inputs_.car.painted, hardened);
    page.glb = io::read_text_file(path("adaptive_hardened.glb"));
    page.files.insert(page.files.begin() + 1, "adaptive_hardened.glb");
  }

  void report(const std::optional<Attacks>& attacks, Clock::time_point start) {
    const auto test_scenes = scenes_of(0x74657374ULL, options_.harden.test_scenes);
    HardeningReport report;
    auto before = examined("undefended", undefended_, attacks, &Attacks::on_undefended, test_scenes);
    auto after = examined("hardened", hardened_->detector(), attacks, &Attacks::on_hardened, test_scenes);
    report.undefended = std::move(before.found);
    report.hardened = std::move(after.found);
    report.views = usable_test_.size();
    report.test_scenes = test_scenes.size();
    report.held_out = inputs_.frames.held_out;
    report.attacked_views = attacks ? options_.harden.epochs * usable_train_.size() : 0;
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    report.options = settings_json(options_);
    const std::string text = hardening_text(report);
    write_text(path("report.txt"), text);
    write_text(path("report.md"), hardening_markdown(report));
    auto list = list_of(report, std::move(before.views));
    write_text(path("views.csv"), views_csv(list));
    auto page = page_of(report, repeating_line("harden", report.options, settings_json(HardenOptions{})),
                        std::move(list), history_);
    remark_on_photographs(page);
    page.files = {"hardened.onnx", "report.md",    "report.txt",  "metrics.csv",
                  "views.csv",     "metrics.json", "history.csv", "manifest.json"};
    if (attacks) add_attacks(page, *attacks, std::move(before.attacked), std::move(after.attacked));
    write_text(path("report.html"), page_html(page));
    write_text(path("metrics.csv"), hardening_csv(report));
    record_outputs(options_.output, [&](const std::string& name) { return name == page.files.front(); });
    write_text(path("metrics.json"), report_text(hardening_json(report)));
    std::cout << text;
    remark("hardened detector: " + path("hardened.onnx"));
    remark("report: " + path("report.html"));
  }

  HardenOptions options_;
  Inputs inputs_;
  std::string resume_command_;
  const detect::Detector<float>& undefended_;
  std::unique_ptr<LearningDetector> hardened_;
  camouflage::ViewStore<float> train_, test_;
  std::vector<std::size_t> usable_train_, usable_test_;
  std::vector<HardeningStep> history_;
  std::string identity_;
};
}  // namespace tapestry::shell

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
