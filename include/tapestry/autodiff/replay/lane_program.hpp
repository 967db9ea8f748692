#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <vector>

namespace tapestry::detail {

/// A recording prepared for several inputs at once, in the order of ReplayProgram, so that sums have the same
/// bits. Some results are computed twice, because that is faster than memory. If a result is cheap and read
/// only within its window of statements, it has a slot in that window only; each window uses these slots
/// anew, and the backward pass computes the result again. Where nearly every statement waits for the one
/// before, waiting takes longer than memory, and all results are kept.
template <class T, std::size_t Lanes>
class LaneProgram {
 public:
  LaneProgram() = default;
  /// \param root  a slot of the recording, whose value is kept
  LaneProgram(const ReplayRecording<T>& recording, std::uint32_t root) {
    const auto order = replay_order(recording);
    const std::vector<bool> is_kept = find_kept(recording, order, root);
    const std::vector<bool> is_needed = find_needed(recording, order, is_kept);
    HugeVector<std::uint32_t> slot_of = number_kept(recording, order, is_kept);
    root_ = slot_of[root];
    operands_.reserve(recording.operands.size());
    constants_.reserve(recording.constants.size());
    for (std::size_t place = 0; place < order.size(); ++place) {
      if (place % replay_window == 0) {
        windows_.push_back(runs_.size());
        next_of_window_ = kept_count_;
      }
      append(recording, recording.statements[order[place]], is_kept, is_needed, slot_of);
    }
    windows_.push_back(runs_.size());
    values_.resize(std::size_t(slot_count_) * Lanes, T(0));
    partials_.resize(std::size_t(partial_count_) * Lanes);
    for (const auto& given : recording.given)
      std::fill_n(values_.data() + slot_of[given.slot] * Lanes, Lanes, given.value);
  }

  /// Values of input i in all lanes; it has slot i + 1.
  [[nodiscard]] std::span<T, Lanes> input(std::size_t i) {
    return std::span<T, Lanes>(values_.data() + (i + 1) * Lanes, Lanes);
  }
  [[nodiscard]] std::span<const T, Lanes> input_adjoint(std::size_t i) const {
    return std::span<const T, Lanes>(adjoints_.data() + (i + 1) * Lanes, Lanes);
  }
  [[nodiscard]] std::span<const T, Lanes> root() const {
    return std::span<const T, Lanes>(values_.data() + root_ * Lanes, Lanes);
  }
  [[nodiscard]] std::span<const bool, Lanes> refused() const { return refused_; }

  /// Computes all values from those of the inputs.
  void forward() {
    refused_.fill(false);
    const ReplayArrays<T> arrays = this->arrays();
    for (const Run& run : runs_) run.operation->forward(run, arrays);
  }

  /// Computes the adjoints of so many inputs, that of the root being 1. If they are finite, they have met no
  /// infinite partial derivative, and the loops without a branch were enough.
  void backward(std::size_t input_count) {
    sweep(&ReplayOperation<T>::backward);
    const T* const adjoints = adjoints_.data() + Lanes;
    if (std::any_of(adjoints, adjoints + input_count * Lanes, [](T adjoint) { return adjoint != adjoint; }))
      sweep(&ReplayOperation<T>::backward_with_care);
  }

 private:
  using Recording = ReplayRecording<T>;
  using Run = ReplayRun<T>;

  [[nodiscard]] ReplayArrays<T> arrays() {
    return {values_.data(),    adjoints_.data(), operands_.data(),
            constants_.data(), partials_.data(), refused_.data()};
  }

  template <class Sweep>
  void sweep(Sweep ReplayOperation<T>::*backward) {
    adjoints_.resize(values_.size(), T(0));
    std::fill_n(adjoints_.data(), first_result_ * Lanes, T(0));  // each run leaves those of its results zero
    std::fill_n(adjoints_.data() + root_ * Lanes, Lanes, T(1));
    const ReplayArrays<T> arrays = this->arrays();
    for (std::size_t window = windows_.size() - 1; window-- > 0;) {
      const std::span<const Run> runs(runs_.data() + windows_[window],
                                      windows_[window + 1] - windows_[window]);
      for (const Run& run : runs)
        if (run.is_needed) run.operation->forward(run, arrays);
      for (std::size_t i = runs.size(); i-- > 0;) (runs[i].operation->*backward)(runs[i], arrays);
    }
  }

