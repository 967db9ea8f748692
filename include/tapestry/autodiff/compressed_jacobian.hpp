#pragma once
#include <tapestry/autodiff/detail/jacobian/jacobian_pattern.hpp>
#include <tapestry/autodiff/detail/jacobian/tangent_sweep.hpp>
#include <tapestry/autodiff/jacobian.hpp>

namespace tapestry {
/// Plan for computing a Jacobian of a known pattern in few sweeps: backwards for rows that share no column,
/// or forwards for columns that share no row, whichever takes fewer colours; backwards at a tie.
class JacobianPlan {
 public:
  JacobianPlan() = default;
  explicit JacobianPlan(JacobianPattern pattern)
      : pattern_(std::move(pattern)),
        rows_(colour_columns(pattern_.transposed())),
        columns_(colour_columns(pattern_)),
        goes_forward_(columns_.colour_count < rows_.colour_count) {}

  [[nodiscard]] const JacobianPattern& pattern() const { return pattern_; }
  /// Whether its sweeps run forwards over the recording, not backwards.
  [[nodiscard]] bool goes_forward() const { return goes_forward_; }
  /// Directions that the sweeps take, eight of them each.
  [[nodiscard]] std::size_t direction_count() const { return colouring().colour_count; }
  /// Colouring of the columns when it goes forward, else of the rows.
  [[nodiscard]] const ColumnColouring& colouring() const { return goes_forward_ ? columns_ : rows_; }
  /// Colouring of the rows, whichever way it goes.
  [[nodiscard]] const ColumnColouring& row_colouring() const { return rows_; }

