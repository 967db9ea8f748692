#pragma once
#include "dataset_training.hpp"
#include "fresh_detector.hpp"
#include "page.hpp"
#include "picture_sheet.hpp"
#include "report_page.hpp"
#include "run_options.hpp"
#include "step_log.hpp"

namespace tapestry::shell {
struct TuningOptions : RunOptions {
  StartSettings detector;
  DatasetTraining training;
};

inline Json settings_json(const TuningOptions& options) {
  return json_of_settings(options.detector, options.training);
}

/// Labelled pictures whose classes a detector knows.
struct MatchedDataset {
  evaluate::Dataset dataset;
  ClassMatching matching;
};

/// Moves a share of the pictures, drawn by the seed, into a data set of their own.
inline evaluate::Dataset held_out_of(evaluate::Dataset& dataset, const DatasetTraining& s) {
  auto& pictures = dataset.pictures;
  Random(s.seed).fork(0x68656C64ULL).shuffle(pictures);
  const auto share = std::llround(s.held_out * static_cast<double>(pictures.size()));
  const auto count = std::min<std::ptrdiff_t>(std::max(share, 1LL), std::ssize(pictures) - 1);
  evaluate::Dataset held{
      dataset.class_names, dataset.class_ids, {pictures.end() - count, pictures.end()}, {}};
  pictures.erase(pictures.end() - count, pictures.end());
  return held;
}

struct TuningInputs {
  std::optional<detect::Detector<float>> untuned{};  ///< none: random weights
  std::unique_ptr<LearningDetector> detector{};
  MatchedDataset training{}, validation{};
  std::vector<std::string> warnings{};
};

/// Reads labels and detector, or makes one with random weights for the classes of the labels.
inline TuningInputs read_tuning_inputs(TuningOptions& options) {
  const DatasetTraining& s = options.training;
  TuningInputs inputs;
  evaluate::Dataset dataset, held;
  if (options.detector.weights.empty()) {
    constexpr std::size_t most_classes = 10000;
    dataset = detail::read_dataset(s, most_classes);
    if (dataset.class_names.empty())
      throw Error(ErrorKind::usage, "--dataset-names is missing: " + s.dataset + " numbers its classes");
    if (options.detector.cfg.empty()) options.detector.cfg = BundledAssets().cfg();
    inputs.detector = fresh_detector(options.detector, dataset.class_names, s.seed);
  } else {
    fill_in_bundled(options.detector);
    inputs.untuned = load_detector(options.detector, inputs.warnings);
    require_trainable_heads("train_detector", *inputs.untuned, options.detector.weights);
    inputs.detector = learning_detector(*inputs.untuned, options.detector);
    dataset = detail::read_dataset(s, inputs.untuned->heads().front().classes);
  }
  const auto& detector = inputs.detector->detector();
  if (s.validation.empty()) {
    held = held_out_of(dataset, s);
  } else {
    held = detail::read_dataset({s.validation, "", s.class_names, {}}, detector.heads().front().classes);
    detail::rename_classes(s.classes, held, false);
  }
  for (const auto* warnings : {&dataset.warnings, &held.warnings})
    inputs.warnings.insert(inputs.warnings.end(), warnings->begin(), warnings->end());
  auto matching = match_classes(s.dataset, dataset, detector, true);
  auto of_held = match_classes(s.validation.empty() ? s.dataset : s.validation, held, detector, true);
  inputs.training = {std::move(dataset), std::move(matching)};
  inputs.validation = {std::move(held), std::move(of_held)};
  return inputs;
}

class TuningRun {
 public:
  TuningRun(TuningOptions options, TuningInputs inputs)
      : options_(std::move(options)),
        inputs_(std::move(inputs)),
        pictures_(inputs_.training.dataset, inputs_.training.matching, options_.keep_mib << 20U) {}

