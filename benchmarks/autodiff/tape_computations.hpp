#pragma once
#include <barrier>
#include <numeric>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
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

/// An objective that is recorded anew in each run, on a tape that keeps its memory.
template <class Objective>
class RecordedObjective : public Computation {
  Objective objective_;
  std::vector<double> x_;

 protected:
  explicit RecordedObjective(const Objective& objective)
      : objective_(objective), x_(objective.start()), inputs_(x_.size()) {
    gradient_.resize(x_.size());
  }
  [[nodiscard]] Variable<double> record() {
    const auto scope = tape_.activate();
    tape_.clear();
    tape_.input(x_, inputs_);
    const Variable<double> result = objective_(inputs_.data());
    value_ = result.value();
    return result;
  }

  Tape<double> tape_;
  std::vector<Variable<double>> inputs_;
};

template <class Objective>
class ScalarTape final : public RecordedObjective<Objective> {
 public:
  explicit ScalarTape(const Objective& objective) : RecordedObjective<Objective>(objective) {}
  void run() override {
    this->tape_.reverse(this->record());
    this->tape_.adjoints(this->inputs_, this->gradient_);
  }
};

/// Records alone; the sweep comes when the answer is saved.
template <class Objective>
class RecordingAlone final : public RecordedObjective<Objective> {
 public:
  explicit RecordingAlone(const Objective& objective) : RecordedObjective<Objective>(objective) {}
  void run() override { root_ = this->record(); }
  void finish() override {
    this->tape_.reverse(root_);
    this->tape_.adjoints(this->inputs_, this->gradient_);
  }

 private:
  Variable<double> root_;
};

/// Sweeps back for eight roots at once, all of them the result, and takes the mean of what they give.
template <class Objective>
class VectorSweeps final : public RecordedObjective<Objective> {
 public:
  explicit VectorSweeps(const Objective& objective) : RecordedObjective<Objective>(objective) {}
  void run() override {
    const std::vector<Variable<double>> roots(8, this->record());
    adjoints_.reverse(this->tape_, roots);
  }
  void finish() override {
    for (std::size_t i = 0; i < this->inputs_.size(); ++i) {
      const auto adjoints = adjoints_.of(this->inputs_[i]);
      this->gradient_[i] = std::accumulate(adjoints.begin(), adjoints.end(), 0.0) / 8;
    }
  }

 private:
  AdjointVectors<double, 8> adjoints_;
};

/// An objective as a function of a span.
template <class Objective>
struct OfSpan {
  Objective objective;
  template <class S>
  [[nodiscard]] S operator()(std::span<const S> x) const {
    return objective(x.data());
  }
};

/// gradient(f, x), which knows nothing of the calls before but their memory.
template <class Objective>
class GradientCall final : public Computation {
 public:
  explicit GradientCall(const Objective& objective) : x_(objective.start()), f_{objective} {}
  void run() override {
    auto result = gradient(f_, x_);
    value_ = result.value;
    gradient_ = std::move(result.gradient);
  }

 private:
  std::vector<double> x_;
  OfSpan<Objective> f_;
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
  std::vector<double> x_, direction_;
  HessianProducts<OfSpan<Objective>> products_;
};

/// Runs copies of a computation, one on each thread, computed computations_a_wait times. The calling thread
/// waits for all.
template <class Inner>
class OnThreads final : public Computation {
 public:
  template <class Objective>
  OnThreads(const Objective& objective, std::ptrdiff_t threads) : start_(threads + 1), end_(threads + 1) {
    for (std::ptrdiff_t i = 0; i < threads; ++i) computations_.push_back(std::make_unique<Inner>(objective));
    for (const auto& computation : computations_)
      threads_.emplace_back([this, &computation] {
        for (start_.arrive_and_wait(); !is_over_; start_.arrive_and_wait()) {
          for (int i = 0; i < computations_a_wait; ++i) computation->run();
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
  std::vector<double> answer() override { return computations_.back()->answer(); }

 private:
  std::vector<std::unique_ptr<Inner>> computations_;
  std::barrier<> start_, end_;
  std::atomic<bool> is_over_ = false;
  std::vector<std::jthread> threads_;
};
}  // namespace tapestry::benchmarks
