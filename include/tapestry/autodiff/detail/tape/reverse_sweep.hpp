#pragma once
#include <tapestry/autodiff/detail/tape/pull_visitor.hpp>
#include <tapestry/autodiff/detail/tape/scalar.hpp>
#include <tapestry/autodiff/detail/tape/statement_walk.hpp>
#include <tapestry/autodiff/detail/tape/tape_memory.hpp>
#include <tapestry/core/instruction_set.hpp>

namespace tapestry::detail {
/// Adjoints of all statements; keeps its memory from sweep to sweep.
template <class T>
class AdjointMemory {
 public:
  AdjointMemory() = default;
  AdjointMemory(const AdjointMemory&) = delete;
  AdjointMemory& operator=(const AdjointMemory&) = delete;

  /// Adjoints of statements 0 to `last`, all zero.
  /// \throws Error if there is no memory for them
  void zero(std::size_t last) {
    const std::size_t count = last + 1;
    if (count > capacity_) grow(count);
    std::memset(static_cast<void*>(memory_.get()), 0, count * sizeof(T));
    size_ = count;
  }
  /// Reserves memory for adjoints, and forgets the present ones.
  void reserve(std::size_t count) {
    if (count <= capacity_) return;
    grow(count);
    std::memset(static_cast<void*>(memory_.get()), 0, count * sizeof(T));
  }
  /// Forgets the adjoints of statements from `size` on.
  void truncate(std::size_t size) noexcept {
    if (size < size_) size_ = size;
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] T* data() noexcept { return reinterpret_cast<T*>(memory_.get()); }
  [[nodiscard]] const T* data() const noexcept { return reinterpret_cast<const T*>(memory_.get()); }

 private:
  void grow(std::size_t count) {
    const std::size_t grown = capacity_ + capacity_ / 2;
    std::size_t size = (count > grown ? count : grown) * sizeof(T);
    memory_ = PageMemory();
    capacity_ = size_ = 0;
    try {
      memory_ = allocate_pages(size);
    } catch (const std::bad_alloc&) {
      throw Error(ErrorKind::limit, {"reverse: no memory for ", size, " bytes, the adjoints of ", count,
                                     " statements; checkpoint() records a part only while it is swept"});
    }
    capacity_ = size / sizeof(T);
  }

  PageMemory memory_;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

/// The part of a run of statements up to `root`; calls skip(kind) for each behind it.
template <class T, class Skip>
[[nodiscard]] StatementRun run_up_to(std::size_t root, const StatementRun& run, Skip skip) {
  StatementRun part = run;
  while (part.end_index > part.first_index && part.end_index > root + 1) {
    const StatementKind kind = part.kinds[--part.end_index - part.first_index];
    part.words_end -= words_before<T>(part.words_end, kind);
    skip(kind);
  }
  return part;
}

/// sum + factor · partial, rounded once if IsFused; of duals by chain().
template <bool IsFused, class T>
[[nodiscard, gnu::always_inline]] inline T add_product(const T& sum, const T& factor, const T& partial) {
  if constexpr (IsFused && std::same_as<T, double>) {
    return __builtin_fma(factor, partial, sum);
  } else if constexpr (IsFused && std::same_as<T, float>) {
    return __builtin_fmaf(factor, partial, sum);
  } else if constexpr (std::floating_point<T>) {
    return sum + factor * partial;
  } else {
    return sum + chain(factor, partial);
  }
}

template <class Scalar>
class ReverseSweep {
 public:
  /// The statements of `run` up to `root`. Calls pull_back(index) for each record, skip_record() for each
  /// behind the root.
  template <class PullBack, class SkipRecord>
  void run(const StatementRun& run, std::size_t root, Scalar* adjoints, PullBack pull_back,
           SkipRecord skip_record) const {
    const StatementRun part = run_up_to<Scalar>(root, run, [&](StatementKind kind) {
      if (kind == StatementKind::record) skip_record();
    });
#if (defined(__x86_64__) || defined(__aarch64__)) && !defined(TAPESTRY_ONE_INSTRUCTION_SET)
    if constexpr (std::floating_point<Scalar>)
      if (instruction_set() != InstructionSet::portable) return sweep_fused(part, adjoints, pull_back);
#endif
    constexpr bool is_fused = plain_instruction_set != InstructionSet::portable;
    sweep<is_fused && std::floating_point<Scalar>>(part, adjoints, pull_back);
  }

 private:
  template <bool IsFused>
  struct Adjoints {
    using T = Scalar;
    using Value = Scalar;
    T* adjoints;
    [[gnu::always_inline]] T& own(Word index) const { return adjoints[index]; }
    [[gnu::always_inline]] T& of(Word operand) const { return adjoints[operand]; }
    [[gnu::always_inline]] static bool is_zero(const T& adjoint) { return detail::is_zero(adjoint); }
    [[gnu::always_inline]] static void add_product(T& sum, const T& adjoint, const T& partial) {
      sum = detail::add_product<IsFused>(sum, adjoint, partial);
    }
    [[gnu::always_inline]] static void touch() {}
    [[gnu::always_inline]] static void pass(Word) {}
    [[gnu::always_inline]] static void pass_many(Word) {}
  };

  template <bool IsFused, class PullBack>
  [[gnu::always_inline]] static void sweep(const StatementRun& run, Scalar* adjoints, PullBack& pull_back) {
    using Visitor = PullVisitor<Adjoints<IsFused>, PullBack>;
    Visitor visitor{{adjoints}, run.end_index, pull_back};
    StatementWalk<Scalar, Visitor>::run(run.words_end, run.kinds + (run.end_index - run.first_index),
                                        visitor);
  }
  template <class PullBack>
#if defined(__x86_64__)
  [[gnu::target("avx2,fma")]]
#endif
  static void
  sweep_fused(const StatementRun& run, Scalar* adjoints, PullBack& pull_back) {
    sweep<true>(run, adjoints, pull_back);
  }
};
}  // namespace tapestry::detail
