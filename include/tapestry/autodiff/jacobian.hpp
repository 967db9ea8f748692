#pragma once
#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/detail/tape/vector_sweep.hpp>

namespace tapestry {
namespace detail {
/// Calls visit for each statement that is a result of a record; the record stands before it.
template <class T, class Visit>
void visit_results(const TapeState<T>& state, Visit visit) {
  std::size_t record = state.records().size();
  state.visit_backwards([&](const StatementRun& run) {
    for (std::size_t i = run.end_index; i-- > run.first_index && record > 0;)
      if (run.kinds[i - run.first_index] == StatementKind::record)
        for (std::size_t result = state.records()[--record].results; result > 0; --result) visit(i + result);
  });
}

/// Sweeps the tape once with root k as the seed of direction lane_of(k); a root whose lane is Width or more
/// seeds none. Keeps all adjoints, or those of the variables in `kept`.
/// \throws DomainError if a root or a variable to keep is not on the tape, or if called from within a
/// pullback
template <std::floating_point T, std::size_t Width, class LaneOf>
void sweep_vectors(TapeState<T>& state, std::span<const Variable<T>> roots,
                   const std::span<const Variable<T>>* kept, VectorAdjoints<T, Width>& adjoints,
                   LaneOf lane_of) {
  ++state.vector_sweeps;
  std::size_t last = 0;
  for (const Variable<T>& root : roots) {
    state.require_own_if_active(root.link());
    last = std::max(last, std::size_t(root.link().index()));
  }
  adjoints.start(last, state.leading_input_count(), kept == nullptr);
  if (kept != nullptr)
    for (const Variable<T>& variable : *kept) {
      state.require_own_if_active(variable.link());
      adjoints.keep(variable.link().index());
    }
  std::size_t lane_count = 0;
  for (std::size_t k = 0; k < roots.size(); ++k)
    if (const std::size_t lane = lane_of(k); lane < Width && roots[k].is_active()) {
      adjoints.view().at(roots[k].link().index(), adjoints)[lane] += T(1);
      lane_count = std::max(lane_count, lane + 1);
    }
  state.sweep_outside([&](std::span<const HeldRecord<T>> records) {
    if (kept != nullptr) visit_results(state, [&](std::size_t result) { adjoints.keep(result); });
    VectorPullbacks<T, Width> pullbacks(records, lane_count, last, state.adjoint_lane, adjoints);
    state.visit_backwards([&](const StatementRun& run) {
      VectorSweep<T, Width>::run(
          run, last, adjoints, [&](std::size_t statement) { pullbacks.run(statement); },
          [&] { pullbacks.skip(); });
    });
    adjoints.pass(0, true);
  });
}
}  // namespace detail

/// Adjoints by up to Width roots at once: one sweep over the tape for all of them. Keeps its memory, at most
/// Width · sizeof(T) bytes a statement, from sweep to sweep.
///
///   AdjointVectors<double, 8> adjoints;
///   adjoints.reverse(tape, roots);
///   adjoints.of(x)[k]                   // d roots[k] / d x
/// \tparam Width  a power of two
template <std::floating_point T, std::size_t Width>
class AdjointVectors {
 public:
  /// Sweeps the tape; the adjoints of Tape::reverse() stay. Keeps the adjoints of all variables. Operations
  /// with a pullback take one root at a time: their pullback is called once a root, and each array has an
  /// adjoint for each root. record_mark() is called once.
  /// \throws DomainError if there are more than Width roots, or one is not on the tape, or if called from
  ///         within a pullback
  void reverse(const Tape<T>& tape, std::span<const Variable<T>> roots) { sweep(tape, roots, nullptr); }

  /// The same, but keeps only the adjoints of the variables in `kept`, and so costs less: the adjoints of a
  /// long tape fill much more memory than the tape.
  /// \throws DomainError, too, if one of them is not on the tape
  void reverse(const Tape<T>& tape, std::span<const Variable<T>> roots, std::span<const Variable<T>> kept) {
    sweep(tape, roots, &kept);
  }

  /// d roots[k] / d variable for each k of the last reverse(): zeros where there was no root.
  /// \throws DomainError if the variable is active but not on the tape that was swept, if the tape was
  ///   cleared or rewound since, or if the adjoint was not kept
  [[nodiscard]] std::array<T, Width> of(const Variable<T>& variable) const {
    std::array<T, Width> adjoints{};
    const detail::Link link = variable.link();
    if (!link.is_active()) return adjoints;
    require_swept(link);
    if (link.index() >= adjoints_.size()) return adjoints;
    if (!adjoints_.keeps(link.index()))
      throw DomainError("AdjointVectors: the variable was not among those whose adjoints to keep");
    if (const T* const found = adjoints_.of(link.index())) std::copy_n(found, Width, adjoints.begin());
    return adjoints;
  }

