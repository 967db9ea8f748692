#pragma once
#include <atomic>
#include <barrier>
#include <cstddef>
#include <memory>
#include <span>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/replay.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "hand_adjoints.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {

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
    gradient_.resize(entry_count(objective));
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

/// Records, and sweeps back for eight roots at once, all of them the result.
template <class Objective>
class VectorSweeps final : public Computation {
 public:
  explicit VectorSweeps(const Objective& objective)
      : objective_(objective), x_(objective.start()), inputs_(x_.size()) {}
  void run() override {
    const auto scope = tape_.activate();
    tape_.clear();
    tape_.input(x_, inputs_);
    const Variable<double> result = objective_(inputs_.data());
    value_ = result.value();
    const std::vector<Variable<double>> roots(8, result);
    adjoints_.reverse(tape_, roots);
  }
  void finish() override {
    gradient_.clear();
    for (const auto& input : inputs_) gradient_.push_back(adjoints_.of(input)[7]);
  }

 private:
  Objective objective_;
  std::vector<double> x_;
  Tape<double> tape_;
  AdjointVectors<double, 8> adjoints_;
  std::vector<Variable<double>> inputs_;
};

/// The Hessian times a vector, and the gradient on the way.
template <class Objective>
class HessianTimesVector final : public Computation {
 public:
  explicit HessianTimesVector(const Objective& objective)
      : x_(objective.start()), direction_(uniform(x_.size(), -1, 1, 71)), products_({objective}) {}
  void run() override {
    auto result = products_(x_, direction_);
    value_ = result.value;
    gradient_ = std::move(result.gradient);
  }

 private:
  struct OfSpan {
    Objective objective;
    template <class S>
    [[nodiscard]] S operator()(std::span<const S> x) const {
      return objective(x.data());
    }
  };
  std::vector<double> x_, direction_;
  HessianProducts<OfSpan> products_;
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

/// As many copies of a computation as threads, one on each. The calling thread waits for all.
template <class Inner>
class OnThreads final : public Computation {
 public:
  template <class Objective>
  OnThreads(const Objective& objective, std::ptrdiff_t threads) : start_(threads + 1), end_(threads + 1) {
    for (std::ptrdiff_t i = 0; i < threads; ++i) computations_.push_back(std::make_unique<Inner>(objective));
    for (const auto& computation : computations_)
      threads_.emplace_back([this, &computation] {
        for (start_.arrive_and_wait(); !is_over_; start_.arrive_and_wait()) {
          computation->run();
          end_.arrive_and_wait();
        }
      });
  }
  OnThreads(const OnThreads&) = delete;
  OnThreads& operator=(const OnThreads&) = delete;
  ~OnThreads() override {
    is_over_ = true;
    start_.arrive_and_wait();
  }
  void run() override {
    start_.arrive_and_wait();
    end_.arrive_and_wait();
  }
  void save(const std::string& path) override { computations_.back()->save(path); }

 private:
  std::vector<std::unique_ptr<Inner>> computations_;
  std::barrier<> start_, end_;
  std::atomic<bool> is_over_ = false;
  std::vector<std::jthread> threads_;
};

}  // namespace tapestry::benchmarks
