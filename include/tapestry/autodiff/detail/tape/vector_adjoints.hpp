#pragma once
#include <concepts>
#include <cstring>
#include <tapestry/autodiff/detail/tape/page_memory.hpp>

namespace tapestry::detail {
/// Adjoints of all statements, Width of each, for a sweep that goes down from the last one.
///
/// All of them together can be much larger than the caches, while most statements read values that were
/// recorded shortly before. So the adjoints of the current statement and the ones before it lie in a window.
/// After their sweep they move in blocks to the memory for all, except those that are zero or not to be kept.
/// Blocks without additions are not touched there.
template <std::floating_point T, std::size_t Width>
requires(Width > 0 && (Width & (Width - 1)) == 0) class VectorAdjoints {
 public:
  static constexpr std::size_t block = 64;  ///< statements

  VectorAdjoints() = default;
  VectorAdjoints(VectorAdjoints&& other) noexcept { swap(other); }
  VectorAdjoints& operator=(VectorAdjoints&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(VectorAdjoints& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(window_memory_, other.window_memory_);
    is_written_.swap(other.is_written_);
    is_kept_.swap(other.is_kept_);
    std::swap(capacity_, other.capacity_);
    std::swap(floor_, other.floor_);
    std::swap(top_, other.top_);
    std::swap(size_, other.size_);
  }

  /// Sets the adjoints of statements 0 to `last` to zero, and the window to the last. Statements 1 to
  /// `input_count`, which have no operands, need no window.
  /// \throws std::bad_alloc
  void start(std::size_t last, std::size_t input_count, bool keeps_all) {
    size_ = 0;
    const std::size_t blocks = last / block + 1;
    is_written_.assign(blocks, 0);
    is_kept_.assign(blocks, static_cast<std::uint8_t>(keeps_all));
    if (blocks > capacity_) {
      std::size_t bytes = (blocks + blocks / 2) * block_bytes;
      memory_ = PageMemory();
      capacity_ = 0;
      memory_ = allocate_pages(bytes);
      capacity_ = bytes / block_bytes;
    }
    if (window_memory_.get() == nullptr) {
      std::size_t bytes = window_blocks * block_bytes;
      window_memory_ = allocate_pages(bytes);
    }
    top_ = last / block;
    floor_ = (input_count + 1) / block < top_ ? (input_count + 1) / block : top_;
    for (std::size_t number = top_ + 1; number-- > floor_ && number + window_blocks > top_;)
      std::memset(static_cast<void*>(window_block(number)), 0, block_bytes);
    size_ = last + 1;
  }

  /// Keeps the adjoints of statement `index`, if it is below size().
  void keep(std::size_t index) {
    if (index < size_) is_kept_[index / block] = 1;
  }

  /// Places of the adjoints while the sweep is in one block.
  struct View {
    T* window;
    std::size_t window_begin;  ///< the first statement in it
    T* all;
    const std::uint8_t* is_written;

    /// Adjoints of an operand of the current statement.
    [[nodiscard, gnu::always_inline]] T* at(std::size_t index, VectorAdjoints& adjoints) const {
      if (index >= window_begin) [[likely]]
        return in_window(index);
      if (is_written[index / block] == 0) [[unlikely]]
        adjoints.begin_block(index / block);
      return all + index * Width;
    }
    [[nodiscard, gnu::always_inline]] T* in_window(std::size_t index) const {
      return window + index % (window_blocks * block) * Width;
    }
  };
  [[nodiscard]] View view() const noexcept {
    const std::size_t first = top_ + 1 < window_blocks ? 0 : top_ + 1 - window_blocks;
    return {window(), (first < floor_ ? floor_ : first) * block, all(), is_written_.data()};
  }

  /// Ends the sweep over statements from `index` on.
  /// \param is_touched  false if the adjoints of the block at hand are known to be zero
  void pass(std::size_t index, bool is_touched) { leave_blocks((index + block - 1) / block, is_touched); }

  /// During the sweep: adjoints of a statement that it has passed and that are kept; null if they are zero.
  [[nodiscard]] const T* passed(std::size_t index) const noexcept {
    return index >= size_ ? nullptr : index / block > top_ ? of(index) : view().in_window(index);
  }

  [[nodiscard]] bool keeps(std::size_t index) const noexcept {
    return index / block < floor_ || is_kept_[index / block] != 0;
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  /// After the sweep: adjoints of statement `index` below size(); null if they are zero.
  [[nodiscard]] const T* of(std::size_t index) const noexcept {
    return is_written_[index / block] == 0 ? nullptr : all() + index * Width;
  }

 private:
  static constexpr std::size_t block_bytes = block * Width * sizeof(T);
  static constexpr std::size_t window_bytes = std::size_t(1) << 17U;  // in the second cache
  static constexpr std::size_t window_blocks =
      window_bytes < 2 * block_bytes ? 2 : window_bytes / block_bytes;  // a power of two

  [[nodiscard]] T* all() const noexcept { return reinterpret_cast<T*>(memory_.get()); }
  [[nodiscard]] T* window() const noexcept { return reinterpret_cast<T*>(window_memory_.get()); }
  [[nodiscard]] T* window_block(std::size_t number) const noexcept {
    return window() + number % window_blocks * (block * Width);
  }

  [[gnu::noinline]] void begin_block(std::size_t number) noexcept {
    is_written_[number] = 1;
    std::memset(static_cast<void*>(all() + number * (block * Width)), 0, block_bytes);
  }

  /// Moves the window down until it ends before the block `bottom`.
  [[gnu::noinline]] void leave_blocks(std::size_t bottom, bool is_touched) noexcept {
    if (bottom < floor_) bottom = floor_;
    for (; top_ + 1 > bottom; --top_, is_touched = true) {
      T* const here = window_block(top_);
      if (is_kept_[top_] != 0 && (is_written_[top_] != 0 || (is_touched && !is_zero_block(here)))) {
        is_written_[top_] = 1;
        std::memcpy(all() + top_ * (block * Width), here, block_bytes);
      }
      if (top_ >= window_blocks + floor_ && is_written_[top_ - window_blocks] != 0)
        std::memcpy(here, all() + (top_ - window_blocks) * (block * Width), block_bytes);
      else if (is_touched)
        std::memset(static_cast<void*>(here), 0, block_bytes);
      if (top_ == 0) return;
    }
  }

  [[nodiscard]] static bool is_zero_block(const T* block_begin) noexcept {
    for (std::size_t i = 0; i < block * Width; ++i)
      if (block_begin[i] != T(0)) return false;
    return true;
  }

  PageMemory memory_;
  PageMemory window_memory_;
  std::vector<std::uint8_t> is_written_;  // by block of memory_
  std::vector<std::uint8_t> is_kept_;
  std::size_t capacity_ = 0;  // blocks
  std::size_t floor_ = 0;     // the first block that enters the window
  std::size_t top_ = 0;       // the block that the sweep is in
  std::size_t size_ = 0;
};
}  // namespace tapestry::detail
