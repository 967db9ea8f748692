#pragma once
#include "hardening_state.hpp"
#include "run_options.hpp"

namespace tapestry::shell {
/// Settings of the hardening, and of the paints that are optimised against the detector.
struct HardenSettings {
  static constexpr const char* group = "Hardening";
  std::string paint = "optimised";
  std::string attacks = "measured";
  std::size_t rounds = 16;
  std::size_t attack_steps = 100;
  std::size_t steps = 120;
  std::size_t pictures = 16;
  double painted = 0.5;
  double weight_rate = 0.001;
  std::size_t clean_scenes = 600;
  std::size_t test_scenes = 200;
  std::size_t epochs = 0;
  std::string loss = "max_score";
  double smoothness = 1;
  std::size_t batch = 8;
  double learning_rate = 0.1;
  std::uint64_t seed = 1;
};

template <class Visit>
void visit_settings(HardenSettings& s, Visit visit) {
  visit("paint", s.paint,
        "what the painted pictures show: {optimised}, paints against the detector itself and noise made from "
        "them; {none}, the car in ordinary colours: fine-tuning without an attack, the control of hardening, "
        "and a way to a sound detector");
  visit(
      "attacks", s.attacks,
      "{measured}: both detectors under a paint made for the undefended one and a fresh one on each; {none}: "
      "only without attacks");
  visit("rounds", s.rounds, "rounds, each with a paint of its own", Numbers{1, 1000});
  visit("attack-steps", s.attack_steps,
        "steps of a round's paint before the weights move; later it takes one with each of theirs",
        at_most_a_million);
  visit("steps", s.steps, "steps of the weights in a round", Numbers{1, 1e6});
  visit("pictures", s.pictures, "pictures a step of the weights", of_a_batch);
  visit("painted", s.painted, "share of these pictures that show a painted car, 0 to 1", shares);
  visit("weight-rate", s.weight_rate,
        "Adam's learning rate of the weights, at its highest: it rises for 50 steps, then falls as a cosine "
        "over all rounds",
        above_zero);
  visit("clean-scenes", s.clean_scenes,
        "street scenes drawn with labels to learn from, for detectors of the classes car, van and clutter; "
        "others learn from clean views alone",
        Numbers{0, 1e5});
  visit("test-scenes", s.test_scenes, "such scenes held out, for average precision before and after",
        Numbers{0, 1e5});
  visit("epochs", s.epochs,
        "passes over the training views of each attack that is measured; 0: 20 over drawn scenes; over "
        "frames, as many as give 2400 views, at least 5",
        at_most_a_million);
  visit("loss", s.loss, "adversarial loss of the paints: " + help_of(loss::adversarial_losses));
  visit("smoothness-weight", s.smoothness, "weight of the paints' smoothness term, in units of 1e-4");
  visit("batch", s.batch, "views a step of a paint", of_a_batch);
  visit("learning-rate", s.learning_rate, "Adam's learning rate of the paints", above_zero);
  visit("seed", s.seed, "seed of all paints, orders and draws");
}

struct HardenOptions : RunOptions {
  SceneSettings scene;
  DetectorSettings detector;
  HardenSettings harden;
  bool quick = false;
};

inline void describe(CLI::App& app, HardenOptions& options) {
  add_options(app, options.scene);
  add_options(app, options.detector);
  add_options(app, options.harden);
  add_run_options(app, options, "runs/harden");
  app.add_flag("--quick", options.quick,
               "a small budget for a first look, where no other is given: 80 scenes, 4 short rounds; its "
               "attacks are too short to show an effect");
}

/// Settings that decide the result of a run, under the names of the options.
inline Json settings_json(const HardenOptions& options) {
  return json_of_settings(options.scene, options.detector, options.harden);
}

inline void require_sound(const HardenSettings& s, ProblemList& list) { require_values(s, list); }

/// Checks the options. To resume a run, the settings come from its manifest and are checked there.
inline void require_sound(const HardenOptions& options, ProblemList& list) {
  require_sound_run(options, list);
  if (options.resume) return;
  require_sound(options.scene, list);
  require_sound(options.detector, list);
  require_sound(options.harden, list);
}

/// Sets options that were not given to the budget of --quick.
inline void adopt_quick(const CLI::App& app, HardenOptions& options) {
  const auto set = [&](const char* option, std::size_t& value, std::size_t quick) {
    if (app.get_option(option)->count() == 0) value = quick;
  };
  if (options.scene.frames.empty()) set("--scenes", options.scene.scenes, 80);
  set("--texels", options.scene.texels, 32);
  set("--rounds", options.harden.rounds, 4);
  set("--attack-steps", options.harden.attack_steps, 40);
  set("--steps", options.harden.steps, 40);
  set("--clean-scenes", options.harden.clean_scenes, 60);
  set("--test-scenes", options.harden.test_scenes, 40);
  set("--epochs", options.harden.epochs, 20);
}

inline camouflage::ObjectiveOptions objective_options(const HardenSettings& s, std::size_t class_index) {
  camouflage::ObjectiveOptions objective;
  objective.kind = loss::adversarial_loss_by_name(s.loss);
  objective.smoothness = s.smoothness;
  objective.class_index = class_index;
  return objective;
}

/// Inputs of a hardening besides the detector; all of them must outlive it.
struct HardeningScene {
  const raster::PaintedMesh& car;
  camouflage::ViewStore<float>& store;
  const std::vector<std::size_t>& usable;  ///< the store's views that show the car
  const CleanSource& clean;
  std::size_t class_index;
};

/// Adversarial training of a detector against car paint, in rounds. A round begins with a fresh paint, which
/// camouflage::Training optimises while the detector is fixed. Then the weights learn from clean pictures and
/// from views with this and other paints, see draw_paint(). With each step of the weights the paint takes a
/// step, too, so that it stays optimised against the current detector. With `paint` none the weights learn
/// from cars of ordinary colours, and no paint is optimised.
///
/// Source: Madry et al., "Towards deep learning models resistant to adversarial attacks" (ICLR 2018). Their
/// inner maximum is over small perturbations of each picture; here it is over one texture that all views
/// share.
///
/// Batch normalisation keeps its running statistics, see LearningDetector. Statistics of a batch would mix
/// clean and painted pictures, whose statistics differ (Xie et al., "Adversarial examples improve image
/// recognition", CVPR 2020). The detector that learns would then differ from the one that is attacked and
/// used, which has the running statistics.
///
/// The weights learn as Learner says.
class Hardening {
 public:
  /// \param detector is changed; the other arguments must outlive the hardening
  Hardening(LearningDetector& detector, const HardenSettings& settings, HardeningScene scene)
      : detector_(detector),
        settings_(settings),
        scene_(scene),
        objective_(detector.detector(), objective_options(settings, scene.class_index)),
        learner_(detector, "harden"),
        batch_(scene.store, scene.usable, scene.clean, settings.pictures, settings.painted) {
    pool_.is_ordinary = settings.paint == "none";
    if (pool_.is_ordinary) settings_.attack_steps = 0;
    state_.parameters = detector.weights();
    state_.adam = learner_.state();
    begin_round();
  }

