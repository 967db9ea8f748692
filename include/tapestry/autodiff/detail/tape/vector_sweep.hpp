#pragma once
#include <span>
#include <tapestry/autodiff/detail/tape/reverse_sweep.hpp>
#include <tapestry/autodiff/detail/tape/tape_record.hpp>
#include <tapestry/autodiff/detail/tape/vector_adjoints.hpp>

namespace tapestry::detail {
/// Runs the pullbacks of a tape's records in a sweep of several roots: one root after the other, each with
/// adjoints of its own, which are copied out of the vectors and back. Array adjoints are in lanes from 1 on.
template <std::floating_point T, std::size_t Width>
class VectorPullbacks {
 public:
  /// \param lane_count  roots, at most Width; \param attachment  keeper of array adjoints, or null
  VectorPullbacks(std::span<const HeldRecord<T>> records, std::size_t lane_count, std::size_t last,
                  TapeAttachment* attachment, VectorAdjoints<T, Width>& adjoints)
      : records_(records),
        next_(records.size()),
        lane_count_(lane_count),
        attachment_(attachment),
        adjoints_(adjoints) {
    if (records.empty()) return;
    for_each_lane(Width, [&](std::size_t) {
      for (const HeldRecord<T>& held : records_) held.record->forget_adjoint();
    });
    std::size_t most_results = 0;
    for (const HeldRecord<T>& held : records_)
      if (held.results > most_results) most_results = held.results;
    std::size_t bytes = (last + 1 + most_results) * sizeof(T);
    memory_ = allocate_pages(bytes);
  }
  VectorPullbacks(const VectorPullbacks&) = delete;
  VectorPullbacks& operator=(const VectorPullbacks&) = delete;
  ~VectorPullbacks() { select(0); }

  void skip() { --next_; }

  /// Runs the previous record, the one of this statement.
  void run(std::size_t statement) {
    const HeldRecord<T>& held = records_[--next_];
    inputs_.clear();
    held.record->list_inputs(inputs_);
    const auto view = adjoints_.view();
    T* const single = reinterpret_cast<T*>(memory_.get());
    for_each_lane(lane_count_, [&](std::size_t lane) {
      if (inputs_.empty() && lane > 0) return;  // a place to come by
      single[statement] = view.in_window(statement)[lane];
      for (std::size_t i = statement + 1; i <= statement + held.results; ++i) {
        const T* const all = adjoints_.passed(i);
        single[i] = all == nullptr ? T(0) : all[lane];
      }
      for (const std::uint32_t i : inputs_) single[i] = view.at(i, adjoints_)[lane];
      held.record->pull_back(single, statement);
      for (const std::uint32_t i : inputs_) view.at(i, adjoints_)[lane] = single[i];
    });
  }

 private:
  void select(std::size_t lane) const {
    if (attachment_ != nullptr) attachment_->select_lane(lane);
  }
  template <class Visit>
  void for_each_lane(std::size_t count, Visit visit) const {
    for (std::size_t lane = 0; lane < count; ++lane) {
      select(lane + 1);
      visit(lane);
    }
    select(0);
  }

  std::span<const HeldRecord<T>> records_;
  std::size_t next_;
  std::size_t lane_count_;
  TapeAttachment* attachment_;
  VectorAdjoints<T, Width>& adjoints_;
  PageMemory memory_;  // adjoints of one lane, of those statements that a record is about to use
  std::vector<std::uint32_t> inputs_;
};

/// Runs statements backwards for Width seeds at once; see ReverseSweep.
template <std::floating_point Scalar, std::size_t Width>
class VectorSweep {
 public:
  /// The statements of `run` up to `root`. Calls pull_back(index) for each record, skip_record() for each
  /// behind the root.
  template <class PullBack, class SkipRecord>
  static void run(const StatementRun& run, std::size_t root, VectorAdjoints<Scalar, Width>& adjoints,
                  PullBack pull_back, SkipRecord skip_record) {
    const StatementRun part = run_up_to<Scalar>(root, run, [&](StatementKind kind) {
      if (kind == StatementKind::record) skip_record();
    });
    const auto body = [&](auto) __attribute__((always_inline)) { sweep(part, adjoints, pull_back); };
    run_with(instruction_set(), body);
  }

 private:
  using Lanes[[
    gnu::vector_size(Width * sizeof(Scalar)), gnu::may_alias,
    gnu::aligned(Width * sizeof(Scalar) < 64 ? Width * sizeof(Scalar) : 64)
  ]] = Scalar;

  struct Adjoints {
    using T = Scalar;
    using Value = Lanes;
    using Memory = VectorAdjoints<Scalar, Width>;
    Memory& memory;
    typename Memory::View view = memory.view();
    bool is_touched = true;  ///< whether the block at hand may have an adjoint that is not zero

    [[gnu::always_inline]] Lanes& own(Word index) { return as_lanes(view.in_window(index)); }
    [[gnu::always_inline]] Lanes& of(Word operand) { return as_lanes(view.at(operand, memory)); }
    [[gnu::always_inline]] static bool is_zero(const Lanes& adjoint) {
      if (adjoint[0] != T(0)) [[likely]]
        return false;
      for (std::size_t k = 1; k < Width; ++k)
        if (adjoint[k] != T(0)) return false;
      return true;
    }
    [[gnu::always_inline]] static void add_product(Lanes& sum, const Lanes& adjoint, T partial) {
      if (partial == T(0)) [[unlikely]]
        return;
      const Lanes added = sum + adjoint * partial;
      sum = adjoint == Lanes{} ? sum : added;
    }
    [[gnu::always_inline]] void pass(Word index) {
      if (index % Memory::block == 0) [[unlikely]]
        leave(index);
    }
    [[gnu::always_inline]] void pass_many(Word index) {
      touch();
      leave(index);
      touch();
    }
    [[gnu::always_inline]] void touch() { is_touched = true; }
    [[gnu::always_inline]] void leave(Word index) {
      memory.pass(index, is_touched);
      view = memory.view();
      is_touched = false;
    }
    [[gnu::always_inline]] static Lanes& as_lanes(T* adjoints) { return *reinterpret_cast<Lanes*>(adjoints); }
  };

  template <class PullBack>
  [[gnu::always_inline]] static inline void sweep(const StatementRun& run,
                                                  VectorAdjoints<Scalar, Width>& adjoints,
                                                  PullBack& pull_back) {
    using Visitor = PullVisitor<Adjoints, PullBack>;
    Visitor visitor{{adjoints}, run.end_index, pull_back};
    StatementWalk<Scalar, Visitor>::run(run.words_end, run.kinds + (run.end_index - run.first_index),
                                        visitor);
  }
};
}  // namespace tapestry::detail
