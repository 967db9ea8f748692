#pragma once
#include <cstddef>
#include <tapestry/core/error.hpp>

namespace tapestry::detail {

/// Which thread a tape is active on, if any.
class ThreadClaim {
 public:
  ThreadClaim() = default;
  ThreadClaim(const ThreadClaim&) = delete;
  ThreadClaim& operator=(const ThreadClaim&) = delete;

  /// May be called again by the same thread. \param thread  the address of something that each has its own of
  /// \throws DomainError if another thread holds it
  void take(const void* thread) {
    const void* holder = nullptr;
    const bool is_taken =
        __atomic_compare_exchange_n(&holder_, &holder, thread, false, __ATOMIC_ACQUIRE, __ATOMIC_RELAXED);
    if (!is_taken && holder != thread)
      throw DomainError(
          "activate: the tape is active on another thread; each thread needs a tape of its own");
    ++count_;
  }
  /// Undoes one take() of this thread.
  void release() noexcept {
    if (--count_ == 0) __atomic_store_n(&holder_, nullptr, __ATOMIC_RELEASE);
  }

 private:
  const void* holder_ = nullptr;
  std::size_t count_ = 0;
};

}  // namespace tapestry::detail
