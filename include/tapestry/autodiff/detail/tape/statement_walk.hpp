#pragma once
#include <tapestry/autodiff/detail/tape/statement.hpp>

namespace tapestry::detail {
/// Visits the statements of one piece of a tape, the last one first. Each frequent kind has its own code,
/// with constant counts, which continues while statements are of that kind.
///
/// \tparam Visitor  has, all of them to be inlined,
///   skip(count)           passes so many statements without operands
///   pull(counts, words)   takes the previous statement: its counts, if possible constants, and its words
///   pull_record()         takes the previous operation with a pullback
template <class T, class Visitor>
class StatementWalk {
 public:
  /// \param words_end  behind the last statement's words
  /// \param kinds_end  behind its kind; before the first kind stands chunk_begin
  [[gnu::always_inline]] static inline void run(const Word* words_end, const StatementKind* kinds_end,
                                                Visitor& visitor) {
    const Word* words = words_end;
    const StatementKind* kind = kinds_end - 1;
    for (;;) {
      switch (static_cast<unsigned>(*kind)) {
        case static_cast<unsigned>(StatementKind::chunk_begin):
          return;
        case static_cast<unsigned>(StatementKind::input):
          skip_inputs(words, kind, visitor);
          break;
        case static_cast<unsigned>(StatementKind::record):
          --words, --kind;
          visitor.pull_record();
          break;
        default:
          pull_statement(words, kind, visitor);
      }
    }
  }

 private:
  static constexpr unsigned code(std::size_t plus, std::size_t minus, std::size_t general) {
    return static_cast<unsigned>(kind_of({plus, minus, general}));
  }

  /// Takes the previous statement, and all of its kind directly before it.
  [[gnu::always_inline]] static inline void pull_statement(const Word*& words, const StatementKind*& kind,
                                                           Visitor& visitor) {
    switch (static_cast<unsigned>(*kind)) {
      case code(1, 0, 0):
        return pull_like<1, 0, 0>(words, kind, visitor);
      case code(2, 0, 0):
        return pull_like<2, 0, 0>(words, kind, visitor);
      case code(0, 1, 0):
        return pull_like<0, 1, 0>(words, kind, visitor);
      case code(1, 1, 0):
        return pull_like<1, 1, 0>(words, kind, visitor);
      case code(0, 0, 1):
        return pull_like<0, 0, 1>(words, kind, visitor);
      case code(1, 0, 1):
        return pull_like<1, 0, 1>(words, kind, visitor);
      case code(0, 1, 1):
        return pull_like<0, 1, 1>(words, kind, visitor);
      case code(0, 0, 2):
        return pull_like<0, 0, 2>(words, kind, visitor);
      case code(1, 0, 2):
        return pull_like<1, 0, 2>(words, kind, visitor);
      case code(2, 0, 1):
        return pull_like<2, 0, 1>(words, kind, visitor);
      case code(0, 0, 3):
        return pull_like<0, 0, 3>(words, kind, visitor);
      case code(0, 0, 4):
        return pull_like<0, 0, 4>(words, kind, visitor);
      case code(1, 0, 4):
        return pull_like<1, 0, 4>(words, kind, visitor);
      default:
        pull_any(words, *kind--, visitor);
    }
  }

  [[gnu::always_inline]] static inline void skip_inputs(const Word*& words, const StatementKind*& kind,
                                                        Visitor& visitor) {
    const StatementKind* const last = kind;
    for (std::uint64_t eight = 0;; kind -= sizeof(eight)) {  // chunk_begin ends this, too
      std::memcpy(&eight, kind - (sizeof(eight) - 1), sizeof(eight));
      if (eight != 0) break;
    }
    while (*kind == StatementKind::input) --kind;
    const auto count = static_cast<std::size_t>(last - kind);
    words -= count;
    visitor.skip(count);
  }

  template <std::size_t Plus, std::size_t Minus, std::size_t General>
  [[gnu::always_inline]] static inline void pull_like(const Word*& words, const StatementKind*& kind,
                                                      Visitor& visitor) {
    constexpr OperandCounts counts{Plus, Minus, General};
    typename Visitor::template Run<Plus, Minus, General> run(visitor);
    do {
      words -= words_of<T>(counts);
      run.pull(words);
    } while (*--kind == kind_of(counts));
  }

  [[gnu::always_inline]] static inline void pull_any(const Word*& words, StatementKind kind,
                                                     Visitor& visitor) {
    const OperandCounts counts =
        kind == StatementKind::many_pairs ? OperandCounts{0, 0, words[-1]} : counts_of(kind);
    words -= words_before<T>(words, kind);
    visitor.pull(counts, words);
  }
};
}  // namespace tapestry::detail
