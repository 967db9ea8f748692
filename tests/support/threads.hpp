#pragma once
#include <tapestry/core/parallel.hpp>

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

}  // namespace tapestry::test
