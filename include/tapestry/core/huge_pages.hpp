#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>

namespace tapestry {

/// Advises the system to back memory of many MiB that was not written yet by pages of 2 MiB. With pages of 4
/// KiB, the first access costs as much as reading the file that fills the memory. If the system has no large
/// pages, or no room for them, nothing changes.
inline void prefer_huge_pages([[maybe_unused]] void* memory, [[maybe_unused]] std::size_t size) {
#ifdef MADV_HUGEPAGE
  constexpr std::uintptr_t page = std::uintptr_t(2) << 20U;
  const auto begin = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (begin + page - 1) / page * page;
  const std::uintptr_t last = (begin + size) / page * page;
  if (first < last) ::madvise(static_cast<std::byte*>(memory) + (first - begin), last - first, MADV_HUGEPAGE);
#endif
}

}  // namespace tapestry
