#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/autodiff/expression.hpp>
#include <tapestry/autodiff/replay_program.hpp>
#include <tapestry/core/error.hpp>
#include <utility>

namespace tapestry {

template <std::floating_point T>
class Replayable;

namespace detail {
template <class Operation, class X, class Y, class Z>
class Ternary;  // of functions/ternary.hpp

/// Makes a formula from the slots of a frame.
template <class T>
struct ReplayedLeaves {
  const T* values;
  const std::uint32_t* operand;
  const T* constant;
  const T* first = nullptr;  ///< the value of the first variable, if it is at hand
  [[nodiscard]] T next_constant() { return *constant++; }
  [[nodiscard]] Replayable<T> next_variable() {
    const std::uint32_t slot = *operand++;
    const T* const value = first == nullptr ? values + slot : std::exchange(first, nullptr);
    return {*value, Link(slot, 0)};
  }
};

template <class T>
struct PartialsSink {
  T* partial;
  template <class Factor>
  void add(Link, Factor factor) {
    *partial++ = as_number<T>(factor);
  }
};

template <class T>
struct AdjointsSink {
  T* adjoints;
  T adjoint;
  T* first = nullptr;  ///< the adjoint of the first variable, if it is at hand
  void add(Link link, One) { next(link) += adjoint; }
  void add(Link link, MinusOne) { next(link) -= adjoint; }
  void add(Link link, T partial) { next(link) += chain(adjoint, partial); }

 private:
  T& next(Link link) { return first == nullptr ? adjoints[link.index()] : *std::exchange(first, nullptr); }
};

template <class E>
struct LeafCounts;
template <class T>
struct LeafCounts<Replayable<T>> {
  static constexpr std::size_t variables = 1, constants = 0;
};
template <class T>
struct LeafCounts<Constant<T>> {
  static constexpr std::size_t variables = 0, constants = 1;
};
template <class Operation, class X>
struct LeafCounts<Unary<Operation, X>> : LeafCounts<X> {};
template <class Operation, class X, class Y>
struct LeafCounts<Binary<Operation, X, Y>> {
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants;
};
template <class Operation, class X, class Y, class Z>
struct LeafCounts<Ternary<Operation, X, Y, Z>> {
  static constexpr std::size_t variables =
      LeafCounts<Binary<Operation, X, Y>>::variables + LeafCounts<Z>::variables;
  static constexpr std::size_t constants =
      LeafCounts<Binary<Operation, X, Y>>::constants + LeafCounts<Z>::constants;
};

/// Whether E has the form x ∘ y of a variable and something else, as in x = x ∘ y.
template <class E>
inline constexpr bool is_update = false;
template <class Operation, std::floating_point T, class Y>
inline constexpr bool is_update<Binary<Operation, Replayable<T>, Y>> = true;

/// Statements of expression type E. Those with costly functions keep their partial derivatives from the way
/// forwards; others compute them again, which needs no memory.
template <class E>
struct ReplayStatement {
  using T = typename E::ExpressionScalar;
  static constexpr std::size_t variables = LeafCounts<E>::variables;
  static constexpr std::size_t constants = LeafCounts<E>::constants;
  static constexpr bool keeps_partials = !is_cheap<E>() && pushes_all<E>();
  static constexpr bool can_chain = is_update<E> && pushes_all<E>();

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    ReplayedLeaves<T> leaves{arrays.values, arrays.operands + run.operand, arrays.constants + run.constant};
    T* const values = arrays.values + run.result;
    PartialsSink<T> partials{arrays.partials + run.partial};
    const auto compute = [&](std::size_t i) {
      const E formula = E::read(leaves);
      if constexpr (keeps_partials) formula.push(T(1), partials);
      return values[i] = formula.value();
    };
    if constexpr (can_chain)
      if (run.is_chain) {
        T last = values[-1];
        for (std::size_t i = 0, count = run.count; i < count; ++i) {
          leaves.first = &last;
          last = compute(i);
        }
        return;
      }
    for (std::size_t i = 0, count = run.count; i < count; ++i) compute(i);
  }

  static void backward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    T* const results = arrays.adjoints + run.result;
    if constexpr (can_chain)
      if (run.is_chain) {
        T adjoint = results[run.count - 1];
        for (std::size_t i = run.count; i-- > 0;) {
          T before = results[static_cast<std::ptrdiff_t>(i) - 1];
          results[i] = T(0);
          pull(run, arrays, i, AdjointsSink<T>{arrays.adjoints, adjoint, &before});
          adjoint = before;
        }
        results[-1] = adjoint;
        return;
      }
    for (std::size_t i = run.count; i-- > 0;) {
      const T adjoint = std::exchange(results[i], T(0));
      pull(run, arrays, i, AdjointsSink<T>{arrays.adjoints, adjoint});
    }
  }

  [[gnu::always_inline]] static inline void pull(const ReplayRun<T>& run, const ReplayArrays<T>& arrays,
                                                 std::size_t i, AdjointsSink<T> sink) {
    const std::uint32_t* const operands = arrays.operands + run.operand + i * variables;
    if constexpr (keeps_partials) {
      const T* const partials = arrays.partials + run.partial + i * variables;
      for (std::size_t k = 0; k < variables; ++k) sink.add(Link(operands[k], 0), partials[k]);
    } else {
      ReplayedLeaves<T> leaves{arrays.values, operands, arrays.constants + run.constant + i * constants};
      E::read(leaves).push(One{}, sink);
    }
  }

  static constexpr ReplayOperation<T> operation{
      forward, backward, variables, constants, keeps_partials ? variables : 0, true, can_chain};
};

/// How two numbers compare, as a number: −1, 0, 1, or 2 if one is not a number. Without branches, since
/// nobody can tell how they come out.
struct ComparedAs {
  template <class T>
  static T value(T x, T y) {
    const int less = static_cast<int>(x < y), more = static_cast<int>(x > y);
    return static_cast<T>(more - less + 2 * (1 - less - more - static_cast<int>(x == y)));
  }
};

/// A comparison of two formulas, behind whose constants stands how it came out.
template <class X, class Y>
struct ReplayGuard {
  using T = typename X::ExpressionScalar;
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants + 1;

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    ReplayedLeaves<T> leaves{arrays.values, arrays.operands + run.operand, arrays.constants + run.constant};
    for (std::size_t i = 0; i < run.count; ++i) {
      const T x = X::read(leaves).value();
      const T y = Y::read(leaves).value();
      if (ComparedAs::value(x, y) != leaves.next_constant()) [[unlikely]]
        throw_otherwise(x, y);
    }
  }
  static void backward(const ReplayRun<T>&, const ReplayArrays<T>&) {}
  [[noreturn]] static void throw_otherwise(T x, T y) {
    throw DomainError("Replay: the comparison of " + std::to_string(x) + " with " + std::to_string(y) +
                      " comes out otherwise than when it was recorded; record again for these inputs");
  }

  static constexpr ReplayOperation<T> operation{forward, backward, variables, constants, 0, false, false};
};

}  // namespace detail
}  // namespace tapestry
