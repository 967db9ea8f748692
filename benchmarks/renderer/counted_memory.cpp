#include "counted_memory.hpp"

#include <malloc.h>

#include <atomic>
#include <cstdlib>
#include <new>

namespace tapestry::benchmarks {
namespace {
std::atomic<std::size_t> in_use{0};
std::atomic<std::size_t> most{0};

void* counted(void* block) {
  if (block == nullptr) throw std::bad_alloc();
  const std::size_t size = malloc_usable_size(block);
  const std::size_t now = in_use.fetch_add(size, std::memory_order_relaxed) + size;
  for (std::size_t before = most.load(); before < now && !most.compare_exchange_weak(before, now);) {
  }
  return block;
}

void release(void* block) noexcept {
  in_use.fetch_sub(malloc_usable_size(block), std::memory_order_relaxed);
  std::free(block);
}
}  // namespace

std::size_t bytes_in_use() { return in_use; }
std::size_t peak_bytes() { return most; }
void reset_peak_bytes() { most = in_use.load(); }
}  // namespace tapestry::benchmarks

// The forms for arrays and those that do not throw call these.
void* operator new(std::size_t size) { return tapestry::benchmarks::counted(std::malloc(size)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto align = static_cast<std::size_t>(alignment);
  return tapestry::benchmarks::counted(std::aligned_alloc(align, (size + align - 1) / align * align));
}
void operator delete(void* block) noexcept { tapestry::benchmarks::release(block); }
void operator delete(void* block, std::size_t) noexcept { tapestry::benchmarks::release(block); }
void operator delete(void* block, std::align_val_t) noexcept { tapestry::benchmarks::release(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept {
  tapestry::benchmarks::release(block);
}
