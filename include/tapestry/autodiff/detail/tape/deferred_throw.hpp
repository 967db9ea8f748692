#pragma once
#include <exception>
#include <utility>

namespace tapestry::detail {
// Calls whose exceptions are caught, and thrown again afterwards. Around a call that may throw, GCC keeps no
// floating-point number in a register if there is a destructor to run: a loop that accumulates a number for
// use behind the call would store and load it in each iteration.
//

/// The exception of such a call on this thread.
[[gnu::visibility("default")]] inline std::exception_ptr& deferred_exception() {
  static thread_local std::exception_ptr failure;
  return failure;
}
[[noreturn, gnu::noinline, gnu::cold]] inline void throw_deferred() {
  std::rethrow_exception(std::exchange(deferred_exception(), nullptr));
}

/// Calls f(). \returns false if it threw; the caller must call throw_deferred()
template <class F>
[[nodiscard, gnu::noinline]] bool succeeds(F f) noexcept {
  try {
    f();
    return true;
  } catch (...) {
    deferred_exception() = std::current_exception();
    return false;
  }
}
}  // namespace tapestry::detail
