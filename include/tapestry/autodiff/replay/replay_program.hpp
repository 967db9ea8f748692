#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <tapestry/autodiff/replay/growing_memory.hpp>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <vector>

namespace tapestry::detail {

/// Turns a window of statements into runs of one operation, sorted where that changes no result.
template <class T>
struct ReplayRuns {
  GrowingArray<ReplayRun<T>> runs{};  ///< from place 1 on
  std::size_t run_count = 0;
  GrowingArray<std::uint32_t> operands{};
  GrowingArray<T> constants{};

  /// \param next_slot     of the window; its slots from here on are written into their places
  /// \param next_partial  likewise
  void make(ReplayRecording<T>& recording, std::uint32_t& next_slot, std::uint32_t& next_partial) {
    const auto order = order_.of({recording.statements.data(), recording.statements.size()});
    for (const auto& given : recording.given) recording.places[given.slot] = next_slot++;
    place_ = {nullptr, 0, next_slot, 0, 0, next_partial};
    for (const std::uint32_t i : order)
      if (const std::uint32_t slot = recording.statements[i].result; slot != 0)
        recording.places[slot] = next_slot++;
    runs.clear();
    operands.clear();
    constants.clear();
    operands.append(recording.operands.size());
    constants.append(recording.constants.size());
    last_ = runs.append(recording.statements.size() + 1);  // the first is none
    *last_ = place_;
    chain_ = 0;
    for (const std::uint32_t i : order) append(recording, recording.statements[i]);
    run_count = static_cast<std::size_t>(last_ - runs.data());
    next_partial = place_.partial;
  }

 private:
  static constexpr std::uint32_t shortest_chain = 8;

  void append(const ReplayRecording<T>& recording, const typename ReplayRecording<T>::Statement& statement) {
    const auto& operation = *statement.operation;
    const std::uint32_t* const from = recording.operands.data() + statement.first_operand;
    std::uint32_t* const to = operands.data() + place_.operand;
    bool continues = operation.can_chain;
    for (std::size_t k = 0; k < operation.operand_count; ++k) {
      to[k] = recording.places[from[k]];
      continues &= (to[k] + 1 == place_.result) == (k == 0);
    }
    for (std::size_t k = 0; k < operation.constant_count; ++k)
      constants[place_.constant + k] = recording.constants[statement.first_constant + k];
    if (last_->operation != &operation || (last_->is_chain && !continues)) {
      place_.operation = &operation;
      *++last_ = place_;
      chain_ = 0;
    }
    ++last_->count;
    advance(place_, 1);
    chain_ = continues ? chain_ + 1 : 0;
    if (chain_ == shortest_chain) split_chain();
  }

  /// Splits the last statements of the last run off as a chain of their own.
  void split_chain() {
    ReplayRun<T> chain = *last_;
    advance(chain, chain.count - shortest_chain);
    last_->count -= shortest_chain;
    if (last_->count != 0) ++last_;
    chain.count = shortest_chain;
    chain.is_chain = true;
    *last_ = chain;
  }

  static void advance(ReplayRun<T>& run, std::uint32_t statements) {
    run.result += statements * static_cast<std::uint32_t>(run.operation->has_result);
    run.operand += statements * static_cast<std::uint32_t>(run.operation->operand_count);
    run.constant += statements * static_cast<std::uint32_t>(run.operation->constant_count);
    run.partial += statements * static_cast<std::uint32_t>(run.operation->partial_count);
  }

