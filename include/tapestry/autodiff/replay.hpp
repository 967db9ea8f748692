#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/replay/replay_program.hpp>
#include <tapestry/autodiff/replay/replayable.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry {

/// A function recorded once and evaluated, with its gradient, for other inputs; cheaper than recording it
/// anew.
///
///   const auto f = [](const auto* x) { return exp(x[0]) * x[1]; };
///   Replay<double> replay(f, start);          // calls f once, with Replayable<double>
///   double value = replay.gradient(x, gradient);
///
/// A decision of f that compares its variables is made once: inputs for which a comparison comes out
/// otherwise are refused, unless guards are ignored. Which of two numbers is the larger counts, not the
/// comparison itself: x >= y, recorded with x above y, refuses x equal to y. Decisions by their value() are
/// not noticed; min, max and abs follow their arguments, and need no guard. One Replay serves one thread at a
/// time.
template <std::floating_point T>
class Replay {
 public:
  /// \param function  takes a const Replayable<T>* to as many inputs as `inputs` has, or a span of them, as
  ///                  the functions of derivatives.hpp do; returns a type that converts to one
  /// \throws what function throws
  template <class Function>
  Replay(const Function& function, std::span<const T> inputs, Guards guards = Guards::record)
      : input_count_(inputs.size()) {
    const auto recorded = detail::record_function<1>(function, inputs, guards, &program_);
    constant_ = recorded.constant;
    program_.finish(recorded.recording, recorded.root);
  }

  /// The function's value at other inputs.
  /// \throws DomainError if there are not as many, or if a comparison comes out otherwise than when recorded
  T value(std::span<const T> inputs) {
    require_count("inputs", inputs.size());
    std::copy(inputs.begin(), inputs.end(), program_.values() + 1);
    program_.forward();
    return program_.root() == 0 ? constant_ : program_.values()[program_.root()];
  }

  /// The same, and its gradient.
  T gradient(std::span<const T> inputs, std::span<T> gradient) {
    require_count("entries of the gradient", gradient.size());
    const T value = this->value(inputs);
    program_.backward(input_count_);
    std::copy_n(program_.adjoints() + 1, input_count_, gradient.begin());
    return value;
  }

  /// Number of recorded formulas and comparisons.
  [[nodiscard]] std::size_t statement_count() const { return program_.statement_count(); }
  /// Number of pieces in which they are computed.
  [[nodiscard]] std::size_t run_count() const { return program_.run_count(); }

 private:
  void require_count(const char* what, std::size_t found) const {
    if (found != input_count_)
      throw DomainError("Replay: " + std::to_string(found) + " " + what + ", recorded with " +
                        std::to_string(input_count_) + " inputs");
  }

  std::size_t input_count_;
  detail::ReplayProgram<T> program_;
  T constant_ = 0;
};

}  // namespace tapestry
