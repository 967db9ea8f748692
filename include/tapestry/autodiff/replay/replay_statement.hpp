#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <tapestry/autodiff/replay/replay_program.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/placed_formula.hpp>
#include <tapestry/core/error.hpp>
#include <type_traits>
#include <utility>

namespace tapestry {

namespace detail {
/// f(k) for each place of a formula with so many variables, k a constant.
template <std::size_t Variables, class Function>
[[gnu::always_inline]] inline void for_each_place(const Function& f) {
  [&]<std::size_t... Places>(std::index_sequence<Places...>) __attribute__((always_inline)) {
    (f(std::integral_constant<std::size_t, Places>()), ...);
  }
  (std::make_index_sequence<Variables>());
}

/// Operands that one statement of a frame reads.
template <class T, std::size_t Variables>
struct ReplayOperands {
  std::array<T, Variables> values;
  const T* constant;

  [[gnu::always_inline]] explicit ReplayOperands(const T* first_constant) : constant(first_constant) {}
  [[gnu::always_inline]] ReplayOperands(const T* all, const std::uint32_t* slots, const T* first_constant)
      : constant(first_constant) {
    for_each_place<Variables>([&](auto k) { values[k] = all[slots[k]]; });
  }
  [[nodiscard, gnu::always_inline]] T next_constant() { return *constant++; }
  template <std::size_t Place>
  [[nodiscard, gnu::always_inline]] T variable() const {
    return values[Place];
  }
};

/// Whether E has the form x ∘ y with a variable first, as in x = x ∘ y.
template <class E>
inline constexpr bool is_update = false;
template <class Operation, std::floating_point T, std::size_t Lanes, class Y>
inline constexpr bool is_update<Binary<Operation, Replayable<T, Lanes>, Y>> = true;

/// Statements of expression type E. Those with costly functions keep their partial derivatives from the
/// forward pass; others compute them again, which needs no memory.
template <class E>
struct ReplayStatement {
  using T = typename E::ExpressionScalar;
  using Formula = typename Placed<E>::type;
  static constexpr std::size_t variables = LeafCounts<E>::variables;
  static constexpr std::size_t constants = LeafCounts<E>::constants;
  static constexpr bool keeps_partials = !is_cheap<E>() && pushes_all<E>();
  static constexpr bool can_chain = is_update<E> && pushes_all<E>();

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    T* const values = arrays.values + run.result;
    if constexpr (can_chain)
      if (run.is_chain) {
        T last = values[-1];
        for (std::size_t i = 0, count = run.count; i < count; ++i) {
          Operands operands = operands_of(run, arrays, i);
          operands.values[0] = last;
          values[i] = last = compute(operands, run, arrays, i);
        }
        return;
      }
    for (std::size_t i = 0, count = run.count; i < count; ++i) {
      Operands operands = operands_of(run, arrays, i);
      values[i] = compute(operands, run, arrays, i);
    }
  }

  static void backward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    T* const results = arrays.adjoints + run.result;
    if constexpr (can_chain)
      if (run.is_chain) {
        T adjoint = results[run.count - 1];
        for (std::size_t i = run.count; i-- > 0;) {
          const T before = results[static_cast<std::ptrdiff_t>(i) - 1];
          results[i] = T(0);
          const Pushed pushed = pull(run, arrays, i, adjoint);
          adjoint = before + pushed[0];
          add<1>(run, arrays, i, pushed);
        }
        results[-1] = adjoint;
        return;
      }
    for (std::size_t i = run.count; i-- > 0;) {
      const T adjoint = std::exchange(results[i], T(0));
      add<0>(run, arrays, i, pull(run, arrays, i, adjoint));
    }
  }

  static constexpr ReplayOperation<T> operation{
      .forward = forward,
      .backward = backward,
      .operand_count = variables,
      .constant_count = constants,
      .partial_count = keeps_partials ? variables : 0,
      .has_result = true,
      .can_chain = can_chain,
  };

 private:
  using Operands = ReplayOperands<T, variables>;
  using Pushed = std::array<T, variables>;

  [[gnu::always_inline]] static inline Operands operands_of(const ReplayRun<T>& run,
                                                            const ReplayArrays<T>& arrays, std::size_t i) {
    return {arrays.values, arrays.operands + run.operand + i * variables,
            arrays.constants + run.constant + i * constants};
  }

