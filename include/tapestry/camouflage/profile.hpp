#pragma once
#include <concepts>
#include <memory>
#include <mutex>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/scoped_timer.hpp>
#include <utility>

namespace tapestry::camouflage {
/// Seconds spent in each part of the optimisation, summed over steps and threads.
struct StepTimes {
  double render = 0;             ///< texture → picture of the car, and its pullback
  double composite = 0;          ///< the picture over its frame, and its pullback
  double detector_forward = 0;   ///< network
  double detector_backward = 0;  ///< network, gradient to its input
  double losses = 0;             ///< adversarial and smoothness terms with their pullbacks
  double update = 0;             ///< texture parametrisation with its pullback, Adam

  // Stretches of a step that follow each other.
  WorkTime paint{};     ///< texture parametrisation, the views' lookups, and the terms of the paint alone
  WorkTime views{};     ///< from the pictures of the views to their pullbacks
  WorkTime pullback{};  ///< the views' adjoints added up, and pulled back to the parameters
  WorkTime adam{};

  [[nodiscard]] double total() const {
    return render + composite + detector_forward + detector_backward + losses + update;
  }
};

/// Divides the time of recording and of the reverse sweep among stages. end_of() between two stages ends the
/// first. It leaves a mark on the active tape: there the reverse sweep, which runs backwards, ends the
/// second. Clocks of several threads may add to the same times.
template <std::floating_point T>
class StageClock {
 public:
  using Stage = double StepTimes::*;

  /// \param is_swept  whether a reverse sweep may come: if not, no mark is recorded
  StageClock(std::shared_ptr<StepTimes> times, bool is_swept)
      : shared_(std::make_shared<Shared>(std::move(times))), is_swept_(is_swept) {
    mark(nullptr);
  }

  /// Ends a stage: counts the time since the last call for it.
  /// \param reverse  stage that counts the sweep over the statements recorded since then
  void end_of(Stage forward, Stage reverse);
  void end_of(Stage stage) { end_of(stage, stage); }

 private:
  using Clock = std::chrono::steady_clock;

  struct Shared {
    explicit Shared(std::shared_ptr<StepTimes> all) : times(std::move(all)) {}
    void count(Stage stage) {
      const auto now = Clock::now();
      if (stage != nullptr) {
        static std::mutex adding;  // std::atomic_ref has been in libc++ since 19 alone
        const std::lock_guard lock(adding);
        (*times).*stage += std::chrono::duration<double>(now - last).count();
      }
      last = now;
    }
    std::shared_ptr<StepTimes> times;
    Clock::time_point last = Clock::now();
    Stage swept = nullptr;  ///< the stage that the sweep is in
  };

  /// Time between the end of one stage and the begin of the next.
  void mark(Stage before);

  std::shared_ptr<Shared> shared_;
  bool is_swept_;
};

extern template class StageClock<float>;
}  // namespace tapestry::camouflage
