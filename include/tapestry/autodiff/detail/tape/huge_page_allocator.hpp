#pragma once
#include <memory>
#include <tapestry/core/platform/memory.hpp>
#include <utility>

namespace tapestry::detail {

/// Owner of memory that allocate_pages() returns.
using PageMemory = std::unique_ptr<std::byte, platform::FreePages>;

/// Allocates at least `size` bytes, as platform::allocate_pages(), up to the end of a page.
/// \returns its true size in `size`
/// \throws std::bad_alloc
[[nodiscard]] inline std::byte* allocate_pages(std::size_t& size) {
  const std::size_t alignment = platform::alignment_for(size);
  size = (size + alignment - 1) / alignment * alignment;
  return static_cast<std::byte*>(platform::allocate_pages(size));
}

/// Allocates arrays that are walked through at random: on small pages, finding the page costs more than the
/// load. Numbers stay uninitialised without a value.
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
  void deallocate(T* memory, std::size_t) noexcept { platform::FreePages()(memory); }
  template <class U>
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator<U>&) noexcept {
    return true;
  }
};

}  // namespace tapestry::detail
