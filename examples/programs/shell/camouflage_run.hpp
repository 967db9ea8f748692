#pragma once
#include "measured_controls.hpp"
#include "memory_forecast.hpp"
#include "photo_light_report.hpp"
#include "reshaped_views.hpp"
#include "run_page.hpp"
#include "side_by_side.hpp"
#include "step_log.hpp"
#include "texture_training.hpp"
#include "validation.hpp"

namespace tapestry::shell {
/// One run in its folder. Under mpirun the views of every step are divided among the ranks; the first rank
/// writes.
class CamouflageRun {
 public:
  CamouflageRun(CamouflageOptions options, Inputs inputs, std::string resume_command)
      : options_(std::move(options)),
        inputs_(std::move(inputs)),
        resume_command_(std::move(resume_command)),
        train_(inputs_.car.painted, store_settings(), train_loaders(inputs_.frames, inputs_.mask)),
        test_(inputs_.car.painted, store_settings(),
              frame_loaders(inputs_.frames.test, inputs_.mask, inputs_.frames.posed)),
        objective_(
            inputs_.detector, objective_options(options_.optimisation, inputs_.class_index),
            options_.optimisation.smooth_over == "texture"
                ? std::make_shared<const Array<float, 2>>(raster::used_texels<float>(inputs_.car.painted))
                : nullptr),  // steps in pictures
        trial_(inputs_.detector, {loss::AdversarialLoss::max_score, {}, 0, 0, inputs_.class_index}) {
    for (auto* objective : {&objective_, &trial_}) {
      for (const FurtherDetector& member : inputs_.ensemble)
        objective->join(member.detector, member.class_index);
      objective->follow(chosen_method(options_.optimisation, inputs_.car.painted, options_.scene.mesh));
    }
    objective_.keep_layers(options_.keep_layers_mib << 20U);
    if (inputs_.palette)
      objective_.print_by(inputs_.palette, texels_to_print(inputs_.car.painted, objective_.method()));
  }

  /// \returns the exit code
  int execute() {
    const auto saved = [&] {
      return saved_steps_ > 0 ? "; saved after step " + std::to_string(saved_steps_) : std::string();
    };
    return run_resumable(
        options_.output, resume_command_, [&] { run(); }, saved);
  }

 private:
  /// Mean difference of a colour channel beyond which an export is not the run's paint: the rounding to bytes
  /// and the lookup in charts differ by less.
  static constexpr double most_export_difference = 0.02;

  using Clock = std::chrono::steady_clock;

  void run() {
    const auto start = Clock::now();
    print_warnings(inputs_.warnings);
    inputs_.warnings.clear();
    std::optional<ScopedWorkTimer> work(preparing_);
    const std::size_t further = inputs_.frames.held_out ? test_.size() : 0;
    if (ranks_.is_first())
      MemoryForecast(options_, inputs_.car.painted).complete(train_, objective_, further);
    auto usable_train = prepared(train_);
    auto& test = inputs_.frames.held_out ? test_ : train_;
    const auto usable_test = inputs_.frames.held_out ? prepared(test) : usable_train;  // all of them
    print_warnings(inputs_.warnings);
    if (usable_train.empty() || usable_test.empty()) throw no_car_shown(options_.scene.frames, inputs_.car);
    validation_.emplace(usable_train, options_.optimisation.validation, path("best.npz"));
    auto& epochs = options_.optimisation.epochs;
    if (epochs == 0) epochs = default_epochs(usable_train.size(), inputs_.frames.drawn > 0);
    auto start_parameter = camouflage::first_parameter(
        objective_.method(),
        start_texture(options_.optimisation, inputs_.car.painted, inputs_.car.description));
    open_folder();
    work.reset();

    std::optional<camouflage::Training<float>> training(std::in_place, objective_, train_, usable_train,
                                                        std::move(start_parameter), training_options(epochs));
    if (options_.resume) restore(*training);
    if (ranks_.count() > 1)
      training->share({ranks_.count(), ranks_.index(),
                       [&](const std::vector<double>& own) { return ranks_.gathered(own); }});
    optimise(*training);
    if (!ranks_.is_first()) return;
    work.emplace(reporting_);
    const auto parameter = validation_->chosen(*training);
    const auto history = training->history();
    training.reset();  // gives back what measuring does not need
    if (inputs_.frames.held_out) train_.release();
    platform::PagePool::shared().release();
    report(parameter, history, test, usable_test, start);
    work.reset();
    if (options_.profile) print_stretches();
  }

