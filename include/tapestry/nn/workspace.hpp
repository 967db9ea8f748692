#pragma once
#include <concepts>
#include <cstring>
#include <tapestry/core/platform/memory.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {
/// Memory for kernels: aligned to 64 bytes, not initialised, kept when resized to less, and followed by
/// 128 readable zero bytes so that a kernel may load whole vectors past the last element.
template <class Element>
class Buffer {
 public:
  Buffer() = default;
  explicit Buffer(std::size_t count) { resize(count); }
  Buffer(Buffer&& other) noexcept
      : memory_(std::move(other.memory_)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Buffer& operator=(Buffer&& other) noexcept {
    memory_ = std::move(other.memory_);
    size_ = std::exchange(other.size_, 0);
    capacity_ = std::exchange(other.capacity_, 0);
    return *this;
  }

  /// Resizes without keeping the content. Memory is allocated only when `count` exceeds all earlier counts.
  void resize(std::size_t count) {
    if (count > capacity_ || !memory_) {
      memory_.reset();
      capacity_ = 0;
      const std::size_t bytes = (count * sizeof(Element) + slack + 63) / 64 * 64;
      // Kernels access memory at large distances, where looking up a page of 4 KiB can take longer than
      // loading a cache line. So large memory begins at a large page.
      void* const fresh = platform::allocate_pages(bytes);
      memory_ = {static_cast<Element*>(fresh), platform::FreePages{bytes}};
      capacity_ = count;
      std::memset(static_cast<char*>(fresh) + count * sizeof(Element), 0, bytes - count * sizeof(Element));
    }
    size_ = count;
  }

  void clear() {
    memory_.reset();
    size_ = capacity_ = 0;
  }

  void fill_zero() { std::memset(data(), 0, size_ * sizeof(Element)); }

  [[nodiscard]] Element* data() { return memory_.get(); }
  [[nodiscard]] const Element* data() const { return memory_.get(); }
  [[nodiscard]] std::size_t size() const { return size_; }
  [[nodiscard]] bool empty() const { return size_ == 0; }
  [[nodiscard]] std::size_t capacity() const { return capacity_; }

 private:
  static constexpr std::size_t slack = 128;
  std::unique_ptr<Element, platform::FreePages> memory_{};
  std::size_t size_ = 0;
  std::size_t capacity_ = 0;
};

/// Memory that layers hand to one another, kept between passes.
template <std::floating_point T>
class Workspace {
 public:
  /// The smallest free buffer that is large enough, else the largest one, grown.
  [[nodiscard]] Buffer<T> take(std::size_t count) {
    std::size_t best = free_.size();
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (best == free_.size()) {
        best = i;
        continue;
      }
      const bool fits = free_[i].capacity() >= count;
      const bool best_fits = free_[best].capacity() >= count;
      const bool is_smaller = free_[i].capacity() < free_[best].capacity();
      if (fits ? !best_fits || is_smaller : !best_fits && !is_smaller) best = i;
    }
    Buffer<T> buffer;
    if (best < free_.size()) {
      buffer = std::move(free_[best]);
      free_.erase(free_.begin() + static_cast<std::ptrdiff_t>(best));
    }
    buffer.resize(count);
    return buffer;
  }

  void give(Buffer<T>&& buffer) {
    if (buffer.capacity() > 0) free_.push_back(std::move(buffer));
    buffer = Buffer<T>();
  }

 private:
  std::vector<Buffer<T>> free_;
};
}  // namespace tapestry::nn