  [[gnu::always_inline]] static inline T compute(Operands& operands, const ReplayRun<T>& run,
                                                 const ReplayArrays<T>& arrays, std::size_t i) {
    const Formula formula = Formula::read(operands);
    if constexpr (keeps_partials) {
      PlacedSink<T, variables, false> sink{T(1)};
      formula.push(T(1), sink);
      T* const partials = arrays.partials + run.partial + i * variables;
      for_each_place<variables>([&](auto k) { partials[k] = sink.pushed[k]; });
    }
    return formula.value();
  }

  /// Gradients that statement i passes on. Plain products are tried first: they need no branches. Only where
  /// they come out as NaN may it be that a zero has met an infinite partial, which it does not pass.
  [[gnu::always_inline]] static inline Pushed pull(const ReplayRun<T>& run, const ReplayArrays<T>& arrays,
                                                   std::size_t i, T adjoint) {
    Pushed pushed;
    if constexpr (keeps_partials) {
      const T* const partials = arrays.partials + run.partial + i * variables;
      for_each_place<variables>([&](auto k) { pushed[k] = chain(adjoint, partials[k]); });
    } else {
      pushed = products<true>(run, arrays, i, adjoint);
      T sum = 0;
      for_each_place<variables>([&](auto k) { sum += pushed[k]; });
      if (sum != sum) [[unlikely]]
        pushed = careful_products(run, arrays, i, adjoint);
    }
    return pushed;
  }
  [[gnu::noinline, gnu::cold]] static Pushed careful_products(const ReplayRun<T>& run,
                                                              const ReplayArrays<T>& arrays, std::size_t i,
                                                              T adjoint) {
    return products<false>(run, arrays, i, adjoint);
  }
  template <bool IsPlain>
  [[gnu::always_inline]] static inline Pushed products(const ReplayRun<T>& run, const ReplayArrays<T>& arrays,
                                                       std::size_t i, T adjoint) {
    Operands operands = operands_of(run, arrays, i);
    PlacedSink<T, variables, IsPlain> sink{adjoint};
    Formula::read(operands).push(One{}, sink);
    return sink.pushed;
  }

  template <std::size_t First>
  [[gnu::always_inline]] static inline void add(const ReplayRun<T>& run, const ReplayArrays<T>& arrays,
                                                std::size_t i, const Pushed& pushed) {
    const std::uint32_t* const slots = arrays.operands + run.operand + i * variables;
    for_each_place<variables>([&](auto k) {
      if (k >= First) arrays.adjoints[slots[k]] += pushed[k];
    });
  }
};

/// How two numbers compare, as a number: −1, 0, 1, or 2 if one is not a number. Without branches, since the
/// outcome cannot be predicted.
struct ComparedAs {
  template <class T>
  static T value(T x, T y) {
    const int less = static_cast<int>(x < y), more = static_cast<int>(x > y);
    return static_cast<T>(more - less + 2 * (1 - less - more - static_cast<int>(x == y)));
  }
};

/// A comparison of two formulas; its recorded outcome stands behind their constants.
template <class X, class Y>
struct ReplayGuard {
  using T = typename X::ExpressionScalar;
  using Left = typename Placed<X>::type;
  using Right = typename Placed<Y, LeafCounts<X>::variables>::type;
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants + 1;

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    const std::uint32_t* slots = arrays.operands + run.operand;
    const T* constant = arrays.constants + run.constant;
    for (std::size_t i = 0; i < run.count; ++i, slots += variables, constant += constants) {
      ReplayOperands<T, variables> operands(arrays.values, slots, constant);
      const T x = Left::read(operands).value();
      const T y = Right::read(operands).value();
      if (ComparedAs::value(x, y) != operands.next_constant()) [[unlikely]]
        throw_otherwise(x, y);
    }
  }
  static void backward(const ReplayRun<T>&, const ReplayArrays<T>&) {}
  [[noreturn, gnu::noinline]] static void throw_otherwise(T x, T y) {
    char text[80];
    std::snprintf(text, sizeof text, "%.17g with %.17g", static_cast<double>(x), static_cast<double>(y));
    throw DomainError("Replay: the comparison of " + std::string(text) +
                      " comes out otherwise than when it was recorded; record again for these inputs");
  }

  static constexpr ReplayOperation<T> operation{
      .forward = forward,
      .backward = backward,
      .operand_count = variables,
      .constant_count = constants,
  };
};

}  // namespace detail
}  // namespace tapestry
