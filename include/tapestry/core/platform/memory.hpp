#pragma once
#include <cstddef>
#include <cstdlib>
#include <new>
#if defined(_WIN32)
#include <malloc.h>
#elif defined(__linux__)
#include <sys/mman.h>
#endif

/// \file
/// Memory from the operating system, apart from the rest of core/platform.hpp, because the tape needs no
/// more.
namespace tapestry::platform {

/// Alignment in bytes of memory of this size: 64, or 2 MiB, a large page, where it fills one.
[[nodiscard]] constexpr std::size_t alignment_for(std::size_t size) {
  constexpr std::size_t large_page = std::size_t(2) << 20U;
  return size < large_page ? 64 : large_page;
}

/// Allocates `size` bytes, aligned to alignment_for(size), to be released by FreePages. Advises the system to
/// use large pages where there are any. With pages of 4 KiB, the first access costs as much as reading the
/// file that fills the memory.
/// \throws std::bad_alloc
[[nodiscard]] inline void* allocate_pages(std::size_t size) {
  const std::size_t alignment = alignment_for(size);
#if defined(_WIN32)
  void* const memory = ::_aligned_malloc(size, alignment);
#else
  void* const memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
#endif
  if (memory == nullptr) throw std::bad_alloc();
#if defined(MADV_HUGEPAGE)
  if (alignment > 64) ::madvise(memory, size / alignment * alignment, MADV_HUGEPAGE);
#endif
  return memory;
}

/// Releases memory of allocate_pages().
struct FreePages {
  void operator()(void* memory) const noexcept {
#if defined(_WIN32)
    ::_aligned_free(memory);
#else
    std::free(memory);
#endif
  }
};

}  // namespace tapestry::platform