  void print_stretches() {
    const auto& times = objective_.times();
    print_work({{"views prepared", preparing_},
                {"paint", times.paint},
                {"views", times.views},
                {"paint's pullback", times.pullback},
                {"Adam", times.adam},
                {"measured, written", reporting_}});
  }

  [[nodiscard]] camouflage::TrainingOptions training_options(std::size_t epochs) const {
    camouflage::TrainingOptions options;
    options.epochs = objective_.method().is_optimised ? epochs : 0;
    options.batch = options_.optimisation.batch;
    options.worst_share = options_.optimisation.worst_views;
    options.seed = options_.optimisation.seed;
    options.adam.learning_rate = options_.optimisation.learning_rate;
    options.conditions = image::conditions_by_names(options_.optimisation.conditions);
    return options;
  }

  [[nodiscard]] camouflage::ViewStore<float>::Settings store_settings() const {
    auto settings = shell::store_settings(inputs_, options_.scene, options_.detector, options_.keep_mib);
    settings.redrawn = camouflage::method_row<float>(options_.optimisation.method).traits.moves_shape;
    return settings;
  }

  [[nodiscard]] FrameLoaders test_loaders() const {
    return inputs_.frames.held_out ? frame_loaders(inputs_.frames.test, inputs_.mask, inputs_.frames.posed)
                                   : train_loaders(inputs_.frames, inputs_.mask);
  }
  [[nodiscard]] std::string path(const char* name) const { return options_.output + "/" + name; }

  /// Whether a file of the folder is a result that the same options repeat to the bit.
  static bool is_output(const std::string& name) {
    constexpr std::string_view stems[] = {"texture", "matched_noise", "shuffled", "before",  "after",
                                          "result",  "side_by_side",  "views",    "history", "light"};
    return name.starts_with("painted") || name == "metrics.csv" ||
           std::ranges::count(stems, std::string_view(name).substr(0, name.find('.'))) > 0;
  }

  /// The views that show the car. All ranks stop together.
  /// \throws Stopped when a signal has arrived at a rank
  std::vector<std::size_t> prepared(camouflage::ViewStore<float>& store) {
    std::vector<std::size_t> usable;
    bool stopped = false;
    try {
      usable = views_with_car(store, options_.scene.mesh, inputs_.car, inputs_.warnings);
    } catch (const Stopped&) {
      stopped = true;
    }
    if (ranks_.any(stopped)) throw Stopped{};
    return usable;
  }

  /// Writes the manifest to a new folder, once every view has been read; checks that a folder to resume holds
  /// one that agrees, and that all ranks have read the same.
  void open_folder() {
    Json manifest = make_manifest("camouflage", settings_json(options_), options_.optimisation.seed,
                                  inputs_.frames.held_out);
    settings_ = identity_text(manifest);
    ranks_.require_same("options and inputs", io::sha256(settings_));
    for (const auto& fact : facts_of_bits) ranks_.require_same(fact, io::sha256(manifest[fact].dump()));
    if (options_.resume) require_same_inputs(manifest, options_.output);
    if (ranks_.is_first()) open_manifest(std::move(manifest), options_.output, options_.resume);
  }

  void restore(camouflage::Training<float>& training) {
    restore_training(path("checkpoint.npz"), settings_, training);
    validation_->restore(training);
    saved_steps_ = training.steps_taken();
  }

  /// All ranks wait here, so that none ends while the first one writes.
  void save(const camouflage::Training<float>& training) {
    if (ranks_.is_first()) write(training);
    saved_steps_ = training.steps_taken();
    (void)ranks_.any(false);
  }

  void write(const camouflage::Training<float>& training) const {
    camouflage::write_checkpoint(path("checkpoint.npz"), training.state(), settings_);
    write_text(path("history.csv"), history_csv(training.history()));
  }

  /// The same at all ranks.
  [[nodiscard]] bool is_stale(const camouflage::Training<float>& training) {
    const std::size_t patience = options_.optimisation.patience;
    return patience > 0 && ranks_.any(ranks_.is_first() && validation_->is_stale(training, patience));
  }

