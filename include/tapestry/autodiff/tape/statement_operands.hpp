#pragma once
#include <cstddef>
#include <tapestry/autodiff/tape/statement.hpp>

namespace tapestry::detail {

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