  [[nodiscard]] std::size_t step_count() const {
    return settings_.rounds * (settings_.attack_steps + settings_.steps);
  }
  [[nodiscard]] std::uint64_t steps_taken() const { return state_.done; }
  [[nodiscard]] bool finished() const { return state_.done >= step_count(); }
  [[nodiscard]] const std::vector<HardeningStep>& history() const { return state_.history; }

  /// A copy of everything that a checkpoint needs; read_hardening() compares extents with it.
  [[nodiscard]] HardeningState state() const {
    HardeningState state = state_;
    state.parameters = detector_.weights();
    state.adam = learner_.state();
    auto training = training_->state();
    state.paint = std::move(training.parameter);
    state.attack = std::move(training.adam);
    return state;
  }

  /// \throws FileError (mismatch) for a state that no run with these settings can reach
  void restore(const std::string& path, HardeningState state) {
    const std::uint64_t of_round = settings_.attack_steps + settings_.steps;
    const std::uint64_t round = state.done / of_round, within = state.done % of_round;
    if (state.done > step_count())
      throw file_mismatch({path, "", "more steps taken than the run has", std::to_string(step_count()),
                           std::to_string(state.done)});
    detail::require_size(path, "paints", pool_.is_ordinary ? 0 : round, state.paints.size());
    const std::uint64_t learnt = within > settings_.attack_steps ? within - settings_.attack_steps : 0;
    detail::require_size(path, "history", round * settings_.steps + learnt, state.history.size());
    detail::require_size(path, "adam_step", state.history.size(), state.adam.step);
    detector_.set_weights(state.parameters);
    learner_.restore(state.adam);
    for (const auto& paint : state.paints) pool_.add(scene_.car, paint, settings_.seed);
    state_ = std::move(state);
    count_images();
    begin_round();
    if (within > 0 && !pool_.is_ordinary) {
      detail::require_size(path, "attack_step", within, state_.attack.step);
      training_->restore({state_.paint, state_.attack, within, {}});
    }
  }

