#pragma once
#include <cstddef>
#include <cstdint>
#include <exception>
#include <tapestry/autodiff/tape/deferred_throw.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/formula.hpp>
#include <tapestry/autodiff/tape/tape_memory.hpp>
#include <tapestry/autodiff/tape/tape_state.hpp>
#include <utility>

namespace tapestry::detail {

/// Writes operands behind the head of a tape, without a look at where they were recorded. The order of
/// operands on the tape is that of statement.hpp.
template <class T>
class FastSink {
 public:
  /// \param counts  at least as many operands as will be added, within_kind()
  FastSink(Word* words, const OperandCounts& counts)
      : pair_(words),
        plus_(words + counts.general * pair_words<T>),
        plus_end_(plus_ + counts.plus),
        minus_(plus_end_),
        minus_end_(minus_ + counts.minus) {}

  void add(Link link, T partial) {
    write_pair(pair_, link.index(), partial);
    pair_ += pair_words<T>;
  }
  void add(Link link, One) { plus_ == plus_end_ ? add(link, T(1)) : add_unit(link, plus_); }
  void add(Link link, MinusOne) { minus_ == minus_end_ ? add(link, T(-1)) : add_unit(link, minus_); }

  [[nodiscard]] Word* pairs_end() const { return pair_; }

 private:
  static void add_unit(Link link, Word*& unit) { *unit++ = link.index(); }

  Word* pair_;
  Word* plus_;
  Word* plus_end_;
  Word* minus_;
  Word* minus_end_;
};

/// Collects operands where the fast way cannot record them.
template <class T, std::size_t Bound>
struct Operands {
  Link links[Bound];
  T partials[Bound];
  std::size_t count = 0;

  template <class Factor>
  void add(Link link, Factor factor) {
    links[count] = link;
    partials[count++] = as_number<T>(factor);
  }
};

/// A formula that the fast way cannot record: with passive or older variables, where there is no more room,
/// or where no tape is active, or one that watches values. Throws nothing, as deferred_throw.hpp says.
/// \returns a passive link if it failed; throw_deferred() is to follow
template <class T>
[[nodiscard, gnu::noinline, gnu::cold]] Link record_carefully(const T& value, const Link* links,
                                                              const T* partials, std::size_t count) noexcept {
  try {
    TapeState<T>& state = TapeState<T>::require_active();
    const Link link = state.append_linear(
        count, [links](std::size_t i) { return links[i]; }, partials);
    state.note_value(link, static_cast<double>(value_of<Base<T>>(value)));
    return link;
  } catch (...) {
    deferred_exception() = std::current_exception();
    return {};
  }
}

/// Records a formula as one statement of the active tape, or not at all if it is passive. One comparison
/// finds room for it, and one for each variable tells that it was recorded there since the last rewind.
/// \throws DomainError if it is active but no tape is, or it uses a variable not on the tape
template <class E>
[[gnu::always_inline]] inline void record_statement(const E& formula, Link& link) {
  using T = typename E::ExpressionScalar;
  constexpr OperandCounts counts = within_kind(counts_of_expression<E, One>());
  if constexpr (CountsOperands<E> && E::operand_bound * pair_words<T> < WriteHead::usual_words) {
    WriteHead& head = *TapeState<T>::active;
    Link next = head.next;
    if (head.has_usual_room() && formula.difference(next) >> 32U == 0) [[likely]] {
      if constexpr (E::always_pushes_all && counts.general <= largest_counts.general) {
        Word* const words = head.words;
        __builtin_prefetch(words + prefetched_words, 1);
        const std::uintptr_t kinds_base = head.kinds_base;  // all read before the first word is written
        FastSink<T> sink(words, counts);
        formula.push(One{}, sink);
        *reinterpret_cast<StatementKind*>(kinds_base + next.index()) = kind_of(counts);
        head.words = words + words_of<T>(counts);
        link = next;
        head.next = ++next;
      } else {
        FastSink<T> sink(head.words, {0, 0, E::operand_bound});
        formula.push(One{}, sink);
        link = static_cast<TapeState<T>&>(head).commit_pairs(sink.pairs_end());
      }
      return;
    }
  }
  if (!formula.is_active()) return;
  Operands<T, E::operand_bound> operands;
  push_factor(formula, One{}, operands);
  link = record_carefully<T>(formula.value(), operands.links, operands.partials, operands.count);
  if (!link.is_active()) [[unlikely]]
    throw_deferred();
}

}  // namespace tapestry::detail
