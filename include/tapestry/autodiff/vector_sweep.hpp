#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/statement.hpp>
#include <tapestry/autodiff/tape_memory.hpp>

namespace tapestry::detail {

/// Runs statements backwards for Width seeds at once; see ReverseSweep. The adjoints of statement i begin at
/// i · Width. Records, which take one seed at a time, are passed over.
template <std::floating_point T, std::size_t Width>
requires(Width > 1 && (Width & (Width - 1)) == 0) class VectorSweep {
 public:
  /// \param adjoints  aligned to Width · sizeof(T)
  static void run(const StatementRun& run, std::size_t root, T* adjoints) {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
      return run_avx512(run, root, adjoints);
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return run_avx2(run, root, adjoints);
#endif
    sweep(run, root, adjoints);
  }

 private:
  using Lanes [[gnu::vector_size(Width * sizeof(T)), gnu::may_alias]] = T;

#if defined(__x86_64__)
  [[gnu::target("avx512f,avx512dq,avx512vl,avx2,fma")]] static void run_avx512(const StatementRun& run,
                                                                               std::size_t root,
                                                                               T* adjoints) {
    sweep(run, root, adjoints);
  }
  [[gnu::target("avx2,fma")]] static void run_avx2(const StatementRun& run, std::size_t root, T* adjoints) {
    sweep(run, root, adjoints);
  }
#endif

  [[gnu::always_inline]] static inline void sweep(const StatementRun& run, std::size_t root, T* adjoints) {
    auto* const lanes = reinterpret_cast<Lanes*>(adjoints);
    const Word* words = run.words_end;
    for (std::size_t index = run.end_index; index-- > run.first_index;) {
      const StatementKind kind = run.kinds[index - run.first_index];
      const Word* const end = words;
      words -= words_before<T>(end, kind);
      if (index > root || kind == StatementKind::input || kind == StatementKind::record) continue;
      const OperandCounts counts =
          kind == StatementKind::many_pairs ? OperandCounts{0, 0, end[-1]} : counts_of(kind);
      const Lanes adjoint = lanes[index];
      const Word* operand = words;
      for (std::size_t i = 0; i < counts.general; ++i, operand += pair_words<T>) {
        const Lanes product = adjoint * partial_of_pair<T>(operand);
        lanes[index_of_pair<T>(operand)] += adjoint == Lanes{} ? Lanes{} : product;
      }
      for (std::size_t i = 0; i < counts.plus; ++i) lanes[*operand++] += adjoint;
      for (std::size_t i = 0; i < counts.minus; ++i) lanes[*operand++] -= adjoint;
    }
  }
};

}  // namespace tapestry::detail
