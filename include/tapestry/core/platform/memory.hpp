#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <mutex>
#include <new>
#include <vector>
#if defined(_WIN32)
#include <malloc.h>
#elif defined(__linux__)
#include <sys/mman.h>
#endif
#if defined(__GLIBC__)
#include <malloc.h>
#endif
#if defined(__SANITIZE_ADDRESS__)
#define TAPESTRY_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define TAPESTRY_ADDRESS_SANITIZER
#endif
#endif

/// \file
/// Memory from the operating system, apart from the rest of core/platform.hpp, because the tape needs no
/// more. Large blocks come from a PagePool.
namespace tapestry::platform {
/// Alignment in bytes of memory of this size: 64, or 2 MiB, a large page, where it fills one.
[[nodiscard]] constexpr std::size_t alignment_for(std::size_t size) {
  constexpr std::size_t large_page = std::size_t(2) << 20U;
  return size < large_page ? 64 : large_page;
}

/// Keeps large blocks that are released and hands them out again, so that a loop maps no page twice: the
/// system clears each page that it maps, which took half the time of a step with a texture of 1,024 rows.
/// Returns kept blocks to the system before the sum of blocks in use and kept exceeds by a quarter the most
/// that was in use at the same time: threads need different sizes at different times, and without the quarter
/// they took blocks from each other. Safe to call from all threads. Under AddressSanitizer it keeps nothing,
/// so that a use after release is found.
class PagePool {
 public:
  static constexpr std::size_t smallest = std::size_t(16) << 10U;  ///< bytes of a block; less is malloc's
#if defined(TAPESTRY_ADDRESS_SANITIZER)
  static constexpr bool keeps_blocks = false;
#else
  static constexpr bool keeps_blocks = true;
#endif

  /// Bytes of blocks.
  struct Use {
    std::size_t in_use = 0;
    std::size_t kept = 0;  ///< released, and not returned to the system
    std::size_t peak = 0;  ///< the most that was in use since the start or the last release()
  };

  /// The one of this process. It is never destroyed: other static objects may outlive everything.
  [[nodiscard]] static PagePool& shared() {
    static PagePool* const pool = new PagePool;
    return *pool;
  }

  /// A block of at least `size` bytes, aligned to alignment_for(size).
  /// \throws std::bad_alloc
  [[nodiscard]] void* take(std::size_t size) {
    if (size > std::numeric_limits<std::size_t>::max() / 2) throw std::bad_alloc();
    const Class rounded = class_of(size);
    const std::lock_guard lock(mutex_);
    asked_at_[rounded.index] = ++requests_;
    void* memory = pop(rounded);
    if (memory == nullptr) {
      const std::size_t used = use_.in_use + rounded.size;
      const std::size_t allowed = use_.peak + use_.peak / 4;
      return_to_system(allowed > used ? allowed - used : 0);
      memory = map(rounded.size);
      if (memory == nullptr) {
        return_to_system(0);
        memory = map(rounded.size);
      }
      if (memory == nullptr) throw std::bad_alloc();
    }
    use_.in_use += rounded.size;
    if (use_.in_use > use_.peak) use_.peak = use_.in_use;
    return memory;
  }

  /// Takes a block back. \param size  as it was asked for
  void give(void* memory, std::size_t size) noexcept {
    const Class rounded = class_of(size);
    const std::lock_guard lock(mutex_);
    use_.in_use -= rounded.size;
    if (!keeps_blocks) return unmap(memory);
    blocks_[rounded.index] = new (memory) Block{blocks_[rounded.index]};
    use_.kept += rounded.size;
  }

  /// Returns to the system what is kept, and what malloc keeps where that can be told to.
  void release() noexcept {
    const std::lock_guard lock(mutex_);
    return_to_system(0);
    use_.peak = use_.in_use;
#if defined(__GLIBC__) && !defined(TAPESTRY_ADDRESS_SANITIZER)
    ::malloc_trim(0);
#endif
  }

  [[nodiscard]] Use use() const {
    const std::lock_guard lock(mutex_);
    return use_;
  }