  /// \throws Stopped, after saving if a step was taken
  void run() {
    const auto start = Clock::now();
    summarise();
    open_folder();
    DatasetTrainer trainer(
        *inputs_.detector, options_.training, pictures_,
        [&](const detect::Detector<float>& tuned) { return precision_of(tuned).mean.ap50.value_or(0); });
    const std::string checkpoint = path("checkpoint.npz");
    if (options_.resume && is_there(checkpoint, ErrorKind::malformed)) trainer.restore(checkpoint, identity_);
    take_steps(
        trainer, options_.checkpoint_steps,
        [&] { trainer.save(checkpoint, identity_, path("detector.onnx")); },
        [&] { return trainer.progress_text(); });
    if (trainer.is_stale() && trainer.steps_taken() < trainer.step_count())
      remark("ended early: " + std::to_string(options_.training.patience) +
             " validations without a better AP50");
    trainer.take_best();
    report(trainer, start);
  }

 private:
  using Clock = std::chrono::steady_clock;

  [[nodiscard]] std::string path(const std::string& name) const { return options_.output + "/" + name; }
  [[nodiscard]] const detect::Detector<float>& detector() const { return inputs_.detector->detector(); }

  void summarise() {
    print_warnings(inputs_.warnings);
    const DatasetTraining& s = options_.training;
    const DatasetPictures held(inputs_.validation.dataset, inputs_.validation.matching, 0);
    words_ = {
        "learns from " + s.dataset + ": " + pictures_.summary(),
        (s.validation.empty() ? formatted("held out of it, a share of %g drawn by the seed: ", s.held_out)
                              : "validated on " + s.validation + ": ") +
            held.summary()};
    std::vector<std::string> forgotten;
    const auto& of_detector = inputs_.training.matching.of_detector;
    for (std::size_t i = 0; i < of_detector.size(); ++i)
      if (!of_detector[i]) forgotten.push_back(detector().names()[i]);
    if (!forgotten.empty())
      words_.push_back("taken to show none of the detector's other classes, which it will forget: " +
                       listed(forgotten));
    for (const auto& line : words_) remark(line);
    for (const DatasetPictures* part : {&std::as_const(pictures_), &held})
      if (part->is_empty())
        throw file_mismatch({s.validation.empty() || part != &held ? s.dataset : s.validation, "",
                             "no objects to learn from or to validate on", "labels", "none"});
  }

  void open_folder() {
    identity_ = open_run(options_, "train_detector", settings_json(options_), options_.training.seed, true,
                         "detector.onnx");
    std::string names;
    for (const auto& name : detector().names()) names += name + "\n";
    if (!names.empty()) write_text(path("detector.names"), names);
    if (!options_.detector.detector.empty() && is_there(options_.detector.detector, ErrorKind::malformed))
      write_text(path("detector.json"), io::read_text_file(options_.detector.detector));
  }

  /// Precision on the held-out pictures. \throws Stopped
  [[nodiscard]] evaluate::AveragePrecision precision_of(const detect::Detector<float>& detector) const {
    DetectorSettings settings = options_.detector;
    settings.confidence = dataset_confidence;
    const auto& [dataset, matching] = inputs_.validation;
    const auto found = detail::all_findings(dataset, DatasetSettings().most_detections, settings, detector,
                                            matching, [](const auto&) { StopSignal::throw_if_arrived(); });
    return evaluate::average_precision(found.truths, found.detections, matching.names.size());
  }

  /// Some held-out pictures with their detections, at the left those of the untuned detector if there is one.
  [[nodiscard]] Bitmap sheet() const {
    const auto& pictures = inputs_.validation.dataset.pictures;
    const std::size_t shown = std::min<std::size_t>(6, pictures.size());
    PictureSheet sheet(2 * shown, inputs_.untuned ? 2 : 1);
    detect::Pass<float> pass;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      const std::string& file = pictures[i].path;
      if (!is_shown(i, shown, pictures.size())) continue;
      const auto picture = io::read_image(file);
      for (const auto* by : {inputs_.untuned ? &*inputs_.untuned : nullptr, &detector()})
        if (by != nullptr)
          sheet.add(io::path_of(file).filename().string(),
                    fitted_within(marked(picture, detections_in(file, picture, options_.detector, *by, pass),
                                         by->names()),
                                  sheet.side()));
    }
    return sheet.bitmap();
  }

