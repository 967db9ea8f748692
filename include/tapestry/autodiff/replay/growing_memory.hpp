#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <tapestry/autodiff/tape/huge_page_allocator.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tapestry::detail {

/// Memory that grows by pieces, so that its contents do not move, and is freed as a whole.
class GrowingMemory {
 public:
  /// Copies so many numbers or plain structures of one type into the memory.
  template <class T>
  requires std::is_trivially_copyable_v<T>
  [[nodiscard]] const T* keep(const T* first, std::size_t count) {
    const std::size_t size = (count * sizeof(T) + 63) / 64 * 64;
    if (size > room_) {
      std::size_t grown = std::max(size, std::min(2 * last_size_, largest_size));
      pieces_.emplace_back(allocate_pages(grown));
      next_ = pieces_.back().get();
      room_ = last_size_ = grown;
    }
    T* const copy = reinterpret_cast<T*>(next_);
    std::uninitialized_copy_n(first, count, copy);
    next_ += size;
    room_ -= size;
    return copy;
  }

 private:
  static constexpr std::size_t largest_size = std::size_t(1) << 22U;

  std::vector<PageMemory> pieces_;
  std::byte* next_ = nullptr;
  std::size_t room_ = 0, last_size_ = std::size_t(1) << 14U;
};

/// An array of plain numbers or structures that grows at its end, often: where it is large, its pages move to
/// where there is room for more, and nothing is copied.
template <class T>
class GrowingArray {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  GrowingArray() = default;
  GrowingArray(const GrowingArray&) = delete;
  GrowingArray(GrowingArray&& other) noexcept
      : memory_(std::exchange(other.memory_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  GrowingArray& operator=(const GrowingArray&) = delete;
  ~GrowingArray() { std::free(memory_); }

  /// Makes room for so many more elements, without values.
  /// \returns the first; it stays in place until the next call
  T* append(std::size_t count) {
    if (size_ + count > capacity_) [[unlikely]]
      grow(size_ + count);
    size_ += count;
    return memory_ + size_ - count;
  }
  void clear() { size_ = 0; }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] T* data() { return memory_; }
  [[nodiscard]] const T* data() const { return memory_; }
  [[nodiscard]] T& operator[](std::size_t i) { return memory_[i]; }
  [[nodiscard]] const T& operator[](std::size_t i) const { return memory_[i]; }
  [[nodiscard]] const T* begin() const { return memory_; }
  [[nodiscard]] const T* end() const { return memory_ + size_; }

 private:
  [[gnu::noinline]] void grow(std::size_t count) {
    count = std::max(2 * capacity_, std::max<std::size_t>(count, 256));
    void* const memory = std::realloc(static_cast<void*>(memory_), count * sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    memory_ = static_cast<T*>(memory);
    capacity_ = count;
  }

  T* memory_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

}  // namespace tapestry::detail