 private:
  JacobianPattern pattern_;
  ColumnColouring rows_, columns_;
  bool goes_forward_ = false;
};

namespace detail {
/// One backward pass over the tape: every statement hands its sets on to its operands.
/// \returns the set of each wanted statement
template <class T>
[[nodiscard]] std::vector<IndexSets::Name> hand_sets_back(const TapeState<T>& state, PendingSets& pending,
                                                          IndexSets& sets, std::vector<bool> is_wanted) {
  visit_results(state, [&](std::size_t result) { is_wanted[result] = true; });
  std::vector<IndexSets::Name> set_of(is_wanted.size(), 0);
  std::vector<IndexSets::Name> results;
  std::vector<std::uint32_t> inputs;
  std::size_t record = state.record_count();
  state.visit_backwards([&](const StatementRun& run) {
    const Word* end = run.words_end;
    for (std::size_t index = run.end_index; index-- > run.first_index;) {
      const StatementKind kind = run.kinds[index - run.first_index];
      IndexSets::Name set = pending.take(index, sets);
      inputs.clear();
      if (kind == StatementKind::record) {
        const HeldRecord<T>& held = state.records()[--record];
        results.assign({set});
        for (std::size_t i = 1; i <= held.results; ++i) results.push_back(set_of[index + i]);
        std::erase(results, IndexSets::Name(0));
        set = sets.join(results);
        held.record->list_inputs(inputs);
      }
      if (is_wanted[index]) set_of[index] = set;
      end = for_each_operand<T>(end, kind, [&](std::size_t operand, T) {
        if (set != 0) pending.add(operand, set);
      });
      if (set != 0)
        for (const std::uint32_t input : inputs) pending.add(input, set);
    }
  });
  return set_of;
}

inline void require_pattern_of(const JacobianPattern& pattern, std::size_t roots, std::size_t variables,
                               std::size_t values) {
  if (pattern.row_count() != roots || pattern.column_count() != variables)
    throw DomainError({"compressed_jacobian: ", roots, " roots and ", variables, " variables, expected ",
                       pattern.row_count(), " and ", pattern.column_count()});
  if (pattern.entry_count() != values)
    throw DomainError(
        {"compressed_jacobian: room for ", values, " entries, expected ", pattern.entry_count()});
}

template <class T>
void compressed_forwards(const TapeState<T>& state, std::span<const Variable<T>> roots,
                         std::span<const Variable<T>> variables, const JacobianPlan& plan,
                         std::span<T> values) {
  constexpr std::size_t width = 8;
  const JacobianPattern& pattern = plan.pattern();
  const auto& colour_of = plan.colouring().colour_of;
  TangentVectors<T, width> tangents;
  std::vector<std::size_t> directions(variables.size());
  for (std::size_t first = 0; first < plan.direction_count(); first += width) {
    for (std::size_t j = 0; j < directions.size(); ++j)
      directions[j] = std::size_t(colour_of[j]) - first;  // wraps beyond width for earlier colours
    tangents.sweep(state, variables, directions);
    pattern.visit([&](std::size_t row, std::size_t column, std::size_t e) {
      if (directions[column] < width) values[e] = tangents.of(roots[row], directions[column]);
    });
  }
}

/// Adjoints of sums of rows of the same colour, eight colours a sweep.
template <class T>
void compressed_backwards(TapeState<T>& state, std::span<const Variable<T>> roots,
                          std::span<const Variable<T>> variables, const JacobianPlan& plan,
                          std::span<T> values) {
  constexpr std::size_t width = 8;
  const JacobianPattern& pattern = plan.pattern();
  const auto& colour_of = plan.row_colouring().colour_of;
  VectorAdjoints<T, width> adjoints;
  for (std::size_t first = 0; first < plan.row_colouring().colour_count; first += width) {
    const auto lane_of = [&](std::size_t row) { return std::size_t(colour_of[row]) - first; };
    sweep_vectors<T, width>(state, roots, &variables, adjoints, lane_of);
    const auto adjoint_of = [&](const Link& link, std::size_t lane) {
      const T* const found =
          link.is_active() && link.index() < adjoints.size() ? adjoints.of(link.index()) : nullptr;
      return found == nullptr ? T(0) : found[lane];
    };
    pattern.visit([&](std::size_t row, std::size_t column, std::size_t e) {
      if (lane_of(row) < width) values[e] = adjoint_of(variables[column].link(), lane_of(row));
    });
  }
}
}  // namespace detail

/// Finds the `variables` that each of `roots` depends on, as entries (root, variable), in one backward pass
/// over the tape that hands on sets of roots. An operand counts even where its partial derivative is 0. The
/// side that max(), min(), abs() or a comparison did not take does not count: a pattern serves other
/// recordings that choose the same sides. Operations with a pullback are opaque: each of their results counts
/// as computed from all of their inputs, and an array as one number. A pattern made by hand that leaves some
/// of these out takes fewer directions.
/// \throws DomainError if a root or a variable is not on the tape
template <std::floating_point T>
[[nodiscard]] JacobianPattern sparsity_pattern(const Tape<T>& tape, std::span<const Variable<T>> roots,
                                               std::span<const Variable<T>> variables) {
  const auto& state = *tape.shared_state();
  for (const auto& variable : variables) state.require_own_if_active(variable.link());
  detail::IndexSets sets;
  detail::PendingSets pending(state.statement_count() + 1);
  for (std::size_t i = 0; i < roots.size(); ++i) {
    state.require_own_if_active(roots[i].link());
    if (roots[i].is_active())
      pending.add(roots[i].link().index(), sets.single(static_cast<std::uint32_t>(i)));
  }
  std::vector<bool> is_wanted(state.statement_count() + 1, false);
  for (const auto& variable : variables) is_wanted[variable.link().index()] = true;
  const auto sets_of = detail::hand_sets_back(state, pending, sets, std::move(is_wanted));
  std::vector<JacobianPattern::Entry> entries;
  for (std::size_t j = 0; j < variables.size(); ++j) {
    if (!variables[j].is_active()) continue;
    for (const auto root : sets.members(sets_of[variables[j].link().index()])) entries.push_back({root, j});
  }
  return {roots.size(), variables.size(), std::move(entries)};
}

/// The entries of d roots / d variables in the plan's pattern, in its order, from the tape's recording.
/// Entries that the pattern wrongly leaves out are added to others. Sweeps a tape with pullbacks backwards,
/// whichever way the plan goes, and calls each pullback once for each colour of the rows.
/// \throws DomainError if a root or a variable is not on the tape, or there are not as many roots, variables
///         and values as the pattern has
template <std::floating_point T>
void compressed_jacobian(const Tape<T>& tape, std::span<const std::type_identity_t<Variable<T>>> roots,
                         std::span<const std::type_identity_t<Variable<T>>> variables,
                         const JacobianPlan& plan, std::span<std::type_identity_t<T>> values) {
  auto& state = *tape.shared_state();
  detail::require_pattern_of(plan.pattern(), roots.size(), variables.size(), values.size());
  for (const auto& root : roots) state.require_own_if_active(root.link());
  for (const auto& variable : variables) state.require_own_if_active(variable.link());
  if (plan.goes_forward() && state.record_count() == 0) {
    detail::compressed_forwards<T>(state, roots, variables, plan, values);
  } else {
    detail::compressed_backwards<T>(state, roots, variables, plan, values);
  }
}
}  // namespace tapestry
