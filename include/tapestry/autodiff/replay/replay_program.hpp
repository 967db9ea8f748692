#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
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
  explicit ReplayProgram(const ReplayRecording<T>& recording) {
    const auto order = replay_order(recording);
    std::vector<std::uint32_t> slot_of(recording.slots.size(), 0);
    number_slots(recording, order, slot_of);
    const std::vector<bool> is_in_chain = find_chains(recording, order, slot_of);
    std::uint32_t result = first_result_;
    for (std::size_t place = 0; place < order.size(); ++place) {
      const auto& statement = recording.statements[order[place]];
      const auto& operation = *statement.operation;
      if (runs_.empty() || runs_.back().operation != &operation ||
          runs_.back().is_chain != is_in_chain[place])
        runs_.push_back(
            {&operation, is_in_chain[place], 0, result, operands_.size(), constants_.size(), partial_count_});
      ++runs_.back().count;
      result += operation.has_result;
      for (std::size_t i = 0; i < operation.operand_count; ++i)
        operands_.push_back(slot_of[recording.operands[statement.first_operand + i]]);
      for (std::size_t i = 0; i < operation.constant_count; ++i)
        constants_.push_back(recording.constants[statement.first_constant + i]);
      partial_count_ += operation.partial_count;
    }
    partials_.resize(partial_count_);
    new_slots_ = std::move(slot_of);
  }

  [[nodiscard]] std::uint32_t slot(std::uint32_t recorded) const { return new_slots_[recorded]; }
  [[nodiscard]] T* values() { return values_.data(); }
  [[nodiscard]] const T* adjoints() const { return adjoints_.data(); }
  [[nodiscard]] std::size_t run_count() const { return runs_.size(); }

  /// Computes all values from those of the inputs, and what a sweep needs.
  void forward() {
    const ReplayArrays<T> arrays = this->arrays();
    for (const auto& run : runs_) run.operation->forward(run, arrays);
  }

  /// Computes all adjoints, that of `root` being `seed`.
  void backward(std::uint32_t root, T seed) {
    adjoints_.resize(values_.size(), T(0));
    std::fill_n(adjoints_.data(), first_result_, T(0));  // each run leaves those of its results zero
    adjoints_[root] = seed;
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

  /// Whether the statement at each place of the order is one of several in a chain.
  static std::vector<bool> find_chains(const Recording& recording, const std::vector<std::uint32_t>& order,
                                       const std::vector<std::uint32_t>& slot_of) {
    constexpr std::size_t shortest = 8;
    std::vector<bool> is_in_chain(order.size(), false);
    const auto operation = [&](std::size_t place) { return recording.statements[order[place]].operation; };
    for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end + 1) {
      for (end = begin; end < order.size() && operation(end) == operation(begin); ++end)
        if (!continues_chain(recording, order[end], slot_of)) break;
      if (end - begin >= shortest)
        for (std::size_t place = begin; place < end; ++place) is_in_chain[place] = true;
      if (end > begin) --end;
    }
    return is_in_chain;
  }

  static bool continues_chain(const Recording& recording, std::size_t s,
                              const std::vector<std::uint32_t>& slot_of) {
    const auto& statement = recording.statements[s];
    if (!statement.operation->can_chain) return false;
    const std::uint32_t before = slot_of[statement.result] - 1;
    for (std::size_t i = 0; i < statement.operation->operand_count; ++i)
      if ((slot_of[recording.operands[statement.first_operand + i]] == before) != (i == 0)) return false;
    return true;
  }

  void number_slots(const Recording& recording, const std::vector<std::uint32_t>& order,
                    std::vector<std::uint32_t>& slot_of) {
    std::vector<bool> is_result(recording.slots.size(), false);
    for (const auto& statement : recording.statements) is_result[statement.result] = true;
    std::uint32_t next = 0;
    for (std::size_t slot = 0; slot < slot_of.size(); ++slot)
      if (slot == 0 || !is_result[slot]) slot_of[slot] = next++;
    first_result_ = next;
    for (const std::uint32_t s : order)
      if (const auto result = recording.statements[s].result; result != 0) slot_of[result] = next++;
    values_.resize(next);
    for (std::size_t slot = 0; slot < slot_of.size(); ++slot) values_[slot_of[slot]] = recording.slots[slot];
  }

  HugeVector<ReplayRun<T>> runs_;
  HugeVector<std::uint32_t> operands_;
  HugeVector<T> constants_;
  HugeVector<T> partials_;
  HugeVector<T> values_;
  HugeVector<T> adjoints_;
  std::vector<std::uint32_t> new_slots_;
  std::size_t partial_count_ = 0;
  std::uint32_t first_result_ = 0;
};

}  // namespace tapestry::detail
