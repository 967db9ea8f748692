// Trains a detector: any with raw heads on labelled pictures, or a small YOLO-V3-shaped one on procedural
// street scenes, drawn as they are needed.

#include "shell/dataset_run.hpp"
#include "shell/scene_training.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;
using namespace tapestry::scenes;

struct Options {
  TuningOptions tuning;  ///< over own pictures; those of both that name files are there
  std::string &cfg = tuning.detector.cfg, &weights = tuning.detector.weights, &output = tuning.output;
  std::size_t& size = tuning.detector.size;
  std::size_t fresh = 6, pool = 3000;
  SceneTraining training{2400, 16, 200, 600};
};

void describe(CLI::App& app, Options& o) {
  add_options(app, o.tuning.detector);
  app.get_option("--cfg")->description(
      "Darknet cfg file of the network; the bundled one when left out. Its heads need 3 classes (car, van, "
      "clutter) for drawn scenes, and get those of own pictures for random weights");
  app.get_option("--weights")
      ->description(
          "weights to start from, Darknet's or an .onnx model; random ones when left out. For drawn scenes "
          "one of convert_weights, whose own cfg is then taken for --cfg");
  add_options(app, o.tuning.training, {"steps", "batch", "learning-rate", "validate-every", "seed"});
  add_resume_options(app, o.tuning);
  app.option_defaults()->group("Training");
  app.add_option(
      "--output", o.output,
      "file to write: Darknet weights, or, named .onnx, a model with its cfg, needed when the cfg is that of "
      "converted --weights; detector.weights or detector.onnx when left out. Over own pictures the run "
      "folder; runs/train-001, -002, ... when left out");
  app.add_option("--fresh", o.fresh,
                 "pictures of a batch that are drawn anew; the others are repeated from the pool");
  app.add_option("--pool", o.pool, "pictures kept for repetition, about 200 kB each");
  add_options(app, o.training, "P@0.5");
}

/// The model with random weights, or with the weights to start from, possibly those of a converted detector;
/// and its cfg: a file's text, or the one within a converted detector.
std::pair<detect::DarknetModel<float>, std::string> starting_model(const Options& options) {
  if (options.weights.empty()) {
    detect::DarknetModel<float> model(io::read_network_config(options.cfg), options.size, options.size);
    initialise(model, options.training.seed);
    return {std::move(model), io::read_text_file(options.cfg)};
  }
  const std::string cfg = trainable_cfg(options.cfg, options.weights);
  if (io::is_onnx(options.weights) &&
      io::parse_detector_metadata(io::read_onnx(options.weights).metadata, options.weights).is_folded)
    throw file_mismatch({options.weights, "", "batch normalisation is folded into the weights",
                         "a detector to train, as convert_weights writes without --fold"});
  auto loaded = io::read_darknet_model<float>(options.cfg, options.weights, options.size, options.size);
  print_warnings(loaded.warnings);
  return {std::move(loaded.model), cfg};
}

using HeldOutScenes = std::vector<HeldOut<LabelledScene>>;

struct Validation {
  evaluate::DetectionRate rate;
  double mean_confidence = 0;  ///< of the boxes that match the main car
  double false_alarms = 0;     ///< boxes a picture that match no car
};

Validation validate(const detect::Detector<float>& detector, const std::vector<LabelledScene>& scenes) {
  const std::size_t size = detector.input_width();
  std::vector<bool> found;
  detect::Pass<float> pass;
  Array<float, 4> batch(Extents<4>{1, size, size, 3});
  Validation result;
  for (const LabelledScene& scene : scenes) {
    put_into_batch(scene.colours, 0, {}, batch);
    detector.forward(batch, pass);
    detect::require_finite_logits(pass.logits, "validation scene " + std::to_string(found.size()));
    const auto detections = detector.detections(pass.logits);
    found.push_back(evaluate::is_found(detections, scene.main));
    for (const auto& detection : detections) {
      if (detection.class_index != class_car) continue;
      if (detect::iou(detection.box, scene.main.box) >= 0.5) {
        result.mean_confidence += detection.confidence;
        continue;
      }
      const auto meets = [&](const loss::Target& truth) {
        return detect::iou(truth.box, detection.box) >= 0.3;
      };
      if (std::none_of(scene.truths.begin(), scene.truths.end(), meets)) ++result.false_alarms;
    }
  }
  result.rate = evaluate::detection_rate(found);
  result.mean_confidence /= std::max(1.0, static_cast<double>(result.rate.detected));
  result.false_alarms /= std::max(1.0, static_cast<double>(scenes.size()));
  return result;
}

void print_validation(const detect::Detector<float>& detector, const HeldOutScenes& sets) {
  for (const auto& set : sets) {
    const Validation result = validate(detector, set.scenes);
    std::printf(
        "  %-12s P@0.5 %5.1f %% (%zu of %zu, 95 %% interval %.1f to %.1f), mean confidence %.2f, false "
        "alarms a picture %.2f\n",
        set.name.c_str(), 100 * result.rate.p_at_50, result.rate.detected, result.rate.views,
        100 * result.rate.interval[0], 100 * result.rate.interval[1], result.mean_confidence,
        result.false_alarms);
  }
  std::fflush(stdout);
}

/// The command that continues: the remaining steps, from the saved weights.
std::string command_to_go_on(const CLI::App& app, const char* program, const Options& options,
                             std::size_t done) {
  std::vector<std::string> words{program, "--weights", options.output, "--steps",
                                 std::to_string(options.training.steps - done)};
  for (auto& word : given_options(app, {"weights", "steps"})) words.push_back(std::move(word));
  return shell_line(words);
}

