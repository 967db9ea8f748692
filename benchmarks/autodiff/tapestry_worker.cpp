// The objectives as this library differentiates them; and as plain code, and with adjoints by hand.
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/replay.hpp>
#include <vector>

#include "hand_adjoints.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {
namespace {

template <class Objective>
class PlainValue final : public Computation {
 public:
  explicit PlainValue(const Objective& objective) : objective_(objective), x_(objective.start()) {}
  void run() override { value_ = objective_(x_.data()); }

 private:
  Objective objective_;
  std::vector<double> x_;
};

template <class Objective>
class HandAdjoint final : public Computation {
 public:
  explicit HandAdjoint(const Objective& objective) : objective_(objective), x_(objective.start()) {
    gradient_.resize(x_.size());
  }
  void run() override { value_ = hand_adjoint(objective_, x_.data(), gradient_.data()); }

 private:
  Objective objective_;
  std::vector<double> x_;
};

/// Records and reverses, keeping the tape's memory from run to run.
template <class Objective>
class ScalarTape final : public Computation {
 public:
  explicit ScalarTape(const Objective& objective)
      : objective_(objective), x_(objective.start()), inputs_(x_.size()) {
    gradient_.resize(x_.size());
  }
  void run() override {
    const auto scope = tape_.activate();
    tape_.clear();
    tape_.input(x_, inputs_);
    const Variable<double> result = objective_(inputs_.data());
    value_ = result.value();
    tape_.reverse(result);
    tape_.adjoints(inputs_, gradient_);
  }

 private:
  Objective objective_;
  std::vector<double> x_;
  Tape<double> tape_;
  std::vector<Variable<double>> inputs_;
};

/// Evaluates a recording made beforehand.
template <class Objective>
class ReplayedRecording final : public Computation {
 public:
  ReplayedRecording(const Objective& objective, Guards guards)
      : x_(objective.start()), replay_([&](const auto* x) { return objective(x); }, x_, guards) {
    gradient_.resize(x_.size());
  }
  void run() override { value_ = replay_.gradient(x_, gradient_); }

 private:
  std::vector<double> x_;
  Replay<double> replay_;
};

}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  using namespace tapestry::benchmarks;
  return run_worker(argc, argv,
                    []<class Objective>(const Objective& objective,
                                        const std::string& variant) -> std::unique_ptr<Computation> {
                      if (variant == "plain") return std::make_unique<PlainValue<Objective>>(objective);
                      if (variant == "hand") return std::make_unique<HandAdjoint<Objective>>(objective);
                      if (variant == "scalar") return std::make_unique<ScalarTape<Objective>>(objective);
                      using Replayed = ReplayedRecording<Objective>;
                      if (variant == "replay")
                        return std::make_unique<Replayed>(objective, tapestry::Guards::record);
                      if (variant == "replay-unguarded")
                        return std::make_unique<Replayed>(objective, tapestry::Guards::ignore);
                      return nullptr;
                    });
}
