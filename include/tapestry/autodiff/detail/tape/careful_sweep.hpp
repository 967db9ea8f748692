#pragma once
#include <cfenv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <span>
#include <tapestry/autodiff/detail/tape/reverse_sweep.hpp>
#include <tapestry/autodiff/detail/tape/statement.hpp>
#include <tapestry/autodiff/detail/tape/tape_memory.hpp>

/// The rule that a zero passes nothing, where the fast sweep leaves it out: it multiplies infinite adjoints
/// by zero partial derivatives. Such a product is NaN, and so is what it is added to.
namespace tapestry::detail {

/// Whether a sweep may have multiplied an infinite adjoint by 0: one adjoint at least is NaN. To look at all
/// adjoints would take a tenth of a sweep, so they are looked at only if an operation of this thread has been
/// invalid, as 0 · ∞ is; the processor remembers that.
template <std::floating_point T>
[[nodiscard]] bool may_hide_zeros(std::span<const T> adjoints) {
  if (std::fetestexcept(FE_INVALID) == 0) return false;
  for (const T adjoint : adjoints)
    if (std::isnan(adjoint)) return true;
  return false;
}

/// Runs statements backwards as ReverseSweep does, but passes no infinite adjoint through a zero partial
/// derivative. NaN stays NaN: the result is that of ReverseSweep where no such product occurs.
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
        if (adjoint == T(0) || (partial == T(0) && !std::isnan(adjoint))) return;
        adjoints[operand] += adjoint * partial;
      });
      if (kind == StatementKind::record) pull_back(i);
    }
  }
};

}  // namespace tapestry::detail
