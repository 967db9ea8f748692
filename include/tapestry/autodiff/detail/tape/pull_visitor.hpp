#pragma once
#include <tapestry/autodiff/detail/tape/statement.hpp>

namespace tapestry::detail {
/// Passes the adjoints of statements on to their operands, as StatementWalk finds them: each adds
/// adjoint · partial to the adjoint of an operand. A zero adjoint passes nothing on, not even through an
/// infinite partial.
///
/// \tparam Adjoints  access to adjoints. Has types T of partials, Value of adjoints and, all to be inlined,
///   own(index), the adjoint of the current statement, and of(operand)
///   is_zero(adjoint), and touch(), called where it is not and at operations with a pullback
///   add_product(sum, adjoint, partial)
///   pass(index), called when the sweep is done with that statement; pass_many(index), with all from there on
/// \tparam PullBack  pull_back(index) runs an operation with a pullback
template <class Adjoints, class PullBack>
struct PullVisitor {
  using T = typename Adjoints::T;
  using Value = typename Adjoints::Value;

  Adjoints adjoints;
  Word index;  ///< end of the next statement
  PullBack& pull_back;

  [[gnu::always_inline]] void skip(std::size_t count) {
    adjoints.pass_many(index -= static_cast<Word>(count));
  }
  [[gnu::always_inline]] void pull_record() {
    adjoints.touch();
    pull_back(static_cast<std::size_t>(--index));
    adjoints.pass(index);
  }
  [[gnu::always_inline]] void pull(const OperandCounts& counts, const Word* words) {
    const Value adjoint = adjoints.own(--index);
    if (!adjoints.is_zero(adjoint)) [[likely]] {
      adjoints.touch();
      __builtin_prefetch(words - prefetched_words);
      for (std::size_t i = 0; i < counts.general; ++i, words += pair_words<T>)
        adjoints.add_product(adjoints.of(index_of_pair<T>(words)), adjoint, partial_of_pair<T>(words));
      for (std::size_t i = 0; i < counts.plus; ++i) adjoints.of(*words++) += adjoint;
      for (std::size_t i = 0; i < counts.minus; ++i) adjoints.of(*words++) -= adjoint;
    }
    adjoints.pass(index);
  }

  /// Consecutive statements of one kind. A value that one statement writes and the next one reads stays in a
  /// register: memory takes three times as long as a sum. Such a value is the operand written last (or the
  /// first unit) if it is the next statement, as in sums and products of many terms; it is the last general
  /// operand if the next statement has it, too, as in products of a matrix and a vector.
  template <std::size_t Plus, std::size_t Minus, std::size_t General>
  class Run {
   public:
    [[gnu::always_inline]] explicit Run(PullVisitor& visitor) : visitor_(visitor) {}

    [[gnu::always_inline]] void pull(const Word* words) {
      if constexpr (!chains) return visitor_.pull({Plus, Minus, General}, words);
      Adjoints& all = visitor_.adjoints;
      const Word statement = --visitor_.index;
      Value adjoint = last_;
      if (statement != last_operand_) adjoint = all.own(statement);
      if (!all.is_zero(adjoint)) [[likely]] {
        all.touch();
        __builtin_prefetch(words - prefetched_words);
        for (std::size_t i = General; i-- > 0;) add(i, words + i * pair_words<T>, adjoint);
        const Word* const units = words + General * pair_words<T>;
        for (std::size_t i = Plus + Minus; i-- > Plus;) write(units[i], all.of(units[i]) -= adjoint);
        for (std::size_t i = Plus; i-- > 0;) write(units[i], all.of(units[i]) += adjoint);
      }
      all.pass(statement);
    }

   private:
    // Larger statements wait for other values, and differences seldom follow each other's results.
    static constexpr bool chains = Plus + Minus + General <= 3 && !(Minus == 1 && Plus + General == 1);
    static constexpr bool holds = General >= 2;

    [[gnu::always_inline]] void add(std::size_t i, const Word* pair, const Value& adjoint) {
      const Word operand = index_of_pair<T>(pair);
      Value& sum = visitor_.adjoints.of(operand);
      if (!holds || i != General - 1) {
        visitor_.adjoints.add_product(sum, adjoint, partial_of_pair<T>(pair));
        write(operand, sum);
      } else {
        if (operand != held_operand_) held_ = sum;
        visitor_.adjoints.add_product(held_, adjoint, partial_of_pair<T>(pair));
        sum = held_;
        held_operand_ = operand;
      }
    }
    [[gnu::always_inline]] void write(Word operand, const Value& sum) {
      last_operand_ = operand;
      last_ = sum;
      if (holds && operand == held_operand_) held_operand_ = 0;
    }

    PullVisitor& visitor_;
    Value last_{};
    Value held_{};
    Word last_operand_ = 0;  // no operand
    Word held_operand_ = 0;
  };
};
}  // namespace tapestry::detail
