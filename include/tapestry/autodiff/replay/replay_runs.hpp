#pragma once
#include <cstddef>
#include <cstdint>
#include <tapestry/autodiff/replay/growing_memory.hpp>
#include <tapestry/autodiff/replay/replay_recording.hpp>

namespace tapestry::detail {

/// Makes a window of statements into runs of one operation, sorted where that changes no result.
template <class T>
struct ReplayRuns {
  GrowingArray<ReplayRun<T>> runs{};  ///< from place 1 on
  std::size_t run_count = 0;
  GrowingArray<std::uint32_t> operands{};
  GrowingArray<T> constants{};

  /// \param next_slot     of the window, whose slots from here on are written into their places
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

  /// Makes the last statements of the last run a chain of their own.
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

}  // namespace tapestry::detail
