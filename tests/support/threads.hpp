#pragma once
#include <tapestry/core/parallel.hpp>
#include "catch.hpp"

namespace tapestry::test {
/// Caps the threads of this thread's loops while it lives.
class Threads {
 public:
  explicit Threads(int count) { limit_threads(count); }
  Threads(const Threads&) = delete;
  Threads& operator=(const Threads&) = delete;
  ~Threads() { limit_threads(before_); }

 private:
  int before_ = thread_count();
};

/// Result of run(), after a check that it is the same with each of these numbers of threads.
template <class Run>
auto same_by_threads(std::initializer_list<int> counts, Run run) {
  std::optional<decltype(run())> first;
  for (const int count : counts) {
    const Threads cap(count);
    auto result = run();
    CAPTURE(count);
    CHECK((!first || result == *first));
    first = std::move(result);
  }
  return *std::move(first);
}
}  // namespace tapestry::test
