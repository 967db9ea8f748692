#pragma once
#include <tapestry/autodiff/detail/tape/deferred_throw.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>
#include <tapestry/autodiff/detail/tape/tape_state.hpp>

namespace tapestry::detail {
/// Writes general operands behind the head of a tape, without checking where they were recorded.
template <class T>
class PairSink {
 public:
  explicit PairSink(Word* words) : end_(words) {}

  template <class Factor>
  void add(Link link, Factor factor) {
    write_pair(end_, link.index(), as_number<T>(factor));
    end_ += pair_words<T>;
  }
  [[nodiscard]] Word* end() const { return end_; }

 private:
  Word* end_;
};

/// Collects operands whose number is not known.
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

/// Records a formula that the fast way cannot record: with passive or older variables, without room, without
/// an active tape, or on a tape that watches values. Throws nothing, see deferred_throw.hpp.
/// \returns a passive link if it failed; the caller must call throw_deferred()
template <class T>
[[nodiscard, gnu::noinline]] Link record_carefully(const T& value, const Link* links, const T* partials,
                                                   std::size_t count) noexcept {
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

/// The same with partial derivatives from registers: one function for all formulas of as many operands.
template <class T, class... Partials>
[[nodiscard, gnu::noinline, gnu::cold]] Link record_from_registers(const Link* links, T value,
                                                                   Partials... partials) noexcept {
  const T all[] = {partials...};
  return record_carefully<T>(value, links, all, sizeof...(partials));
}

/// Operands of a formula whose number the compiler knows, in the order of statement.hpp. They are computed
/// before the choice between the ways to record them, so that their code stands once, and at constant places,
/// so that all stay in registers.
template <class T, OperandCounts counts>
class CountedOperands {
 public:
  void add(Link link, T partial) { put(general_++, link, partial); }
  void add(Link link, One) { put(plus_ == counts.plus ? general_++ : counts.general + plus_++, link, T(1)); }
  void add(Link link, MinusOne) {
    put(minus_ == counts.minus ? general_++ : counts.general + counts.plus + minus_++, link, T(-1));
  }

  /// Writes the statement in the layout of statement.hpp.
  [[gnu::always_inline]] void write(Word* words) const {
    write(words, std::make_index_sequence<counts.general>(),
          std::make_index_sequence<counts.plus + counts.minus>());
  }
  /// Writes the statement without passive variables.
  /// \param kind   receives its kind; `words` becomes its end
  /// \returns      whether all others are of the link's generation; else nothing counts
  [[gnu::always_inline]] bool write_active(Word*& words, Link next, unsigned& kind) const {
    std::uint64_t difference = 0;
    for (std::size_t i = 0; i < counts.sum(); ++i) {
      if (!links_[i].is_active()) continue;
      difference |= links_[i].difference(next);
      if (i < counts.general) {
        write_pair(words, links_[i].index(), partials_[i]);
        words += pair_words<T>;
        kind += static_cast<unsigned>(kind_of({0, 0, 1}));
      } else {
        *words++ = links_[i].index();
        kind +=
            static_cast<unsigned>(i < counts.general + counts.plus ? kind_of({1, 0, 0}) : kind_of({0, 1, 0}));
      }
    }
    return difference >> 32U == 0;
  }
  [[gnu::always_inline]] Link record_carefully(const T& value) const {
    return record_carefully(value, std::make_index_sequence<counts.sum()>());
  }

 private:
  void put(std::size_t place, Link link, T partial) {
    links_[place] = link;
    partials_[place] = partial;
  }
  template <std::size_t... General, std::size_t... Unit>
  [[gnu::always_inline]] void write(Word* words, std::index_sequence<General...>,
                                    std::index_sequence<Unit...>) const {
    (write_pair(words + General * pair_words<T>, links_[General].index(), partials_[General]), ...);
    ((words[counts.general * pair_words<T> + Unit] = links_[counts.general + Unit].index()), ...);
  }
  template <std::size_t... Place>
  [[gnu::always_inline]] Link record_carefully(const T& value, std::index_sequence<Place...>) const {
    const Link links[] = {links_[Place]...};
    return record_from_registers<T>(links, value, partials_[Place]...);
  }

  Link links_[counts.sum()];
  T partials_[counts.sum()];
  std::size_t general_ = 0, plus_ = 0, minus_ = 0;
};

/// Whether E always pushes the same operands, and a kind can hold their counts.
template <class E>
[[nodiscard]] constexpr bool has_kind() {
  constexpr OperandCounts counts = within_kind(counts_of_expression<E, One>());
  return pushes_all<E>() && counts.sum() != 0 && counts.general <= largest_counts.general;
}

/// record_statement() of a formula whose counts a kind can hold.
template <class E>
[[gnu::always_inline]] inline void record_of_kind(const E& formula, Link& link) {
  using T = typename E::ExpressionScalar;
  constexpr OperandCounts counts = within_kind(counts_of_expression<E, One>());
  CountedOperands<T, counts> operands;
  formula.push(One{}, operands);
  WriteHead& head = *TapeState<T>::active;
  Link next = head.next;
  if (head.has_usual_room() && formula.difference(next) >> 32U == 0) [[likely]] {
    Word* const words = head.words;
    __builtin_prefetch(words + prefetched_words, 1);
    const std::uintptr_t kinds_base = head.kinds_base;  // read all before writing the first word
    operands.write(words);
    *reinterpret_cast<StatementKind*>(kinds_base + next.index()) = kind_of(counts);
    head.words = words + words_of<T>(counts);
    link = next;
    head.next = ++next;
    return;
  }
  if (formula.difference(Link()) == 0) return;  // passive
  if constexpr (counts.sum() > 1) {
    Word* words = head.words;
    const std::uintptr_t kinds_base = head.kinds_base;
    unsigned kind = 0;
    if (head.has_usual_room() && operands.write_active(words, next, kind)) {
      *reinterpret_cast<StatementKind*>(kinds_base + next.index()) = static_cast<StatementKind>(kind);
      head.words = words;
      link = next;
      head.next = ++next;
      return;
    }
  }
  link = operands.record_carefully(formula.value());
  if (!link.is_active()) [[unlikely]]
    throw_deferred();
}

/// Records a formula as one statement of the active tape, or not at all if it is passive. One comparison
/// finds room for it, and one for each variable checks that it was recorded there since the last rewind.
/// \throws DomainError if it is active but no tape is, or it uses a variable not on the tape
template <class E>
[[gnu::always_inline]] inline void record_statement(const E& formula, Link& link) {
  using T = typename E::ExpressionScalar;
  if constexpr (CountsOperands<E> && E::operand_bound * pair_words<T> < WriteHead::usual_words) {
    if constexpr (has_kind<E>()) return record_of_kind(formula, link);
    WriteHead& head = *TapeState<T>::active;
    if (head.has_usual_room() && formula.difference(head.next) >> 32U == 0) [[likely]] {
      PairSink<T> sink(head.words);
      formula.push(One{}, sink);
      link = static_cast<TapeState<T>&>(head).commit_pairs(sink.end());
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