  /// \throws Stopped after saving, when a signal arrives at a rank
  void optimise(camouflage::Training<float>& training) {
    ProgressLine progress;
    const auto start = Clock::now();
    std::size_t images = 0;
    const std::uint64_t first = training.steps_taken();
    bool ends = training.finished() || is_stale(training);
    while (!ends) {
      try {
        images += training.step();
      } catch (const NumericError&) {
        save(training);  // the state before the step is the last good one
        throw;
      }
      if (ranks_.is_first()) validation_->follow(training, trial_, train_);
      const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
      ends = training.finished() || is_stale(training);
      progress.show(step_text(training, first, images, seconds), ends);
      if (ranks_.any(StopSignal::arrived())) {
        save(training);
        throw Stopped{};
      }
      if (training.steps_taken() % options_.checkpoint_steps == 0) save(training);
    }
    save(training);
    const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
    if (!options_.profile || training.steps_taken() == first) return;
    print_profile(objective_.times(), training.steps_taken() - first, seconds);
    for (std::size_t member = 0; member <= inputs_.ensemble.size(); ++member)
      print_kept_layers(objective_.kept_layers(member));
  }

  void report(const Array<float, 2>& parameter, const std::vector<camouflage::ObjectiveTerms>& history,
              camouflage::ViewStore<float>& test, std::vector<std::size_t> usable, Clock::time_point start) {
    const auto& method = objective_.method();
    const camouflage::Paint<float> paint{camouflage::method_colours(method, parameter),
                                         camouflage::painted_texels(method)};
    evaluate::SurveyedTextures textures{
        camouflage::without_paint(camouflage::own_colours<float>(inputs_.car.painted)), paint,
        measured_controls(options_.survey.controls, inputs_.car.painted, paint, options_.optimisation.seed)};
    Array<float, 2> offsets;
    std::optional<ReshapedViews> reshaped;
    if (const auto& shape = method.shape) {
      offsets = camouflage::shape_offsets(*shape, parameter);
      reshaped.emplace(inputs_.car.painted, offsets, store_settings(), test_loaders());
      usable = reshaped->also_with_car(usable);
      if (usable.empty())
        throw Error(ErrorKind::mismatch, options_.scene.frames + ": no frame shows the car in its new shape");
      textures.reshaped = &reshaped->store();
    }
    evaluate::Meter meter(inputs_.detector, inputs_.class_index,
                          {options_.detector.confidence, options_.detector.nms});
    std::vector<MarkedPicture> before, after;
    SurveyWatch watch(meter, textures.pictures_a_view() * usable.size(),
                      std::max(inputs_.detector.input_height(), inputs_.detector.input_width()));
    watch.collect("clean", before, usable.size());
    watch.collect("adversarial", after, usable.size());
    const SideBySide side_by_side(watch, usable.size());
    RunReport report;
    report.survey = evaluate::survey(meter, test, usable, textures, watch);
    platform::PagePool::shared().release();
    write_paint_files(parameter, paint, offsets, textures.controls);
    const auto& car = reshaped ? reshaped->car() : inputs_.car.painted;
    write_painted(car, paint.colours);
    report.exported =
        export_difference_of(reshaped ? reshaped->store() : test, car, usable.front(), paint.colours);
    if (inputs_.photo_light)
      write_text(path("light.json"), report_text(PhotoLightReport(test, usable, inputs_.car.painted).json()));
    write_sheets(before, after);
    report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
    report.history = history;
    add_facts(textures, report);
    io::write_image(path("side_by_side.png"), side_by_side.sheet(watch.views()));
    write_report(report, list_of(report, watch.views()), textures, side_by_side.pictures());
  }

  void add_facts(const evaluate::SurveyedTextures& textures, RunReport& report) const {
    report.held_out = inputs_.frames.held_out;
    report.noise_in_place = evaluate::noise_in_place(textures.controls);
    report.options = settings_json(options_);
    report.validation = validation_->json();
    if (const auto text = validation_->text(); !text.empty()) remark(text);
  }

  /// Writes the texture, and the matched controls as atlases beside it.
  /// \param offsets  of the car's positions; empty if they stay
  void write_paint_files(const Array<float, 2>& parameter, const camouflage::Paint<float>& paint,
                         const Array<float, 2>& offsets,
                         const std::vector<evaluate::Control>& controls) const {
    const auto& car = inputs_.car;
    camouflage::write_paint(path("texture.npz"), parameter, paint, offsets, exact_text(car.description));
    const auto write = [&](const char* control, const char* name) {
      for (const auto& [control_name, control_paint, share] : controls)
        if (control_name == control)
          write_described_texture(path(name), camouflage::atlas_of<float>(car.painted, control_paint.colours),
                                  exported_description(car.painted, car.description));
    };
    write(evaluate::matched_noise_name, "matched_noise.png");
    write(evaluate::shuffled_patches_name, "shuffled.png");
  }

