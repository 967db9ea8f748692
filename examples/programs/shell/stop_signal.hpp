#pragma once
#include "output_claim.hpp"

namespace tapestry::shell {
/// Thrown to leave long work after a signal; not an error.
struct Stopped {};

/// Remembers the first signal, so that a loop can finish its step and save. After SIGINT, SIGTERM or SIGHUP a
/// second one ends the process at once, see OutputClaim::end_by(). SIGXCPU and SIGUSR1 announce the end of
/// a batch queue's time, and may then come every second. A signal that the process was started to ignore,
/// as by nohup, stays ignored.
class StopSignal {
 public:
  StopSignal() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU, SIGUSR1})
      if (std::signal(signal, remember) == SIG_IGN) std::signal(signal, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
  }

  [[nodiscard]] static bool arrived() { return received != 0; }

  static void throw_if_arrived() {
    if (arrived()) throw Stopped{};
  }

  /// 128 + the signal's number, as shells report it: 130 for Ctrl-C, 129 for SIGHUP. If only another rank got
  /// a signal: 143, as for SIGTERM.
  [[nodiscard]] static int exit_code() { return 128 + (arrived() ? received : SIGTERM); }

 private:
  static void remember(int signal) {
    if (received == 0) received = signal;
    std::signal(signal, signal == SIGXCPU || signal == SIGUSR1 ? SIG_IGN : OutputClaim::end_by);
  }

  static inline volatile std::sig_atomic_t received = 0;
};
}  // namespace tapestry::shell
