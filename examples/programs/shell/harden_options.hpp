#pragma once
#include <tapestry/camouflage/objective.hpp>

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

}  // namespace tapestry::shell
