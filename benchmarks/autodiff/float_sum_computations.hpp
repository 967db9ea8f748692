#pragma once
#include "array_forms.hpp"
#include "worker_program.hpp"

namespace tapestry::benchmarks {
/// One after the other, in T.
template <class T>
class NaiveSum final : public Computation {
 public:
  explicit NaiveSum(const FloatSum& sum) : sum_(sum) {
    const auto start = sum.start();
    x_.assign(start.begin(), start.end());
  }
  void run() override { value_ = static_cast<double>(sum_(x_.data())); }

 private:
  FloatSum sum_;
  std::vector<T> x_;
};

/// sum() of an array of floats, in blocks and compensated, and its gradient.
class CompensatedArraySum final : public Computation {
 public:
  explicit CompensatedArraySum(const FloatSum& sum)
      : x_(detail::constants<float, 1>(sum.start(), {FloatSum::terms})) {}
  void run() override {
    const auto scope = tape_.activate();
    tape_.clear();
    const auto input = tape_.input(x_);
    const Variable<float> total = sum(input);
    tape_.reverse(total);
    value_ = static_cast<double>(total.value());
  }

 private:
  ArrayVariable<float, 1> x_;
  Tape<float> tape_;
};
}  // namespace tapestry::benchmarks
