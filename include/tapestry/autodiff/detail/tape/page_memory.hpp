#pragma once
#include <tapestry/core/platform/memory.hpp>

namespace tapestry::detail {
/// Owner of memory that allocate_pages() returns.
using PageMemory = std::unique_ptr<std::byte, platform::FreePages>;

/// Allocates at least `size` bytes, as platform::allocate_pages(), up to the end of a page.
/// \returns its true size in `size`
/// \throws std::bad_alloc
[[nodiscard]] inline PageMemory allocate_pages(std::size_t& size) {
  const std::size_t alignment = platform::alignment_for(size);
  size = (size + alignment - 1) / alignment * alignment;
  return {static_cast<std::byte*>(platform::allocate_pages(size)), platform::FreePages{size}};
}
}  // namespace tapestry::detail
