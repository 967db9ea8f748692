#pragma once
#include <csignal>

namespace tapestry::shell {

/// Thrown to leave long work after a signal. It is no error.
struct Stopped {};

/// Remembers SIGINT, SIGTERM and SIGHUP so that a loop can finish its step and save. The second
/// signal ends the process at once, as it would without us. A signal that the process was started to ignore,
/// as by nohup, stays ignored.
class StopSignal {
 public:
  StopSignal() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP})
      if (std::signal(signal, remember) == SIG_IGN) std::signal(signal, SIG_IGN);
    std::signal(SIGPIPE, SIG_IGN);
  }

  [[nodiscard]] static bool arrived() { return received != 0; }

  static void throw_if_arrived() {
    if (arrived()) throw Stopped{};
  }

  /// 128 + the signal's number: 130 for Ctrl-C, 143 for SIGTERM, also where another rank got the signal.
  [[nodiscard]] static int exit_code() { return 128 + (received == SIGINT ? SIGINT : SIGTERM); }

 private:
  static void remember(int signal) {
    received = signal;
    std::signal(signal, SIG_DFL);
  }

  static inline volatile std::sig_atomic_t received = 0;
};

}  // namespace tapestry::shell
