#pragma once

#include "harden_options.hpp"
#include "hardening_state.hpp"

namespace tapestry::shell {

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
      throw FileError(ErrorKind::mismatch, {path, "", "more steps taken than the run has",
                                            std::to_string(step_count()), std::to_string(state.done)});
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