  void report(const DatasetTrainer& trainer, Clock::time_point start) {
    const Json options = settings_json(options_);
    ReportPage page{"Training a detector",
                    repeating_line("train_detector", options, settings_json(TuningOptions{})),
                    options_.training.seed};
    words_.push_back("the best AP50 on the held-out pictures is that after step " +
                     std::to_string(trainer.best_step()) + " of " + std::to_string(trainer.steps_taken()) +
                     "; being chosen by it, it is a little too high");
    remark(words_.back());
    for (const auto& line : words_) page.findings += "<p>" + escaped(line) + ".</p>\n";
    Json metrics{{"best_step", trainer.best_step()},
                 {"steps", trainer.steps_taken()},
                 {"ap50_by_validation", trainer.scores()}};
    const auto& names = inputs_.validation.matching.names;
    const auto add = [&](const char* name, const detect::Detector<float>& measured) {
      const auto precision = precision_of(measured);
      const std::string text =
          std::string(name) + ", on the held-out pictures\n" + precision_text(precision, names);
      std::cout << text;
      page.findings += "<pre>" + escaped(text) + "</pre>\n";
      metrics[name] = precision_json(precision, names);
    };
    if (inputs_.untuned) add("untuned", *inputs_.untuned);
    add("tuned", detector());
    page.findings +=
        std::string("<h2>Held-out pictures") + (inputs_.untuned ? ", untuned left and tuned right" : "") +
        "</h2>\n<img class=\"sheet\" alt=\"what is found in them\" src=\"data:image/jpeg;base64," +
        base64(io::jpeg_file("report.html", sheet(), 85)) + "\">\n";
    page.curves = curves_of(trainer.history());
    page.curves.insert(page.curves.begin(), Curve{"AP50", trainer.scores(), "validation"});
    page.files = {"detector.onnx", "history.csv", "metrics.json", "manifest.json"};
    page.options = options;
    page.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    metrics.update(
        Json{{"seconds", page.seconds}, {"computed_by", computed_by_json()}, {"options", options}});
    write_text(path("history.csv"), history_csv(trainer.history()));
    write_text(path("report.html"), page_html(page));
    record_outputs(options_.output, [](const std::string& name) { return name == "detector.onnx"; });
    write_text(path("metrics.json"), report_text(metrics));
    remark("detector: " + path("detector.onnx"));
    remark("report: " + path("report.html"));
  }

  TuningOptions options_;
  TuningInputs inputs_;
  DatasetPictures pictures_;
  std::vector<std::string> words_{};  ///< for the terminal and the page
  std::string identity_{};
};

/// \param app  has the options, and those of drawn scenes, which are refused
/// \returns the exit code
inline int tune(const CLI::App& app, const char* program, TuningOptions options) {
  ProblemList problems;
  detail::require_known_options(
      app,
      {"--dataset", "--images", "--dataset-names", "--classes", "--validation", "--held-out", "--patience",
       "--steps", "--batch", "--learning-rate", "--validate-every", "--save-every", "--seed", "--threads",
       "--output", "--resume", "--accept-other-build"},
      problems);
  require_sound_run(options, problems);
  if (!options.resume) {
    require_sound(options.detector, problems);
    require_sound(options.training, problems);
  }
  problems.throw_first();
  take_over_run(options, "train_detector");
  const StopSignal stop_signal;
  io::InputLedger ledger;
  ledger.leave_out(options.output);
  if (options.resume) adopt_run_settings(app, options, "train_detector", options.detector, options.training);
  require_free_folder(options);
  auto inputs = read_tuning_inputs(options);
  const auto folder = claim_folder(options, "runs/train", ledger);
  const std::string output = options.output,
                    resume = resume_line(app, program, options, settings_json(options));
  return run_resumable(
      output, resume, [&] { TuningRun(std::move(options), std::move(inputs)).run(); }, [] { return ""; });
}
}  // namespace tapestry::shell
