#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace tapestry::detail {
/// Place where a variable was recorded: the index of its statement, and the generation of statements on the
/// tape. Index 0 means nowhere: the variable is passive. It is one number, so that it is copied and compared
/// as one.
class Link {
 public:
  constexpr Link() = default;
  constexpr Link(std::uint32_t index, std::uint32_t generation)
      : bits_(std::uint64_t(generation) << 32U | index) {}
  [[nodiscard]] constexpr std::uint32_t index() const { return static_cast<std::uint32_t>(bits_); }
  [[nodiscard]] constexpr std::uint32_t generation() const {
    return static_cast<std::uint32_t>(bits_ >> 32U);
  }
  [[nodiscard]] constexpr bool is_active() const { return index() != 0; }
  /// Below 2³² if both are of one generation. Differences of several links may be joined by |.
  [[nodiscard]] constexpr std::uint64_t difference(Link other) const { return bits_ ^ other.bits_; }
  constexpr Link& operator++() {
    ++bits_;
    return *this;
  }

 private:
  std::uint64_t bits_ = 0;
};

inline constexpr std::uint32_t no_generation = 0xFFFFFFFFU;

/// Unique numbers: a tape recognises its own variables by them.
[[gnu::visibility("default")]] inline std::uint32_t next_generation() {
  static std::uint32_t last = 0;
  std::uint32_t next = 0;  // 0 marks passive variables, no_generation those without a tape
  while (next == 0 || next == no_generation) next = __atomic_add_fetch(&last, 1, __ATOMIC_RELAXED);
  return next;
}

/// Distance in words at which memory is prefetched before it is read or written. Processors predict the
/// accesses of a walk in steps of many sizes, but not far enough ahead.
inline constexpr std::size_t prefetched_words = 1024;

/// Numbers of a statement's operands: of partial derivative 1, of −1, and of any other.
struct OperandCounts {
  std::size_t plus = 0;
  std::size_t minus = 0;
  std::size_t general = 0;
  [[nodiscard]] constexpr std::size_t sum() const { return plus + minus + general; }
};

[[nodiscard]] constexpr OperandCounts operator+(const OperandCounts& a, const OperandCounts& b) {
  return {a.plus + b.plus, a.minus + b.minus, a.general + b.general};
}

/// A statement's byte on a tape: its operand counts, or another kind of entry.
enum class StatementKind : std::uint8_t {
  input = 0,           ///< no operands
  chunk_begin = 0xFD,  ///< no statement: stands before the first statement of a piece of memory
  many_pairs = 0xFE,   ///< general operands, their number in the word behind them
  record = 0xFF,       ///< an operation with a pullback
};

inline constexpr OperandCounts largest_counts{3, 3, 14};

/// The counts that a kind can hold, except perhaps the general ones: units beyond become general operands.
[[nodiscard]] constexpr OperandCounts within_kind(const OperandCounts& counts) {
  const std::size_t plus = counts.plus < largest_counts.plus ? counts.plus : largest_counts.plus;
  const std::size_t minus = counts.minus < largest_counts.minus ? counts.minus : largest_counts.minus;
  return {plus, minus, counts.sum() - plus - minus};
}

[[nodiscard]] constexpr StatementKind kind_of(const OperandCounts& counts) {
  return static_cast<StatementKind>(counts.plus | counts.minus << 2U | counts.general << 4U);
}

[[nodiscard]] constexpr OperandCounts counts_of(StatementKind kind) {
  const auto byte = static_cast<std::size_t>(kind);
  return {byte & 3U, byte >> 2U & 3U, byte >> 4U};
}

/// Words of 4 bytes hold a statement's operands, in this order: pairs (partial, index) of the general ones,
/// indices with partial 1, indices with partial −1.
using Word = std::uint32_t;

template <class T>
inline constexpr std::size_t pair_words = 1 + sizeof(T) / sizeof(Word);

template <class T>
[[nodiscard]] constexpr std::size_t words_of(const OperandCounts& counts) {
  return counts.general * pair_words<T> + counts.plus + counts.minus;
}

/// A general operand of floating-point type among words. A separate type shows the compiler that writing one
/// changes nothing else.
template <std::floating_point T>
struct [[gnu::packed, gnu::aligned(alignof(Word))]] Pair {
  T partial;
  Word index;
};

template <class T>
void write_pair(Word* words, std::uint32_t index, const T& partial) {
  if constexpr (std::floating_point<T>) {
    auto* const pair = reinterpret_cast<Pair<T>*>(words);
    pair->partial = partial;
    pair->index = index;
  } else {
    std::memcpy(words, &partial, sizeof(T));
    words[pair_words<T> - 1] = index;
  }
}

template <class T>
[[nodiscard]] T partial_of_pair(const Word* words) {
  if constexpr (std::floating_point<T>) {
    return reinterpret_cast<const Pair<T>*>(words)->partial;
  } else {
    T partial;
    std::memcpy(static_cast<void*>(&partial), words, sizeof(T));
    return partial;
  }
}

template <class T>
[[nodiscard]] std::uint32_t index_of_pair(const Word* words) {
  if constexpr (std::floating_point<T>) {
    return reinterpret_cast<const Pair<T>*>(words)->index;
  } else {
    return words[pair_words<T> - 1];
  }
}

/// The number of words of the statement whose words end at `end`. Statements without operands have one unused
/// word.
template <class T>
[[nodiscard]] std::size_t words_before(const Word* end, StatementKind kind) {
  if (kind == StatementKind::input || kind == StatementKind::record) return 1;
  if (kind == StatementKind::many_pairs) return 1 + end[-1] * pair_words<T>;
  return words_of<T>(counts_of(kind));
}

/// Calls visit(index, partial) for each operand of the statement whose words end at `end`. A record has none.
/// \returns where its words begin
template <class T, class Visit>
[[gnu::always_inline]] inline const Word* for_each_operand(const Word* end, StatementKind kind,
                                                           Visit&& visit) {
  const Word* const words = end - words_before<T>(end, kind);
  if (kind == StatementKind::input || kind == StatementKind::record) return words;
  const OperandCounts counts =
      kind == StatementKind::many_pairs ? OperandCounts{0, 0, end[-1]} : counts_of(kind);
  const Word* operand = words;
  for (std::size_t i = 0; i < counts.general; ++i, operand += pair_words<T>)
    visit(index_of_pair<T>(operand), partial_of_pair<T>(operand));
  for (std::size_t i = 0; i < counts.plus; ++i) visit(*operand++, T(1));
  for (std::size_t i = 0; i < counts.minus; ++i) visit(*operand++, T(-1));
  return words;
}
}  // namespace tapestry::detail
