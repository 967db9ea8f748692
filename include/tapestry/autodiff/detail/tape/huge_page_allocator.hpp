#pragma once
#include <cstdlib>
#include <new>
#include <tapestry/core/huge_pages.hpp>
#include <utility>

namespace tapestry::detail {

/// Allocates aligned memory of at least `size` bytes, on large pages where it fills them; to be freed by
/// std::free.
/// \returns its true size in `size`
/// \throws std::bad_alloc
[[nodiscard]] inline std::byte* allocate_pages(std::size_t& size) {
  constexpr std::size_t huge_page = std::size_t(1) << 21U;
  const std::size_t alignment = size < huge_page ? 64 : huge_page;
  size = (size + alignment - 1) / alignment * alignment;
  void* const memory = std::aligned_alloc(alignment, size);
  if (memory == nullptr) throw std::bad_alloc();
  prefer_huge_pages(memory, size);
  return static_cast<std::byte*>(memory);
}

/// Owner of such memory.
class PageMemory {
 public:
  PageMemory() = default;
  explicit PageMemory(std::byte* memory) noexcept : memory_(memory) {}
  PageMemory(PageMemory&& other) noexcept : memory_(std::exchange(other.memory_, nullptr)) {}
  PageMemory& operator=(PageMemory&& other) noexcept {
    std::swap(memory_, other.memory_);
    return *this;
  }
  ~PageMemory() { std::free(memory_); }
  [[nodiscard]] std::byte* get() const noexcept { return memory_; }

 private:
  std::byte* memory_ = nullptr;
};

/// Allocates arrays that are walked through at random: on small pages, finding the page costs more than the
/// load. Numbers that are given no value have none.
template <class T>
struct HugePageAllocator {
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) noexcept {}
  [[nodiscard]] T* allocate(std::size_t count) {
    std::size_t size = count * sizeof(T);
    return reinterpret_cast<T*>(allocate_pages(size));
  }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) == 0) {
      ::new (static_cast<void*>(place)) U;
    } else {
      ::new (static_cast<void*>(place)) U{std::forward<Arguments>(arguments)...};
    }
  }
  void deallocate(T* memory, std::size_t) noexcept { std::free(memory); }
  template <class U>
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator<U>&) noexcept {
    return true;
  }
};

}  // namespace tapestry::detail