  /// For each recorded slot, whether its value must outlive its window.
  static std::vector<bool> find_kept(const Recording& recording, const HugeVector<std::uint32_t>& order,
                                     std::uint32_t root) {
    std::vector<std::size_t> window_of(recording.slot_count(), order.size());
    std::vector<bool> is_kept(recording.slot_count(), true);
    bool keeps_all = false;
    for (std::size_t place = 0; place < order.size(); ++place) {
      const auto& statement = recording.statements[order[place]];
      const std::size_t window = place / replay_window;
      if (place % replay_window == 0) keeps_all = has_short_runs(recording, order, place);
      for (std::size_t i = 0; i < statement.operation->operand_count; ++i) {
        const std::uint32_t slot = recording.operands[statement.first_operand + i];
        if (window_of[slot] != window) is_kept[slot] = true;
      }
      if (statement.result == 0) continue;
      window_of[statement.result] = window;
      is_kept[statement.result] = keeps_all || !statement.operation->is_cheap || statement.result == root;
    }
    return is_kept;
  }

  /// Whether the window from `begin` on has runs of less than two statements, taken together.
  static bool has_short_runs(const Recording& recording, const HugeVector<std::uint32_t>& order,
                             std::size_t begin) {
    const std::size_t end = std::min(begin + replay_window, order.size());
    std::size_t runs = 1;
    for (std::size_t place = begin + 1; place < end; ++place)
      runs +=
          recording.statements[order[place]].operation != recording.statements[order[place - 1]].operation;
    return 2 * runs > end - begin;
  }

  /// For each recorded slot that is not kept, whether the backward pass reads it or a value computed from it.
  static std::vector<bool> find_needed(const Recording& recording, const HugeVector<std::uint32_t>& order,
                                       const std::vector<bool>& is_kept) {
    std::vector<bool> is_needed(recording.slot_count(), false);
    for (std::size_t place = order.size(); place-- > 0;) {
      const auto& statement = recording.statements[order[place]];
      const bool again = statement.result != 0 && is_needed[statement.result];
      if (!again && !statement.operation->reads_operands) continue;
      for (std::size_t i = 0; i < statement.operation->operand_count; ++i) {
        const std::uint32_t slot = recording.operands[statement.first_operand + i];
        if (!is_kept[slot]) is_needed[slot] = true;
      }
    }
    return is_needed;
  }

  /// Numbers the kept slots: first those that no statement computes.
  HugeVector<std::uint32_t> number_kept(const Recording& recording, const HugeVector<std::uint32_t>& order,
                                        const std::vector<bool>& is_kept) {
    std::vector<bool> is_result(recording.slot_count(), false);
    for (const auto& statement : recording.statements) is_result[statement.result] = true;
    HugeVector<std::uint32_t> slot_of(recording.slot_count(), 0);
    for (std::size_t slot = 0; slot < slot_of.size(); ++slot)
      if (slot == 0 || !is_result[slot]) slot_of[slot] = kept_count_++;
    first_result_ = kept_count_;
    for (const std::uint32_t s : order)
      if (const auto result = recording.statements[s].result; result != 0 && is_kept[result])
        slot_of[result] = kept_count_++;
    slot_count_ = kept_count_;
    return slot_of;
  }

  void append(const Recording& recording, const typename Recording::Statement& statement,
              const std::vector<bool>& is_kept, const std::vector<bool>& is_needed,
              HugeVector<std::uint32_t>& slot_of) {
    const auto& operation = *statement.operation;
    if (statement.result != 0 && !is_kept[statement.result]) {
      slot_of[statement.result] = next_of_window_++;
      slot_count_ = std::max(slot_count_, next_of_window_);
    }
    const std::uint32_t result = slot_of[statement.result];
    const bool again = statement.result != 0 && is_needed[statement.result];
    if (runs_.size() == windows_.back() || runs_.back().operation != &operation ||
        runs_.back().is_needed != again ||
        (operation.has_result && runs_.back().result + runs_.back().count != result))
      runs_.push_back({.operation = &operation,
                       .count = 0,
                       .result = result,
                       .operand = static_cast<std::uint32_t>(operands_.size()),
                       .constant = static_cast<std::uint32_t>(constants_.size()),
                       .partial = partial_count_,
                       .is_needed = again});
    ++runs_.back().count;
    for (std::size_t i = 0; i < operation.operand_count; ++i)
      operands_.push_back(slot_of[recording.operands[statement.first_operand + i]]);
    for (std::size_t i = 0; i < operation.constant_count; ++i)
      constants_.push_back(recording.constants[statement.first_constant + i]);
    partial_count_ += static_cast<std::uint32_t>(operation.partial_count);
  }

  HugeVector<Run> runs_;
  std::vector<std::size_t> windows_;  ///< first run of each, and the end
  HugeVector<std::uint32_t> operands_;
  HugeVector<T> constants_;
  HugeVector<T> partials_;
  HugeVector<T> values_;  ///< [slot, Lanes]: kept ones, then those of a window
  HugeVector<T> adjoints_;
  std::array<bool, Lanes> refused_{};
  std::uint32_t partial_count_ = 0, kept_count_ = 0, slot_count_ = 0, next_of_window_ = 0, first_result_ = 0,
                root_ = 0;
};

}  // namespace tapestry::detail
