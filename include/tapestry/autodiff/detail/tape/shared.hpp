#pragma once
#include <tapestry/core/error.hpp>

namespace tapestry::detail {
/// Counted reference to a T that make() makes, or to none. It has only the parts of std::shared_ptr that a
/// tape needs; that header is larger than all that a tape includes.
template <class T>
class Shared {
 public:
  Shared() = default;
  Shared(const Shared& other) noexcept : counted_(other.counted_) {
    if (counted_ != nullptr) __atomic_add_fetch(&counted_->owners, 1, __ATOMIC_RELAXED);
  }
  Shared(Shared&& other) noexcept : counted_(std::exchange(other.counted_, nullptr)) {}
  Shared& operator=(Shared other) noexcept {
    std::swap(counted_, other.counted_);
    return *this;
  }
  ~Shared() {
    if (counted_ != nullptr && __atomic_sub_fetch(&counted_->owners, 1, __ATOMIC_ACQ_REL) == 0)
      delete counted_;
  }
  [[nodiscard]] static Shared make() {
    Shared made;
    made.counted_ = new Counted;
    return made;
  }

  /// Gives up the reference without lowering its count: the T stays for ever, and searches for leaks find it.
  void abandon() noexcept {
    counted_->next = __atomic_exchange_n(&abandoned_, counted_, __ATOMIC_ACQ_REL);
    counted_ = nullptr;
  }
  [[nodiscard]] T* get() const noexcept { return counted_ == nullptr ? nullptr : &counted_->value; }
  [[nodiscard]] T& operator*() const noexcept { return counted_->value; }
  [[nodiscard]] T* operator->() const noexcept { return &counted_->value; }
  [[nodiscard]] explicit operator bool() const noexcept { return counted_ != nullptr; }

 private:
  struct Counted {
    T value{};
    std::size_t owners = 1;
    Counted* next = nullptr;  // of those abandoned
  };
  static inline Counted* abandoned_ = nullptr;
  Counted* counted_ = nullptr;
};

/// Thread that a tape is active on, if any.
class ThreadClaim {
 public:
  ThreadClaim() = default;
  ThreadClaim(const ThreadClaim&) = delete;
  ThreadClaim& operator=(const ThreadClaim&) = delete;

  /// Claims the tape; may be called again by the same thread.
  /// \param thread  the address of a thread-local object
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
  [[nodiscard]] bool is_held_by(const void* thread) const noexcept {
    return __atomic_load_n(&holder_, __ATOMIC_RELAXED) == thread;
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
