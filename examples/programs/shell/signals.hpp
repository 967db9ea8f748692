#pragma once
#include <csignal>

namespace tapestry::shell {

#if defined(_WIN32)
/// Signals that Windows lacks: closing the console takes the place of a hang-up, and none that of others.
inline constexpr int SIGHUP = SIGBREAK, SIGXCPU = 0, SIGUSR1 = 0, SIGPIPE = 0, SIGXFSZ = 0;
#endif

}  // namespace tapestry::shell