int train(const CLI::App& app, const char* program, const Options& options) {
  auto [model, cfg] = starting_model(options);
  const std::string& cfg_name = model.config().name;
  if (model.input_height() != model.input_width())
    throw Error(ErrorKind::mismatch, cfg_name + ": the input must be square, or --size given");
  loss::require_raw_logits("train_detector", model.heads());
  const auto decode = detect::decode_family_of(model.config());
  if (decode != detect::DecodeFamily::darknet && !io::is_onnx(options.output))
    throw Error(ErrorKind::usage, "--output " + options.output + " would lose the decode family " +
                                      std::string(detect::name_of(decode)) + "; name it .onnx");
  for (const auto& head : model.heads())
    if (head.classes != 3) throw Error(ErrorKind::mismatch, cfg_name + ": heads must have 3 classes");

  const std::size_t size = model.input_width();
  const HeldOutScenes sets = held_out_sets(
      0x5EED0FF5E7ULL, options.training.validate,
      [=](const Random& random, const SceneOptions& scene) { return draw_labelled(random, scene, size); });
  const SceneTraining& t = options.training;
  ScenePool pool(t.seed, size, std::max(options.pool, t.batch));
  LearningModel learning(std::move(model), cfg, {}, {}, true);
  Learner learner(learning, "train_detector");
  Array<float, 4> batch(Extents<4>{t.batch, size, size, 3});
  loss::Truths truths;
  const auto step = [&](std::size_t index) {
    pool.fill(index, std::min(options.fresh, t.batch), batch, truths);
    const double rate = warm_cosine_rate(t.learning_rate, index, t.steps, 200);
    const LossTerms terms = learner.step(batch, truths, rate, index + 1);
    learning.set_pictures_seen((index + 1) * t.batch);
    return StepLoss{terms.total, formatted(" (box %.3f, objectness %.3f, class %.3f)", terms.box,
                                           terms.objectness, terms.classification)};
  };
  const std::size_t done = train_on_scenes(
      t, step, [&] { learning.save(options.output); }, [&] { print_validation(learning.detector(), sets); });
  if (done == options.training.steps) return 0;
  std::fprintf(stderr, "\nstopped; weights saved after step %zu. Go on with\n  %s\n", done,
               command_to_go_on(app, program, options, done).c_str());
  return StopSignal::exit_code();
}

int run_tuning(const CLI::App& app, const char* program, const Options& o) {
  TuningOptions tuning = o.tuning;
  DatasetTraining& s = tuning.training;
  const auto take = [&](const char* option, auto& value, const auto& given) {
    if (app.get_option(option)->count() > 0) value = given;
  };
  ProblemList list;
  require_sound(o.training, list);
  list.throw_first();
  take("--steps", s.steps, o.training.steps);
  take("--batch", s.batch, o.training.batch);
  take("--validate-every", s.validate_every, o.training.validate_every);
  take("--seed", s.seed, o.training.seed);
  s.learning_rate = tuning.detector.weights.empty() ? 0.002 : 0.0005;
  take("--learning-rate", s.learning_rate, o.training.learning_rate);
  tuning.checkpoint_steps = o.training.save_every;
  return tune(app, program, std::move(tuning));
}

/// \throws Error (usage) for options that do not go together, or have no part in drawn scenes
void require_sound(const CLI::App& app, const Options& o) {
  ProblemList list;
  for (const auto* option : app.get_options([](const CLI::Option* one) { return one->count() > 0; }))
    list.require(option->get_group() != DatasetTraining::group && option->get_group() != "Run" &&
                     (option->get_group() != DetectorSettings::group || option->check_lname("cfg") ||
                      option->check_lname("weights") || option->check_lname("size")),
                 option->get_name() + " needs --dataset");
  require_sound(o.training, list);
  list.require(o.size <= 4096, "--size must be at most 4096 pixels");
  list.throw_first();
}

/// Fills in the files that were left out. A converted detector contains its cfg, which is passed on to the
/// files written.
void fill_in_files(Options& o) {
  const bool has_cfg = !o.cfg.empty() || o.weights.empty() || !io::is_onnx(o.weights);
  if (o.cfg.empty() && has_cfg) o.cfg = BundledAssets{}.cfg();
  if (o.output.empty()) o.output = has_cfg ? "detector.weights" : "detector.onnx";
  if (!has_cfg && o.training.steps > 0 && !io::is_onnx(o.output))
    throw Error(ErrorKind::usage, "--output " + o.output + " would lose the cfg, which is only within " +
                                      o.weights + "; name it .onnx, or give --cfg");
}

int run(const CLI::App& app, const char* program, Options& options) {
  if (options.tuning.resume || !options.tuning.training.dataset.empty())
    return run_tuning(app, program, options);
  require_sound(app, options);
  fill_in_files(options);
  return run_training(options.training, options.output, [&] { return train(app, program, options); });
}
}  // namespace

int main(int argc, char** argv) {
  auto app = command_line(
      "Trains a detector on labelled pictures (--dataset), and writes it as it was best on held-out ones, "
      "with a report; or trains a small one on procedural street scenes, and writes Darknet weights.");
  Options options;
  describe(app, options);
  app.footer(
      "  train_detector --dataset labels.json --weights net.onnx --classes vehicle=car\n"
      "  train_detector --resume --output runs/train-001\n"
      "  train_detector --output own.weights\n"
      "  train_detector --steps 0 --weights own.weights");
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
