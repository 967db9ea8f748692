#pragma once
#include <cstddef>
#include <utility>

namespace tapestry::detail {

/// Counted reference to a T that make() makes, or to none. What a tape needs of std::shared_ptr, whose header
/// is larger than all that a tape includes.
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

  [[nodiscard]] T* get() const noexcept { return counted_ == nullptr ? nullptr : &counted_->value; }
  [[nodiscard]] T& operator*() const noexcept { return counted_->value; }
  [[nodiscard]] T* operator->() const noexcept { return &counted_->value; }
  [[nodiscard]] explicit operator bool() const noexcept { return counted_ != nullptr; }

 private:
  struct Counted {
    T value{};
    std::size_t owners = 1;
  };
  Counted* counted_ = nullptr;
};

}  // namespace tapestry::detail
