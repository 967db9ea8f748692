#pragma once
#include "../../scenes/scene.hpp"
#include "progress.hpp"
#include "settings.hpp"
#include "stop_signal.hpp"

namespace tapestry::shell {
/// Options of programs that train a network on procedural street scenes: how long they train, and how often
/// they save and measure.
struct SceneTraining {
  std::size_t steps = 0, batch = 0, validate = 0, validate_every = 0, save_every = 250;
  double learning_rate = 0.002;
  std::uint64_t seed = 1;
};

/// \param measured  on held-out scenes
inline void add_options(CLI::App& app, SceneTraining& s, const std::string& measured) {
  app.add_option("--steps", s.steps, "steps of the optimiser; 0: only validate");
  app.add_option("--batch", s.batch, "pictures a step");
  app.add_option("--learning-rate", s.learning_rate,
                 "Adam's, at its highest: it rises for 200 steps, then falls as a cosine");
  app.add_option("--validate", s.validate,
                 "held-out scenes for " + measured + ", for each of three kinds of paint");
  app.add_option("--validate-every", s.validate_every, "steps between validations");
  app.add_option("--save-every", s.save_every, "steps between saves");
  app.add_option("--seed", s.seed, "seed of scenes and first weights");
  add_threads_option(app, "threads; 0: all cores. Results do not depend on it");
}

inline void require_sound(const SceneTraining& s, ProblemList& list) {
  list.require(s.batch >= 1 && s.batch <= 1024, "--batch must be 1 to 1024");
  list.require(s.save_every > 0 && s.validate_every > 0,
               "--save-every and --validate-every must be at least 1");
  list.require(s.learning_rate > 0, "--learning-rate must be above 0");
  list.require(s.validate <= 2000, "--validate must be at most 2000");
}

template <class Scene>
struct HeldOut {
  std::string name;
  std::vector<Scene> scenes;
};

/// Views of cars in realistic paint, solid paint and texel noise, of main cars that are at least 40 %
/// visible.
/// \param stream  of random numbers, other than the training's
/// \param count   scenes of each kind; fewer if too few of twice as many draws are suitable
/// \param draw    returns a scene for (Random, SceneOptions)
/// \throws Stopped
template <class Draw>
auto held_out_sets(std::uint64_t stream, std::size_t count, Draw draw) {
  using Scene = decltype(draw(Random(stream), scenes::SceneOptions{}));
  std::vector<HeldOut<Scene>> sets{{"realistic", {}}, {"solid", {}}, {"texel noise", {}}};
  const scenes::PaintKind paints[] = {scenes::PaintKind::realistic, scenes::PaintKind::solid,
                                      scenes::PaintKind::texel_noise};
  for (std::size_t kind = 0; kind < sets.size(); ++kind) {
    scenes::SceneOptions options;
    options.van_chance = 0;
    options.paint = paints[kind];
    const Random source = Random(stream).fork(static_cast<std::uint64_t>(paints[kind]));
    std::vector<Scene> drawn(2 * count);
    parallel_for(drawn.size(), [&](std::size_t i) {
      StopSignal::throw_if_arrived();
      drawn[i] = draw(source.fork(i), options);
    });
    for (auto& candidate : drawn)
      if (candidate.main_share >= 0.4 && sets[kind].scenes.size() < count)
        sets[kind].scenes.push_back(std::move(candidate));
  }
  return sets;
}

struct StepLoss {
  double total = 0;
  std::string terms{};  ///< as text, printed behind the loss
};

/// Trains until all steps are done or a signal arrives; saves and validates at intervals and at the end.
/// \param step      returns the StepLoss of the step with a number
/// \param validate  prints measurements
/// \returns         the number of steps done, less than all if a signal arrived
/// \throws Stopped if a signal arrives before the first step
template <class Step, class Save, class Validate>
std::size_t train_on_scenes(const SceneTraining& s, Step step, Save save, Validate validate) {
  using Clock = std::chrono::steady_clock;
  ProgressLine progress;
  const auto begin = Clock::now();
  double smoothed = 0;
  std::size_t done = 0;
  while (done < s.steps && !StopSignal::arrived()) {
    const StepLoss loss = step(done++);
    smoothed = done == 1 ? loss.total : 0.98 * smoothed + 0.02 * loss.total;
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    const double left = seconds / static_cast<double>(done) * static_cast<double>(s.steps - done);
    progress.show(
        formatted("step %zu of %zu: loss %.3f%s, %.2f steps/s, %s left", done, s.steps, smoothed,
                  loss.terms.c_str(), static_cast<double>(done) / seconds, duration_text(left).c_str()),
        done == s.steps);
    if (done % s.save_every == 0) save();
    if (done % s.validate_every == 0 && done < s.steps) {
      std::printf("after step %zu, loss %.3f\n", done, smoothed);
      validate();
    }
  }
  if (done == 0) StopSignal::throw_if_arrived();
  if (done > 0) save();
  if (done < s.steps && StopSignal::arrived()) return done;
  std::printf("after step %zu, loss %.3f\n", done, smoothed);
  validate();
  return done;
}

/// Runs a training program after its options are checked.
/// \param output  file that it will write, claimed until the program ends
/// \param train   returns the exit code
template <class Train>
int run_training(const SceneTraining& s, const std::string& output, Train train) {
  std::optional<OutputClaim> claim;
  if (s.steps > 0) {
    require_writable_file(output);
    claim.emplace(Claimed::file, output);
  }
  const StopSignal stop_signal;
  try {
    return train();
  } catch (const Stopped&) {
    std::fprintf(stderr, "\nstopped before the first step; nothing was written\n");
    return StopSignal::exit_code();
  }
}
}  // namespace tapestry::shell