  ReplayOrder<T> order_;
  ReplayRun<T> place_{};  ///< of the next statement
  ReplayRun<T>* last_ = nullptr;
  std::uint32_t chain_ = 0;  ///< statements up to the last that continue one
};

/// A recording prepared for replay, a window at a time while it is made: statements of one operation stand
/// side by side, so that few calls run them all. Slots are numbered anew: inputs from 1 on, then for each
/// window the slots that no statement computes, then results. Copies share all constant parts.
template <class T>
class ReplayProgram {
 public:
  /// Takes a window, and writes the places of its slots into the recording.
  void append(ReplayRecording<T>& recording, ReplayRuns<T>& runs) {
    if (windows_.empty()) slot_count_ = static_cast<std::uint32_t>(recording.first_of_window);
    const std::uint32_t first = slot_count_;
    runs.make(recording, slot_count_, partial_count_);
    for (const auto& given : recording.given) given_.push_back({recording.places[given.slot], given.value});
    windows_.push_back({.runs = {lists_->runs.keep(runs.runs.data() + 1, runs.run_count), runs.run_count},
                        .operands = lists_->operands.keep(runs.operands.data(), runs.operands.size()),
                        .constants = lists_->constants.keep(runs.constants.data(), runs.constants.size()),
                        .first_given = first,
                        .given_count = static_cast<std::uint32_t>(recording.given.size())});
    statement_count_ += recording.statements.size();
    run_count_ += runs.run_count;
  }

  /// Ends the program; to be called after the last window.
  /// \param root  a slot of the recording
  void finish(const ReplayRecording<T>& recording, std::uint32_t root) {
    values_.resize(slot_count_);
    values_[0] = T(0);
    for (const auto& given : given_) values_[given.slot] = given.value;
    partials_.resize(partial_count_);
    root_ = recording.places[root];
  }

  [[nodiscard]] std::uint32_t root() const { return root_; }
  [[nodiscard]] T* values() { return values_.data(); }
  [[nodiscard]] const T* adjoints() const { return adjoints_.data(); }
  [[nodiscard]] std::size_t statement_count() const { return statement_count_; }
  [[nodiscard]] std::size_t run_count() const { return run_count_; }

  /// Computes all values from those of the inputs, and those that a sweep needs.
  void forward() {
    for (const ReplayWindow& window : windows_) {
      const ReplayArrays<T> arrays = this->arrays(window);
      for (const auto& run : window.runs) run.operation->forward(run, arrays);
    }
  }

  /// Computes all adjoints, that of the root being 1. Each run leaves those of its results zero.
  void backward(std::size_t input_count) {
    adjoints_.resize(values_.size(), T(0));
    std::fill_n(adjoints_.data(), input_count + 1, T(0));
    adjoints_[root_] = T(1);
    for (std::size_t w = windows_.size(); w-- > 0;) {
      const ReplayWindow& window = windows_[w];
      const ReplayArrays<T> arrays = this->arrays(window);
      // Adjoints of constants are cleared, not avoided: memory close by saves more than their sums cost.
      std::fill_n(adjoints_.data() + window.first_given, window.given_count, T(0));
      for (std::size_t i = window.runs.size(); i-- > 0;)
        if (const auto& run = window.runs[i]; !is_single_zero(run)) run.operation->backward(run, arrays);
    }
  }

 private:
  struct ReplayWindow {
    std::span<const ReplayRun<T>> runs;
    const std::uint32_t* operands;
    const T* constants;
    std::uint32_t first_given, given_count;  ///< slots that no statement computes
  };
  /// Lists that do not change once recorded, each in memory of its own for the sake of reading ahead.
  struct Lists {
    GrowingMemory runs{}, operands{}, constants{};
  };

  [[nodiscard]] bool is_single_zero(const ReplayRun<T>& run) const {
    return run.count == 1 && run.operation->has_result && is_zero(adjoints_[run.result]);
  }

  [[nodiscard]] ReplayArrays<T> arrays(const ReplayWindow& window) {
    return {values_.data(), adjoints_.data(), window.operands, window.constants, partials_.data(), nullptr};
  }

  std::shared_ptr<Lists> lists_ = std::make_shared<Lists>();
  std::vector<ReplayWindow> windows_;
  std::vector<typename ReplayRecording<T>::Given> given_;  ///< slots here
  HugeVector<T> partials_;
  HugeVector<T> values_;
  HugeVector<T> adjoints_;
  std::size_t statement_count_ = 0, run_count_ = 0;
  std::uint32_t slot_count_ = 0, partial_count_ = 0, root_ = 0;
};

}  // namespace tapestry::detail
