#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/tape/pull_visitor.hpp>
#include <tapestry/autodiff/tape/reverse_sweep.hpp>
#include <tapestry/autodiff/tape/statement.hpp>
#include <tapestry/autodiff/tape/statement_walk.hpp>
#include <tapestry/autodiff/tape/tape_memory.hpp>
#include <tapestry/autodiff/tape/vector_adjoints.hpp>
#include <tapestry/core/instruction_set.hpp>

namespace tapestry::detail {

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
#if defined(__x86_64__)
    switch (instruction_set()) {
      case InstructionSet::avx512:
        return run_avx512(part, adjoints, pull_back);
      case InstructionSet::avx2:
        return run_avx2(part, adjoints, pull_back);
      default:
        break;
    }
#endif
    sweep(part, adjoints, pull_back);
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

#if defined(__x86_64__)
  template <class PullBack>
  [[gnu::target("avx512f,avx512dq,avx512vl,avx2,fma")]] static void run_avx512(
      const StatementRun& run, VectorAdjoints<Scalar, Width>& adjoints, PullBack& pull_back) {
    sweep(run, adjoints, pull_back);
  }
  template <class PullBack>
  [[gnu::target("avx2,fma")]] static void run_avx2(const StatementRun& run,
                                                   VectorAdjoints<Scalar, Width>& adjoints,
                                                   PullBack& pull_back) {
    sweep(run, adjoints, pull_back);
  }
#endif

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
