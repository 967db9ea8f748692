#pragma once
#include <cfenv>
#include <span>
#include <tapestry/autodiff/detail/tape/reverse_sweep.hpp>

/// Applies the rule that a zero passes nothing on. The fast sweep leaves the rule out: it multiplies infinite
/// and NaN adjoints by zero partial derivatives. Such a product is NaN, and makes its sum NaN.
namespace tapestry::detail {
/// Whether a sweep may have multiplied an infinite adjoint or a NaN by 0: one adjoint at least is NaN. To
/// look at all adjoints would take a tenth of a sweep, so they are looked at only if an operation of this
/// thread has been invalid, as 0 · ∞ is and what made a NaN; the processor remembers that. A NaN that was
/// read is noted when it comes to the root, see note_nan(). WebAssembly remembers nothing.
template <std::floating_point T>
[[nodiscard]] bool may_hide_zeros(std::span<const T> adjoints) {
#if defined(FE_INVALID)
  if (std::fetestexcept(FE_INVALID) == 0) return false;
#endif
  for (const T adjoint : adjoints)
    if (std::isnan(adjoint)) return true;
  return false;
}

/// Makes the processor remember an invalid operation if x is NaN.
template <class T>
void note_nan([[maybe_unused]] T x) {
#if defined(FE_INVALID)
  if constexpr (std::floating_point<T>)
    if (std::isnan(x)) std::feraiseexcept(FE_INVALID);
#endif
}

/// Runs statements backwards as ReverseSweep does, but passes nothing through a zero partial derivative,
/// neither infinity nor NaN. Without such products the result equals ReverseSweep's.
template <std::floating_point T>
class CarefulSweep {
 public:
  /// As ReverseSweep::run().
  template <class PullBack, class SkipRecord>
  [[gnu::noinline, gnu::cold]] void run(const StatementRun& run, std::size_t root, T* adjoints,
                                        PullBack pull_back, SkipRecord skip_record) const {
    const StatementRun part = run_up_to<T>(root, run, [&](StatementKind kind) {
      if (kind == StatementKind::record) skip_record();
    });
    const Word* end = part.words_end;
    for (std::size_t i = part.end_index; i-- > part.first_index;) {
      const StatementKind kind = part.kinds[i - part.first_index];
      const T adjoint = adjoints[i];
      end = for_each_operand<T>(end, kind, [&](std::size_t operand, const T& partial) {
        if (adjoint == T(0) || partial == T(0)) return;
        adjoints[operand] += adjoint * partial;
      });
      if (kind == StatementKind::record) pull_back(i);
    }
  }
};
}  // namespace tapestry::detail
