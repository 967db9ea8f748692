#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <utility>
#include <vector>

namespace tapestry::detail {

/// A recording made ready: statements of one operation side by side where that changes no result, so that few
/// calls run them all. Slots are numbered anew: first those that no statement computes, then results.
template <class T>
class ReplayProgram {
 public:
  ReplayProgram() = default;
  /// \param root  a slot of the recording
  ReplayProgram(const ReplayRecording<T>& recording, std::uint32_t root) {
    HugeVector<std::uint32_t> slot_of = number_given(recording);
    operands_.reserve(recording.operands.size());
    constants_.reserve(recording.constants.size());
    ReplayOrder<T> order(recording);
    std::uint32_t next = first_result_;
    for (auto window = order.next(); !window.empty(); window = order.next()) {
      std::uint32_t result = next;
      for (const std::uint32_t s : window)
        if (const std::uint32_t slot = recording.statements[s].result; slot != 0) slot_of[slot] = next++;
      const std::vector<char> is_in_chain = find_chains(recording, window, slot_of);
      for (std::size_t i = 0; i < window.size(); ++i)
        append(recording, recording.statements[window[i]], static_cast<bool>(is_in_chain[i]), slot_of,
               result);
    }
    values_.resize(next);
    for (std::size_t slot = 0; slot < slot_of.size(); ++slot)
      if (slot_of[slot] < first_result_) values_[slot_of[slot]] = recording.slots[slot];
    partials_.resize(partial_count_);
    root_ = slot_of[root];
  }

  [[nodiscard]] std::uint32_t root() const { return root_; }
  [[nodiscard]] T* values() { return values_.data(); }
  [[nodiscard]] const T* adjoints() const { return adjoints_.data(); }
  [[nodiscard]] std::size_t run_count() const { return runs_.size(); }

  /// Computes all values from those of the inputs, and what a sweep needs.
  void forward() {
    const ReplayArrays<T> arrays = this->arrays();
    for (const auto& run : runs_) run.operation->forward(run, arrays);
  }

  /// Computes all adjoints, that of the root being 1.
  void backward() {
    adjoints_.resize(values_.size(), T(0));
    std::fill_n(adjoints_.data(), first_result_, T(0));  // each run leaves those of its results zero
    adjoints_[root_] = T(1);
    const ReplayArrays<T> arrays = this->arrays();
    for (std::size_t i = runs_.size(); i-- > 0;)
      if (const auto& run = runs_[i]; !is_single_zero(run)) run.operation->backward(run, arrays);
  }

 private:
  [[nodiscard]] bool is_single_zero(const ReplayRun<T>& run) const {
    return run.count == 1 && run.operation->has_result && is_zero(adjoints_[run.result]);
  }

  [[nodiscard]] ReplayArrays<T> arrays() {
    return {values_.data(), adjoints_.data(), operands_.data(), constants_.data(), partials_.data(), nullptr};
  }

  using Recording = ReplayRecording<T>;

  /// Numbers the slots that no statement computes; others are 0.
  HugeVector<std::uint32_t> number_given(const Recording& recording) {
    HugeVector<std::uint32_t> slot_of(recording.slots.size(), 0);
    for (const auto& statement : recording.statements) slot_of[statement.result] = 1;  // is computed
    for (std::size_t slot = 0; slot < slot_of.size(); ++slot)
      slot_of[slot] = slot == 0 || slot_of[slot] == 0 ? first_result_++ : 0;
    return slot_of;
  }

  /// \param result  slot of the next result
  void append(const Recording& recording, const typename Recording::Statement& statement, bool is_in_chain,
              const HugeVector<std::uint32_t>& slot_of, std::uint32_t& result) {
    const auto& operation = *statement.operation;
    if (runs_.empty() || runs_.back().operation != &operation || runs_.back().is_chain != is_in_chain)
      runs_.push_back({.operation = &operation,
                       .count = 0,
                       .result = result,
                       .operand = static_cast<std::uint32_t>(operands_.size()),
                       .constant = static_cast<std::uint32_t>(constants_.size()),
                       .partial = partial_count_,
                       .is_chain = is_in_chain});
    ++runs_.back().count;
    result += operation.has_result;
    for (std::size_t i = 0; i < operation.operand_count; ++i)
      operands_.push_back(slot_of[recording.operands[statement.first_operand + i]]);
    for (std::size_t i = 0; i < operation.constant_count; ++i)
      constants_.push_back(recording.constants[statement.first_constant + i]);
    partial_count_ += static_cast<std::uint32_t>(operation.partial_count);
  }

  /// Whether each statement of a window is one of several in a chain.
  static std::vector<char> find_chains(const Recording& recording, std::span<const std::uint32_t> window,
                                       const HugeVector<std::uint32_t>& slot_of) {
    constexpr std::size_t shortest = 8;
    std::vector<char> is_in_chain(window.size(), false);
    const auto operation = [&](std::size_t i) { return recording.statements[window[i]].operation; };
    for (std::size_t begin = 0, end = 0; begin < window.size(); begin = end + 1) {
      for (end = begin; end < window.size() && operation(end) == operation(begin); ++end)
        if (!continues_chain(recording, window[end], slot_of)) break;
      if (end - begin >= shortest)
        for (std::size_t i = begin; i < end; ++i) is_in_chain[i] = true;
      if (end > begin) --end;
    }
    return is_in_chain;
  }

  static bool continues_chain(const Recording& recording, std::size_t s,
                              const HugeVector<std::uint32_t>& slot_of) {
    const auto& statement = recording.statements[s];
    if (!statement.operation->can_chain) return false;
    const std::uint32_t before = slot_of[statement.result] - 1;
    for (std::size_t i = 0; i < statement.operation->operand_count; ++i)
      if ((slot_of[recording.operands[statement.first_operand + i]] == before) != (i == 0)) return false;
    return true;
  }

  HugeVector<ReplayRun<T>> runs_;
  HugeVector<std::uint32_t> operands_;
  HugeVector<T> constants_;
  HugeVector<T> partials_;
  HugeVector<T> values_;
  HugeVector<T> adjoints_;
  std::uint32_t partial_count_ = 0;
  std::uint32_t first_result_ = 0;
  std::uint32_t root_ = 0;
};

}  // namespace tapestry::detail
