#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <new>
#include <type_traits>
#include <utility>

namespace tapestry::detail {

/// Contiguous stack of trivial values. Its elements are written before they are counted, so that a
/// statement can be abandoned half way, and it grows by realloc, which moves large blocks without a copy.
template <class T>
requires std::is_trivially_copyable_v<T>
class FlatStack {
 public:
  FlatStack() = default;
  FlatStack(const FlatStack&) = delete;
  FlatStack& operator=(const FlatStack&) = delete;
  ~FlatStack() { std::free(first_); }

  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }
  [[nodiscard]] T* data() noexcept { return first_; }
  [[nodiscard]] const T* data() const noexcept { return first_; }
  [[nodiscard]] T* end() noexcept { return first_ + size_; }

  /// Makes room for `count` elements behind the last one.
  /// \throws std::bad_alloc, and is then unchanged
  void make_room(std::size_t count) {
    if (capacity_ - size_ < count) [[unlikely]]
      grow(count);
  }

  /// Counts in `count` elements already written at end().
  void commit(std::size_t count) noexcept { size_ += count; }
  void truncate(std::size_t size) noexcept { size_ = size; }

 private:
  void grow(std::size_t count) {
    const std::size_t capacity = std::max({2 * capacity_, size_ + count, std::size_t(1024)});
    void* moved = std::realloc(first_, capacity * sizeof(T));
    if (moved == nullptr) throw std::bad_alloc();
    first_ = static_cast<T*>(moved);
    capacity_ = capacity;
  }

  T* first_ = nullptr;
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

}  // namespace tapestry::detail
