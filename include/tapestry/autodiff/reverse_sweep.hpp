#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <tapestry/autodiff/huge_page_allocator.hpp>
#include <tapestry/autodiff/scalar.hpp>
#include <tapestry/autodiff/statement.hpp>
#include <tapestry/autodiff/tape_memory.hpp>

namespace tapestry::detail {

/// Adjoints of all statements, `Width` of each; keeps its memory from sweep to sweep.
template <class T, std::size_t Width = 1>
class AdjointMemory {
 public:
  /// Adjoints of statements 0 to `last`, all zero.
  /// \throws std::bad_alloc
  void zero(std::size_t last) {
    const std::size_t count = (last + 1) * Width;
    if (count > capacity_) grow(count);
    std::memset(static_cast<void*>(memory_.get()), 0, count * sizeof(T));
    size_ = last + 1;
  }
  /// Forgets those of statements from `size` on.
  void truncate(std::size_t size) noexcept {
    if (size < size_) size_ = size;
  }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] T* data() noexcept { return reinterpret_cast<T*>(memory_.get()); }
  [[nodiscard]] const T* data() const noexcept { return reinterpret_cast<const T*>(memory_.get()); }

 private:
  void grow(std::size_t count) {
    const std::size_t grown = capacity_ + capacity_ / 2;
    std::size_t size = (count > grown ? count : grown) * sizeof(T);
    memory_ = PageMemory();
    capacity_ = size_ = 0;
    memory_ = PageMemory(allocate_pages(size));
    capacity_ = size / sizeof(T);
  }

  PageMemory memory_;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

/// Runs statements backwards: each adds its adjoints · partial to the adjoints of its operands.
/// A zero adjoint passes nothing on, not even through an infinite partial.
template <class T>
class ReverseSweep {
 public:
  explicit ReverseSweep(T* adjoints) : adjoints_(adjoints) {}

  /// The statements of `run` up to `root`. Calls pull_back(index) for each record, skip_record() for each
  /// behind the root.
  template <class PullBack, class SkipRecord>
  void run(const StatementRun& run, std::size_t root, PullBack pull_back, SkipRecord skip_record) const {
    T* const adjoints = adjoints_;
    const Word* words = run.words_end;
    const StatementKind* kind = run.kinds + (run.end_index - run.first_index);
    std::size_t index = run.end_index;
    for (; index > run.first_index && index > root + 1; --index) {
      if (*--kind == StatementKind::record) skip_record();
      words -= words_before<T>(words, *kind);
    }
    const T* from = adjoints + index;
    while (kind != run.kinds) {
      --from;
      words = pull(*--kind, words, from, adjoints);
      if (*kind == StatementKind::record) [[unlikely]]
        pull_back(static_cast<std::size_t>(from - adjoints));
    }
  }

 private:
  static constexpr unsigned code(std::size_t plus, std::size_t minus, std::size_t general) {
    return static_cast<unsigned>(kind_of({plus, minus, general}));
  }

  /// Passes on the adjoints at `from` of the statement whose words end at `end`. The frequent kinds each have
  /// their own code, in which all counts are constants.
  /// \returns where the words of the statement before end
  [[gnu::always_inline]] static const Word* pull(StatementKind kind, const Word* end, const T* from,
                                                 T* adjoints) {
    switch (static_cast<unsigned>(kind)) {
      case code(0, 0, 0):
      case static_cast<unsigned>(StatementKind::record):
        return end - 1;
      case code(1, 0, 0):
        return pull_counted<1, 0, 0>(end, from, adjoints);
      case code(2, 0, 0):
        return pull_counted<2, 0, 0>(end, from, adjoints);
      case code(0, 1, 0):
        return pull_counted<0, 1, 0>(end, from, adjoints);
      case code(1, 1, 0):
        return pull_counted<1, 1, 0>(end, from, adjoints);
      case code(0, 0, 1):
        return pull_counted<0, 0, 1>(end, from, adjoints);
      case code(1, 0, 1):
        return pull_counted<1, 0, 1>(end, from, adjoints);
      case code(0, 1, 1):
        return pull_counted<0, 1, 1>(end, from, adjoints);
      case code(0, 0, 2):
        return pull_counted<0, 0, 2>(end, from, adjoints);
      case code(1, 0, 2):
        return pull_counted<1, 0, 2>(end, from, adjoints);
      case code(2, 0, 1):
        return pull_counted<2, 0, 1>(end, from, adjoints);
      case code(0, 0, 3):
        return pull_counted<0, 0, 3>(end, from, adjoints);
      case code(0, 0, 4):
        return pull_counted<0, 0, 4>(end, from, adjoints);
      case code(1, 0, 4):
        return pull_counted<1, 0, 4>(end, from, adjoints);
      default:
        return pull_any(kind, end, from, adjoints);
    }
  }

  template <std::size_t Plus, std::size_t Minus, std::size_t General>
  [[gnu::always_inline]] static const Word* pull_counted(const Word* end, const T* from, T* adjoints) {
    constexpr OperandCounts counts{Plus, Minus, General};
    const Word* const words = end - words_of<T>(counts);
    pull_operands(counts, words, from, adjoints);
    return words;
  }

  [[gnu::noinline]] static const Word* pull_any(StatementKind kind, const Word* end, const T* from,
                                                T* adjoints) {
    const Word* const words = end - words_before<T>(end, kind);
    const OperandCounts counts =
        kind == StatementKind::many_pairs ? OperandCounts{0, 0, end[-1]} : counts_of(kind);
    pull_operands(counts, words, from, adjoints);
    return words;
  }

  [[gnu::always_inline]] static void pull_operands(const OperandCounts& counts, const Word* words,
                                                   const T* from, T* adjoints) {
    const T adjoint = *from;
    if (is_zero(adjoint)) [[unlikely]]
      return;
    for (std::size_t i = 0; i < counts.general; ++i, words += pair_words<T>)
      adjoints[index_of_pair<T>(words)] += partial_of_pair<T>(words) * adjoint;
    for (std::size_t i = 0; i < counts.plus; ++i) adjoints[*words++] += adjoint;
    for (std::size_t i = 0; i < counts.minus; ++i) adjoints[*words++] -= adjoint;
  }

  T* adjoints_;
};

}  // namespace tapestry::detail
