#pragma once
#include <tapestry/autodiff/variable.hpp>

namespace tapestry::detail {
/// Tangents of all statements of a tape in Width directions at once: a forward sweep over the recording,
/// without computing it anew. For a tape without operations with a pullback.
template <std::floating_point T, std::size_t Width>
class TangentVectors {
  using Lanes [[gnu::vector_size(Width * sizeof(T)), gnu::may_alias]] = T;

 public:
  /// Sets the tangents of `inputs` and computes all others. Input i has 1 in direction directions[i], or 0 in
  /// all if that is Width or more.
  void sweep(const TapeState<T>& state, std::span<const Variable<T>> inputs,
             std::span<const std::size_t> directions) {
    memory_.zero(state.statement_count());
    for (std::size_t i = 0; i < inputs.size(); ++i)
      if (directions[i] < Width && inputs[i].is_active())
        memory_.data()[inputs[i].link().index()][directions[i]] += T(1);
    runs_.clear();
    state.visit_backwards([&](const StatementRun& run) { runs_.push_back(run); });
    for (std::size_t i = runs_.size(); i-- > 0;) {
      find_ends(runs_[i]);
      run_forwards(runs_[i]);
    }
  }

  [[nodiscard]] T of(const Variable<T>& variable, std::size_t direction) const {
    return variable.is_active() ? memory_.data()[variable.link().index()][direction] : T(0);
  }

 private:
  /// Statements can only be found from the last one on, so their ends are found first.
  void find_ends(const StatementRun& run) {
    const std::size_t count = run.end_index - run.first_index;
    ends_.resize(count);
    const Word* end = run.words_end;
    for (std::size_t i = count; i-- > 0; end -= words_before<T>(end, run.kinds[i])) ends_[i] = end;
  }

  void run_forwards(const StatementRun& run) {
    auto* const lanes = reinterpret_cast<Lanes*>(memory_.data());
    const Word* const* const ends = ends_.data();
    const auto body = [&](auto) __attribute__((always_inline)) { run_statements(run, ends, lanes); };
    run_with(instruction_set(), body);
  }

  struct Sum {
    const Lanes* lanes;
    Lanes total;
    [[gnu::always_inline]] void operator()(std::uint32_t index, T partial) {
      if (partial == T(0)) [[unlikely]]
        return;
      const Lanes tangent = lanes[index];
      const Lanes product = tangent * partial;
      total += tangent == Lanes{} ? Lanes{} : product;
    }
  };

  [[gnu::always_inline]] static inline void run_statements(const StatementRun& run, const Word* const* ends,
                                                           Lanes* lanes) {
    const std::size_t count = run.end_index - run.first_index;
    for (std::size_t i = 0; i < count; ++i) {
      Sum sum{lanes, lanes[run.first_index + i]};
      for_each_operand<T>(ends[i], run.kinds[i], sum);
      lanes[run.first_index + i] = sum.total;
    }
  }

  AdjointMemory<std::array<T, Width>> memory_;
  std::vector<StatementRun> runs_;
  std::vector<const Word*> ends_;
};
}  // namespace tapestry::detail