  /// d roots[k] / d array, of the extents of the ArrayVariable's value; zeros if k is no root. Array adjoints
  /// are kept on the tape, until its next sweep of several roots.
  /// \throws DomainError as for variables, if k is not below Width, or after another such sweep of the tape
  template <class ArrayOnTape>
  requires requires(const ArrayOnTape& array) { array.shared_adjoint(); }
  [[nodiscard]] const auto& of(const ArrayOnTape& array, std::size_t k) const {
    if (k >= Width) throw DomainError({"AdjointVectors: root ", k, ", expected one below ", Width});
    if (!array.is_active()) return array.adjoint();
    require_swept(array.link());
    if (state_->vector_sweeps != sweep_)
      throw DomainError("AdjointVectors: array adjoints are those of a later sweep of several roots");
    return array.shared_adjoint()->read_lane(k + 1);
  }

 private:
  void require_swept(detail::Link link) const {
    if (!state_ || state_->next.generation() != generation_)
      throw DomainError("AdjointVectors: no tape was swept, or it was cleared or rewound since");
    state_->require_own(link);
  }

  void sweep(const Tape<T>& tape, std::span<const Variable<T>> roots,
             const std::span<const Variable<T>>* kept) {
    const auto& state = tape.shared_state();
    if (roots.size() > Width)
      throw DomainError({"AdjointVectors: ", roots.size(), " roots, expected at most ", Width});
    state_ = {};  // until the sweep is done
    detail::sweep_vectors<T, Width>(*state, roots, kept, adjoints_, [](std::size_t k) { return k; });
    state_ = state;
    generation_ = state->next.generation();
    sweep_ = state->vector_sweeps;
  }

  detail::VectorAdjoints<T, Width> adjoints_;
  detail::Shared<detail::TapeState<T>> state_;
  std::uint32_t generation_ = 0;
  std::uint64_t sweep_ = 0;  ///< number of the last sweep here, counted over the tape
};

/// d roots[i] / d variables[j] at [i · variables.size() + j], eight roots a sweep. Sweeps a tape with
/// arrays once for each root, so that one adjoint of each array is in memory. The tape's own adjoints
/// are then the last root's.
/// \throws DomainError if a root or a variable is not on the tape
template <std::floating_point T>
[[nodiscard]] std::vector<T> jacobian(Tape<T>& tape, std::span<const std::type_identity_t<Variable<T>>> roots,
                                      std::span<const std::type_identity_t<Variable<T>>> variables) {
  constexpr std::size_t width = 8;
  std::vector<T> result(roots.size() * variables.size());
  const std::span<T> rows(result);
  if (tape.shared_state()->adjoint_lane != nullptr) {
    for (std::size_t i = 0; i < roots.size(); ++i) {
      tape.reverse(roots[i]);
      tape.adjoints(variables, rows.subspan(i * variables.size(), variables.size()));
    }
    return result;
  }
  AdjointVectors<T, width> adjoints;
  for (std::size_t begin = 0; begin < roots.size(); begin += width) {
    const std::size_t count = std::min(width, roots.size() - begin);
    adjoints.reverse(tape, roots.subspan(begin, count), variables);
    for (std::size_t j = 0; j < variables.size(); ++j) {
      const auto column = adjoints.of(variables[j]);
      for (std::size_t k = 0; k < count; ++k) result[(begin + k) * variables.size() + j] = column[k];
    }
  }
  return result;
}

/// The Jacobian at x of f: span<const S> → range of S, with its shape. A function of one result may return a
/// plain S.
///
///   const auto j = jacobian(f, {1., 2.});  // j.rows × j.columns; j(1, 0) = d f[1] / d x[0]
///
/// Sweeps forwards with duals, eight columns a call, for up to eight inputs or more results than inputs; else
/// backwards over a tape, eight rows a sweep. An f that takes variables alone, span<const Variable<T>>, is
/// always swept backwards. A result that does not depend on x has a row of zeros.
/// \throws DomainError if f returns another number of results from one call to the next
template <std::floating_point T = double, class Function>
[[nodiscard]] DenseJacobian<T> jacobian(const Function& f, Point<std::type_identity_t<T>> x) {
  constexpr bool takes_duals =
      std::invocable<const Function&, std::span<const Dual<T, detail::columns_a_call, Function>>>;
  if constexpr (takes_duals)
    if (x.size() <= detail::columns_a_call) return detail::jacobian_by_duals<T>(f, x);
  detail::SpareTape<T> tape;
  const auto scope = tape->activate();
  const std::span<const Variable<T>> inputs = tape.input(x);
  const auto roots = detail::results_of<Variable<T>>(f(inputs));
  if constexpr (takes_duals)
    if (roots.size() > x.size()) return detail::jacobian_by_duals<T>(f, x);
  DenseJacobian<T> result{roots.size(), x.size(), jacobian(*tape, roots, inputs), {}};
  for (const Variable<T>& root : roots) result.values.push_back(root.value());
  return result;
}
}  // namespace tapestry
