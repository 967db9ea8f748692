#pragma once
#if defined(__linux__)
#include <sys/resource.h>
#endif

namespace tapestry::platform {
/// Number of times that the system has taken the processor from the calling thread; −1 where it keeps none.
[[nodiscard]] inline long interruptions_of_thread() {
#if defined(RUSAGE_THREAD)
  rusage usage{};
  if (::getrusage(RUSAGE_THREAD, &usage) == 0) return usage.ru_nivcsw;
#endif
  return -1;
}
}  // namespace tapestry::platform
