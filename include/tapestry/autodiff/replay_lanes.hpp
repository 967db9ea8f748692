#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/replay/lane_program.hpp>
#include <tapestry/autodiff/replay/replayable.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry {

/// A function recorded once and evaluated, with its gradient, for many inputs, several at a time in the lanes
/// of vectors: for calibrations and random simulations.
///
///   ReplayLanes<double> replay(f, start);               // calls f once, with Replayable<double, 8>
///   auto values = replay.gradients(inputs, gradients);  // of inputs.size() / start.size() inputs
///
/// The bits of each input do not depend on the other inputs, the number of lanes, or the instructions of an
/// x86-64 processor: a comparison that comes out otherwise, a NaN or an overflow of one input does not affect
/// the others. exp, log, log1p and tanh are the library's own, for vectors: right to 1 unit of the last
/// place, tanh to 2.5, and like those of C at infinities, NaN and denormal numbers; sigmoid, softplus and
/// logsumexp are made of them. Other functions are those of C. A computation without these has the bits of
/// Replay, one with them those of Replay but for roundings. With flags that let a compiler fuse products and
/// sums, such as -march=native, last bits may differ. Cheap results are not kept but computed again in the
/// backward pass. One ReplayLanes serves one thread at a time.
template <std::floating_point T, std::size_t Lanes = 8>
class ReplayLanes {
  static_assert(Lanes > 1 && Lanes <= 64, "2 to 64 lanes; Replay is for one");

 public:
  /// \param function  as Replay's, of Replayable<T, Lanes>
  /// \param inputs    the point at which it is called, [inputs]
  /// \throws what function throws
  template <class Function>
  ReplayLanes(const Function& function, std::span<const T> inputs, Guards guards = Guards::record)
      : input_count_(inputs.size()) {
    const auto recorded = detail::record_function<Lanes>(function, inputs, guards);
    is_constant_ = recorded.root == 0;
    constant_ = recorded.constant;
    program_ = detail::LaneProgram<T, Lanes>(recorded.recording, recorded.root);
  }

  /// The function's values.
  /// \param inputs  one input after another, [N, inputs], N of any number
  /// \returns [N], none where a comparison comes out otherwise than when recorded
  /// \throws DomainError if the size is no multiple of an input's
  std::vector<std::optional<T>> values(std::span<const T> inputs) {
    return evaluate(inputs, [](std::size_t, std::size_t) {});
  }

  /// The same, and its gradients.
  /// \param gradients  [N, inputs]; of those without a value, NaN
  /// \throws DomainError also if there are not as many entries as inputs
  std::vector<std::optional<T>> gradients(std::span<const T> inputs, std::span<T> gradients) {
    if (gradients.size() != inputs.size())
      throw DomainError("ReplayLanes: " + std::to_string(gradients.size()) + " entries of gradients for " +
                        std::to_string(inputs.size()) + " of inputs");
    return evaluate(inputs, [&](std::size_t first, std::size_t count) {
      if (!is_constant_) program_.backward(input_count_);
      T* const rows = gradients.data() + first * input_count_;
      for (std::size_t i = 0; i < input_count_; ++i)
        for (std::size_t lane = 0; lane < count; ++lane)
          rows[lane * input_count_ + i] = is_constant_ ? T(0) : program_.input_adjoint(i)[lane];
      for (std::size_t lane = 0; lane < count; ++lane)
        if (program_.refused()[lane])
          std::fill_n(rows + lane * input_count_, input_count_, std::numeric_limits<T>::quiet_NaN());
    });
  }

 private:
  /// Calls after(first, count) when values `first` and on are computed.
  template <class After>
  std::vector<std::optional<T>> evaluate(std::span<const T> inputs, After after) {
    const std::size_t width = std::max<std::size_t>(input_count_, 1);
    if (inputs.size() % width != 0 || (input_count_ == 0 && !inputs.empty()))
      throw DomainError("ReplayLanes: " + std::to_string(inputs.size()) +
                        " entries of inputs, recorded with " + std::to_string(input_count_) + " of them");
    std::vector<std::optional<T>> values(inputs.size() / width);
    for (std::size_t first = 0; first < values.size(); first += Lanes) {
      const std::size_t count = std::min(Lanes, values.size() - first);
      const T* const rows = inputs.data() + first * width;
      std::array<const T*, Lanes> row;
      for (std::size_t lane = 0; lane < Lanes; ++lane)  // lanes without an input repeat the last
        row[lane] = rows + std::min(lane, count - 1) * width;
      for (std::size_t i = 0; i < input_count_; ++i) {
        const auto input = program_.input(i);
        for (std::size_t lane = 0; lane < Lanes; ++lane) input[lane] = row[lane][i];
      }
      program_.forward();
      for (std::size_t lane = 0; lane < count; ++lane)
        if (!program_.refused()[lane])
          values[first + lane] = is_constant_ ? constant_ : program_.root()[lane];
      after(first, count);
    }
    return values;
  }

  std::size_t input_count_;
  detail::LaneProgram<T, Lanes> program_;
  bool is_constant_ = false;
  T constant_ = 0;
};

}  // namespace tapestry
