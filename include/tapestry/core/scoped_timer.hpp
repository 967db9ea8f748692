#pragma once
#include <chrono>
#include <ctime>

namespace tapestry {
/// Adds the time between its construction and its destruction to a number of seconds.
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

/// How long a stretch of work took, and the processor time of all threads of the process meanwhile, in
/// seconds. Their ratio is the number of threads that were busy.
struct WorkTime {
  double wall = 0;
  double busy = 0;
};

/// Adds to a WorkTime from its construction to its destruction.
class ScopedWorkTimer {
 public:
  explicit ScopedWorkTimer(WorkTime& time) : wall_(time.wall), time_(time), busy_(std::clock()) {}
  ~ScopedWorkTimer() {
    time_.busy += static_cast<double>(std::clock() - busy_) / static_cast<double>(CLOCKS_PER_SEC);
  }
  ScopedWorkTimer(const ScopedWorkTimer&) = delete;
  ScopedWorkTimer& operator=(const ScopedWorkTimer&) = delete;

 private:
  ScopedTimer wall_;
  WorkTime& time_;
  std::clock_t busy_;
};
}  // namespace tapestry
