#pragma once
#include <tapestry/autodiff/detail/tape/tape_memory.hpp>

namespace tapestry::detail {
// State with one copy a program is visible everywhere ([[gnu::visibility("default")]]), even if a shared
// library hides its symbols: functions of one library may replace another's, and need the same tape.

/// The head of threads without an active tape: no variable has its generation, and it has no room.
template <class T>
[[gnu::visibility("default")]] inline constinit WriteHead no_tape{nullptr, nullptr, Link(0, no_generation),
                                                                  0};
/// The same for threads whose tape is swept.
template <class T>
[[gnu::visibility("default")]] inline constinit WriteHead swept_tape{nullptr, nullptr, Link(0, no_generation),
                                                                     0};
/// The same for threads whose scopes ended out of order.
template <class T>
[[gnu::visibility("default")]] inline constinit WriteHead disordered_tapes{nullptr, nullptr,
                                                                           Link(0, no_generation), 0};

/// Names the reason why a thread with this head records nothing.
template <class T>
[[noreturn]] void throw_inactive(const WriteHead* head) {
  if (head == &disordered_tapes<T>)
    throw DomainError(
        "scopes of Tape::activate() have ended out of order: end that which began last first, on the thread "
        "that began it; no tape is active here until all scopes of this thread have ended");
  if (head == &swept_tape<T>)
    throw DomainError(
        "an operation on an active variable cannot be recorded while reverse() sweeps its tape: "
        "a pullback, or a function that is computed again, takes values, or activates a tape of its own");
  throw DomainError(
      "an operation on an active variable needs an active tape: keep the result of "
      "Tape::activate() alive on this thread");
}
}  // namespace tapestry::detail