  /// One step of the paint and, once the paint has had its first steps alone, one of the weights.
  /// \throws NumericError if a loss or a gradient is not finite
  void step() {
    const std::uint64_t within = state_.done % (settings_.attack_steps + settings_.steps);
    if (!pool_.is_ordinary) training_->step();
    if (within >= settings_.attack_steps) learn();
    ++state_.done;
    if (within + 1 < settings_.attack_steps + settings_.steps) return;
    if (!pool_.is_ordinary) {
      state_.paints.push_back(camouflage::texture_colours(training_->parameter()));
      pool_.add(scene_.car, state_.paints.back(), settings_.seed);
    }
    if (!finished()) begin_round();
  }

  [[nodiscard]] std::string progress_text() const {
    const std::size_t of_round = settings_.attack_steps + settings_.steps;
    const HardeningStep last = state_.history.empty() ? HardeningStep{} : state_.history.back();
    return formatted("round %zu of %zu, step %llu of %zu: detector's loss %.3f, paint's %.3f",
                     std::min<std::size_t>(state_.done / of_round + 1, settings_.rounds), settings_.rounds,
                     static_cast<unsigned long long>(state_.done), step_count(), last.total, paint_loss());
  }

 private:
  /// Loss of the paint in its last step; 0 before the first.
  [[nodiscard]] double paint_loss() const {
    const auto& history = training_->history();
    if (!history.empty()) return history.back().total;
    return state_.history.empty() ? 0 : state_.history.back().attack;
  }

  /// Starts a fresh paint, mid grey and random in turns, and a fresh order of the views.
  void begin_round() {
    const std::uint64_t round = state_.done / (settings_.attack_steps + settings_.steps);
    Random random = Random(settings_.seed).fork(0x726F756E64ULL).fork(round);
    const std::size_t texels = scene_.car.layout.texel_count(scene_.car.mesh);
    auto start = zeros<float, 2>({texels, 3});
    if (round % 2 == 1)
      start = camouflage::parameter_of_colours(camouflage::random_colours<float>(texels, random));
    camouflage::TrainingOptions options;
    options.batch = settings_.batch;
    options.seed = random.bits();
    options.adam.learning_rate = settings_.learning_rate;
    training_.emplace(objective_, scene_.store, scene_.usable, std::move(start), options);
  }

  void learn() {
    const std::size_t index = state_.history.size();
    batch_.fill(Random(settings_.seed).fork(0x6C6561726EULL).fork(index),
                camouflage::texture_colours(training_->parameter()), pool_);
    const double rate =
        warm_cosine_rate(settings_.weight_rate, index, settings_.rounds * settings_.steps, 50);
    const LossTerms terms = learner_.step(batch_.images(), batch_.truths(), rate, state_.done + 1);
    state_.history.push_back({terms, paint_loss()});
    count_images();
  }

  void count_images() { detector_.set_pictures_seen(state_.history.size() * settings_.pictures); }

  LearningDetector& detector_;
  HardenSettings settings_;
  HardeningScene scene_;
  camouflage::Objective<float> objective_;
  Learner learner_;
  MixedBatch batch_;
  PaintPool pool_;
  HardeningState state_;  ///< without the parts in detector_, adam_ and training_
  std::optional<camouflage::Training<float>> training_;
};
}  // namespace tapestry::shell
