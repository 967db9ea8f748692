#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/replay/replay_runs.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <vector>

namespace tapestry::detail {

/// A recording made ready, a window at a time while it is made: statements of one operation side by side, so
/// that few calls run them all. Slots are numbered anew: inputs from 1 on, then of each window what no
/// statement computes, then results. Copies share what does not change.
template <class T>
class ReplayProgram {
 public:
  /// Takes a window, and tells the recording the places of its slots.
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

  /// To be called behind the last window.
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

  /// Computes all values from those of the inputs, and what a sweep needs.
  void forward() {
    for (const Window& window : windows_) {
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
      const Window& window = windows_[w];
      const ReplayArrays<T> arrays = this->arrays(window);
      // What reaches adjoints of constants is forgotten; that they are near soon saves more than it costs.
      std::fill_n(adjoints_.data() + window.first_given, window.given_count, T(0));
      for (std::size_t i = window.runs.size(); i-- > 0;)
        if (const auto& run = window.runs[i]; !is_single_zero(run)) run.operation->backward(run, arrays);
    }
  }

 private:
  struct Window {
    std::span<const ReplayRun<T>> runs;
    const std::uint32_t* operands;
    const T* constants;
    std::uint32_t first_given, given_count;  ///< slots that no statement computes
  };
  /// What does not change once it is recorded, each in memory of its own for the sake of reading ahead.
  struct Lists {
    GrowingMemory runs{}, operands{}, constants{};
  };

  [[nodiscard]] bool is_single_zero(const ReplayRun<T>& run) const {
    return run.count == 1 && run.operation->has_result && is_zero(adjoints_[run.result]);
  }

  [[nodiscard]] ReplayArrays<T> arrays(const Window& window) {
    return {values_.data(), adjoints_.data(), window.operands, window.constants, partials_.data(), nullptr};
  }

  std::shared_ptr<Lists> lists_ = std::make_shared<Lists>();
  std::vector<Window> windows_;
  std::vector<typename ReplayRecording<T>::Given> given_;  ///< slots here
  HugeVector<T> partials_;
  HugeVector<T> values_;
  HugeVector<T> adjoints_;
  std::size_t statement_count_ = 0, run_count_ = 0;
  std::uint32_t slot_count_ = 0, partial_count_ = 0, root_ = 0;
};

}  // namespace tapestry::detail
