#pragma once
#include <chrono>

namespace tapestry::camouflage {

/// Seconds spent in each part of the optimisation, summed over steps.
struct StepTimes {
  double render = 0;             ///< texture → premultiplied picture, and its pullback
  double compose = 0;            ///< picture into frame, to planes and back
  double detector_forward = 0;   ///< network
  double detector_backward = 0;  ///< network, gradient to its input
  double losses = 0;             ///< adversarial and smoothness terms with their pullbacks
  double update = 0;             ///< texture parametrisation, Adam

  [[nodiscard]] double total() const {
    return render + compose + detector_forward + detector_backward + losses + update;
  }
};

/// Adds the time between its construction and its destruction to one entry of StepTimes.
class ScopedTimer {
 public:
  explicit ScopedTimer(double& seconds) : seconds_(seconds), start_(std::chrono::steady_clock::now()) {}
  ~ScopedTimer() {
    seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  ScopedTimer(const ScopedTimer&) = delete;
  ScopedTimer& operator=(const ScopedTimer&) = delete;

 private:
  double& seconds_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace tapestry::camouflage