  /// Memory of the system, not kept, aligned to alignment_for(size); nullptr if there is none.
  [[nodiscard]] static void* map(std::size_t size) {
    const std::size_t alignment = alignment_for(size);
#if defined(_WIN32)
    void* const memory = ::_aligned_malloc(size, alignment);
#else
    void* const memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
#endif
#if defined(MADV_HUGEPAGE)
    if (memory != nullptr && alignment > 64) ::madvise(memory, size / alignment * alignment, MADV_HUGEPAGE);
#endif
    return memory;
  }

  static void unmap(void* memory) noexcept {
#if defined(_WIN32)
    ::_aligned_free(memory);
#else
    std::free(memory);
#endif
  }

 private:
  /// A kept block begins with the next of its class.
  struct Block {
    Block* next;
  };

  /// Sizes of blocks: eight from one power of two to the next.
  struct Class {
    std::size_t size;
    std::size_t index;
  };
  [[nodiscard]] static constexpr Class class_of(std::size_t size) {
    const auto octave = static_cast<std::size_t>(std::bit_width(size)) - 1;
    const std::size_t step = std::size_t(1) << (octave - 3);
    const std::size_t eighths = (size + step - 1) / step;  // 8 to 16
    return {eighths * step, 8 * octave + eighths - 8};
  }

  [[nodiscard]] static constexpr std::size_t size_of_class(std::size_t index) {
    return (8 + index % 8) << (index / 8 - 3);
  }

  [[nodiscard]] void* pop(const Class& rounded) {
    Block* const block = blocks_[rounded.index];
    if (block == nullptr) return nullptr;
    blocks_[rounded.index] = block->next;
    use_.kept -= rounded.size;
    return block;
  }

  /// Unmaps kept blocks until at most `allowed` bytes are kept: those first whose size was longest not asked
  /// for, so that a loop keeps the sizes that it needs each time.
  void return_to_system(std::size_t allowed) noexcept {
    while (use_.kept > allowed) {
      std::size_t oldest = blocks_.size();
      for (std::size_t index = 0; index < blocks_.size(); ++index)
        if (blocks_[index] != nullptr && (oldest == blocks_.size() || asked_at_[index] < asked_at_[oldest]))
          oldest = index;
      unmap(pop({size_of_class(oldest), oldest}));
    }
  }

  mutable std::mutex mutex_;
  Use use_;
  std::array<Block*, 8 * 64> blocks_{};           // kept, by class
  std::array<std::uint64_t, 8 * 64> asked_at_{};  // by class: the last request
  std::uint64_t requests_ = 0;
};

/// Allocates `size` bytes, aligned to alignment_for(size), to be released by FreePages; from the pool where a
/// block of it is not larger. Advises the system to use large pages where there are any. With pages of 4 KiB,
/// the first access costs as much as reading the file that fills the memory.
/// \throws std::bad_alloc
[[nodiscard]] inline void* allocate_pages(std::size_t size) {
  if (size >= PagePool::smallest) return PagePool::shared().take(size);
  void* const memory = PagePool::map(size);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}

/// Releases memory of allocate_pages().
struct FreePages {
  std::size_t size = 0;  ///< as it was asked for
  void operator()(void* memory) const noexcept {
    if (size >= PagePool::smallest) {
      PagePool::shared().give(memory, size);
    } else {
      PagePool::unmap(memory);
    }
  }
};

/// Allocates containers: large ones from the pool, small ones as std::allocator does.
template <class T>
struct PageAllocator {
  using value_type = T;
  PageAllocator() = default;
  template <class U>
  PageAllocator(const PageAllocator<U>&) noexcept {}
  [[nodiscard]] T* allocate(std::size_t count) {
    if (count < PagePool::smallest / sizeof(T)) return std::allocator<T>().allocate(count);
    if (count > std::numeric_limits<std::size_t>::max() / 2 / sizeof(T)) throw std::bad_array_new_length();
    return static_cast<T*>(allocate_pages(count * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t count) noexcept {
    if (count < PagePool::smallest / sizeof(T)) {
      std::allocator<T>().deallocate(memory, count);
    } else {
      FreePages{count * sizeof(T)}(memory);
    }
  }
  template <class U>
  friend bool operator==(const PageAllocator&, const PageAllocator<U>&) noexcept {
    return true;
  }
};
}  // namespace tapestry::platform