  void write_sheets(const std::vector<MarkedPicture>& before, const std::vector<MarkedPicture>& after) const {
    const std::size_t columns = sheet_columns(before.size());
    parallel_for(3, [&](std::size_t sheet) {
      StopSignal::throw_if_arrived();  // a large sheet takes seconds to compress
      if (sheet == 0) io::write_image(path("before.png"), contact_sheet(before, columns));
      if (sheet == 1) io::write_image(path("after.png"), contact_sheet(after, columns));
      if (sheet == 2) io::write_image(path("result.png"), comparison(before, after, 6));
    });
  }

  void write_report(const RunReport& report, ViewList list, const evaluate::SurveyedTextures& textures,
                    ViewPictures pictures) const {
    write_text(path("views.csv"), views_csv(list));
    auto page = page_of(report, "Camouflage run",
                        repeating_line("camouflage", report.options, settings_json(CamouflageOptions{})),
                        std::move(list));
    remark_on_photographs(page);
    page.pictures = std::move(pictures);
    add_paint(page, textures);
    write_text(path("report.html"), page_html(page));
    write_text(path("metrics.csv"), metrics_csv(report));
    record_outputs(options_.output, is_output);
    write_text(path("metrics.json"), report_text(metrics_json(report)));
    std::cout << summary_text(report);
    remark("report: " + path("report.html"));
  }

  void add_paint(ReportPage& page, const evaluate::SurveyedTextures& textures) const {
    const auto atlas = [&](const std::string& words, const camouflage::Paint<float>& paint) {
      page.atlases.emplace_back(
          words, image::to_bytes(camouflage::atlas_of<float>(inputs_.car.painted, paint.colours)));
    };
    atlas("optimised", *textures.adversarial);
    for (const auto& [name, paint, share] : textures.controls)
      if (name == evaluate::matched_noise_name || name == evaluate::shuffled_patches_name) atlas(name, paint);
    page.glb = io::read_text_file(path("painted.glb"));
    page.files = {"painted.glb",      "painted.obj",  "texture.npz", "texture.png",  "texture.json",
                  "side_by_side.png", "result.png",   "before.png",  "after.png",    "metrics.csv",
                  "views.csv",        "metrics.json", "history.csv", "manifest.json"};
  }

  /// \param car in its final shape
  void write_painted(const raster::PaintedMesh& car, const Array<float, 2>& colours) const {
    const auto atlas = camouflage::atlas_of<float>(car, colours);
    write_described_texture(path("texture.png"), atlas, exported_description(car, inputs_.car.description));
    io::write_painted_obj(path("painted.obj"), car, atlas);
    io::write_painted_glb(path("painted.glb"), car, atlas);
  }

  /// Draws a view with the car of the written files, and compares it with the run's own picture.
  /// \param store    views of the car in its final shape
  /// \param own_car  that car
  [[nodiscard]] PictureDifference export_difference_of(const camouflage::ViewStore<float>& store,
                                                       const raster::PaintedMesh& own_car, std::size_t index,
                                                       const Array<float, 2>& colours) const {
    const auto& settings = store.settings();
    constexpr bool keeps_photograph = false;  // unpainted faces were exported, too
    const io::Frame frame = test_loaders()[index]();
    const auto view_of = [&](const raster::PaintedMesh& car) {
      return camouflage::make_view<float>(frame, car, settings.height, settings.width,
                                          settings.samples_per_axis, settings.fit, settings.photo_light,
                                          keeps_photograph);
    };
    const auto own = view_of(own_car);
    const auto [car, texels] = read_exported_car(path("painted.obj"), inputs_.car.painted);
    const auto difference = difference_over_car(camouflage::picture_of(own, colours),
                                                camouflage::picture_of(view_of(car), texels), own);
    if (difference.mean > most_export_difference)
      print_warnings({path("painted.obj") + ": drawn again, the exported paint differs from the run's by " +
                      decimal_text(difference.mean) + " of 1 on average"});
    return difference;
  }

  const Ranks& ranks_ = Ranks::all();
  WorkTime preparing_{}, reporting_{};
  CamouflageOptions options_;
  Inputs inputs_;
  std::string resume_command_;
  camouflage::ViewStore<float> train_;
  camouflage::ViewStore<float> test_;
  camouflage::Objective<float> objective_;
  camouflage::Objective<float> trial_;  ///< see Validation
  std::optional<Validation> validation_{};
  std::string settings_;
  std::uint64_t saved_steps_ = 0;
};
}  // namespace tapestry::shell
