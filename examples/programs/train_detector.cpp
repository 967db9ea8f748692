// Trains a small YOLO-V3-shaped detector on procedural street scenes, drawn as they are needed.
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <tapestry/optim/adam.hpp>

#include "../scenes/labelled_scene.hpp"
#include "shell/formatted.hpp"
#include "shell/mesh_inputs.hpp"
#include "shell/problem_list.hpp"
#include "shell/program.hpp"
#include "shell/scene_training.hpp"
#include "shell/stop_signal.hpp"
#include "shell/trained_network.hpp"

namespace {
using namespace tapestry;
using namespace tapestry::shell;
using namespace tapestry::scenes;

struct Options {
  std::string cfg;
  std::string weights;
  std::string output;
  std::size_t fresh = 6, pool = 3000, size = 0;
  SceneTraining training{2400, 16, 200, 600};
};

void describe(CLI::App& app, Options& o) {
  app.add_option(
      "--cfg", o.cfg,
      "Darknet cfg file of the network; its heads need 3 classes (car, van, clutter); the bundled one when "
      "left out");
  app.add_option(
      "--weights,--resume", o.weights,
      "weights to start from, Darknet's or an .onnx model of convert_weights, whose own cfg is then taken "
      "for --cfg; random ones when left out");
  app.add_option(
      "--output", o.output,
      "file to write: Darknet weights, or, named .onnx, a model with its cfg, needed when the cfg is that of "
      "converted --weights; detector.weights or detector.onnx when left out");
  app.add_option("--fresh", o.fresh,
                 "pictures of a batch that are drawn anew; the others are repeated from the pool");
  app.add_option("--pool", o.pool, "pictures kept for repetition, about 200 kB each");
  app.add_option("--size", o.size, "width and height of the network's input, pixels; 0: the cfg's own");
  add_options(app, o.training, "P@0.5");
}

/// Sets the first weights, with objectness near 0.01, because most candidates of a picture are background.
void initialise(detect::DarknetModel<float>& model, std::uint64_t seed) {
  Random random(seed);
  model.initialise(random);
  const auto& layers = model.config().layers;
  auto head = model.heads().begin();
  for (std::size_t i = 1; i < layers.size(); ++i) {
    if (!detect::is_head(layers[i].kind)) continue;
    for (std::size_t anchor = 0; anchor < head->anchor_count(); ++anchor)
      model.parameters()[model.layout().layers[i - 1].bias + anchor * head->candidate_channel_count() +
                         head->objectness_channel().value()] = -4.6F;
    ++head;
  }
}

/// The model to train, and its cfg: a file's text, or the one within a converted detector.
struct Start {
  detect::DarknetModel<float> model;
  std::string cfg;
};

/// The model with random weights, or with the weights to start from, possibly those of a converted detector.
Start starting_model(const Options& options) {
  if (options.weights.empty()) {
    detect::DarknetModel<float> model(io::read_network_config(options.cfg), options.size, options.size);
    initialise(model, options.training.seed);
    return {std::move(model), io::read_text_file(options.cfg)};
  }
  const std::string cfg = trainable_cfg(options.cfg, options.weights);
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
    put_into_batch(scene, 0, {}, batch);
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

/// The model and the memory for a step, kept from step to step.
class Trainer {
 public:
  Trainer(detect::DarknetModel<float>& model, const Options& options)
      : model_(model),
        detector_(model.learning_detector()),
        weights_(detector_.weights()),
        options_(options),
        pool_(options.training.seed, model.input_width(), std::max(options.pool, options.training.batch)),
        adam_(weights_.size(), {options.training.learning_rate}),
        batch_(Extents<4>{options.training.batch, model.input_height(), model.input_width(), 3}) {}

  loss::YoloTrainingTerms step(std::size_t index) {
    pool_.fill(index, std::min(options_.fresh, options_.training.batch), batch_, truths_);
    tape_.clear();
    const auto scope = tape_.activate();
    const ArrayVariable<float, 4> images = batch_;
    const auto weights = tape_.input(weights_);
    const auto logits = detect::forward(detector_, images, weights, pass_);
    const auto terms = loss::yolo_training(detector_, logits, truths_);
    if (!std::isfinite(terms.total.value()))
      throw NumericError("train_detector: the loss of step " + std::to_string(index + 1) + " is not finite");
    tape_.reverse(terms.total);
    model_.update_running_statistics(*pass_, 0.03);
    adam_.set_learning_rate(
        warm_cosine_rate(options_.training.learning_rate, index, options_.training.steps, 200));
    adam_.step(weights_, weights.adjoint());
    model_.set_images_seen(model_.images_seen() + options_.training.batch);
    return {static_cast<double>(terms.box.value()), static_cast<double>(terms.objectness.value()),
            static_cast<double>(terms.classification.value()), static_cast<double>(terms.total.value())};
  }

  /// The model with the weights of the last step.
  [[nodiscard]] const detect::DarknetModel<float>& model() {
    detector_.set_weights(weights_);
    model_.take_weights(detector_);
    return model_;
  }

 private:
  detect::DarknetModel<float>& model_;
  detect::Detector<float> detector_;  ///< with the weights that are trained
  Array<float, 1> weights_;
  const Options& options_;
  ScenePool pool_;
  optim::Adam<float> adam_;
  Array<float, 4> batch_;
  loss::Truths truths_;
  std::shared_ptr<detect::Pass<float>> pass_ = std::make_shared<detect::Pass<float>>();
  Tape<float> tape_;
};

/// The command that continues: the remaining steps, from the saved weights.
std::string command_to_go_on(const CLI::App& app, const char* program, const Options& options,
                             std::size_t done) {
  std::vector<std::string> words{program, "--weights", options.output, "--steps",
                                 std::to_string(options.training.steps - done)};
  for (auto& word : given_options(app, {"weights", "steps"})) words.push_back(std::move(word));
  return shell_line(words);
}

int train(const CLI::App& app, const char* program, const Options& options) {
  Start start = starting_model(options);
  detect::DarknetModel<float>& model = start.model;
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
  Trainer trainer(model, options);
  const auto step = [&](std::size_t index) {
    const auto terms = trainer.step(index);
    return StepLoss{terms.total, formatted(" (box %.3f, objectness %.3f, class %.3f)", terms.box,
                                           terms.objectness, terms.classification)};
  };
  const std::size_t done = train_on_scenes(
      options.training, step, [&] { save_model(trainer.model(), start.cfg, options.output); },
      [&] { print_validation(trainer.model().detector(), sets); });
  if (done == options.training.steps) return 0;
  std::fprintf(stderr, "\nstopped; weights saved after step %zu. Go on with\n  %s\n", done,
               command_to_go_on(app, program, options, done).c_str());
  return StopSignal::exit_code();
}

void require_sound(const Options& o) {
  ProblemList list;
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
  require_sound(options);
  fill_in_files(options);
  return run_training(options.training, options.output, [&] { return train(app, program, options); });
}

}  // namespace

int main(int argc, char** argv) {
  auto app = command_line("Trains a small detector on procedural street scenes and writes Darknet weights.");
  Options options;
  describe(app, options);
  app.footer(
      "  train_detector --output own.weights\n"
      "  train_detector --steps 0 --weights own.weights");
  return run_program(app, argc, argv, [&] { return run(app, argv[0], options); });
}
