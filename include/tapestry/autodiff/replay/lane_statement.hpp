#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tapestry/autodiff/replay/lane_functions.hpp>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/replay/replay_statement.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/placed_formula.hpp>
#include <tapestry/core/instruction_set.hpp>
#include <utility>

namespace tapestry::detail {

// Like arrays/expression/block_loop.hpp: no warning where a statement's functions have no vectors.
#if defined(__clang__)
#pragma clang diagnostic push
#pragma clang diagnostic ignored "-Wpass-failed"
#endif

/// Calls body(lane) for each lane, in any order and side by side: a vector loop, unless a compiler unrolls it
/// first.
template <std::size_t Lanes, class Body>
[[gnu::always_inline]] inline void for_each_lane(const Body& body) {
#if defined(__clang__)
#pragma clang loop vectorize(assume_safety)
#elif defined(__GNUC__)
#pragma GCC ivdep
#pragma GCC unroll 1
#endif
  for (std::size_t lane = 0; lane < Lanes; ++lane) body(lane);
}

/// A statement's constants, the same for every lane.
template <class T, std::size_t Constants>
[[nodiscard, gnu::always_inline]] inline std::array<T, Constants> constants_of(const T* first) {
  std::array<T, Constants> constants{};
  for (std::size_t k = 0; k < Constants; ++k) constants[k] = first[k];
  return constants;
}

/// The sweeps of Statement in the best instructions of this processor.
template <class Statement>
class VectorLoops {
  using T = typename Statement::T;
  using Run = ReplayRun<T>;
  using Arrays = ReplayArrays<T>;
  using Sweep = void (*)(const Run&, const Arrays&);

 public:
  [[nodiscard]] static const ReplayOperation<T>* operation() {
    static constexpr ReplayOperation<T> portable = with(portable_forward, portable_backward);
#if defined(__x86_64__) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
    static constexpr ReplayOperation<T> avx2 = with(avx2_forward, avx2_backward);
    static constexpr ReplayOperation<T> avx512 = with(avx512_forward, avx512_backward);
    if (instruction_set() == InstructionSet::avx512) return &avx512;
    if (instruction_set() == InstructionSet::avx2) return &avx2;
#endif
    return &portable;
  }

 private:
  static constexpr ReplayOperation<T> with(Sweep forward, Sweep backward) {
    ReplayOperation<T> operation = Statement::description;
    operation.forward = forward;
    operation.backward = backward;
    return operation;
  }

  [[gnu::flatten]] static void portable_forward(const Run& run, const Arrays& arrays) {
    Statement::forward(run, arrays);
  }
  [[gnu::flatten]] static void portable_backward(const Run& run, const Arrays& arrays) {
    Statement::backward(run, arrays);
  }
#if defined(__x86_64__) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__)
  [[gnu::target("avx2"), gnu::flatten]] static void avx2_forward(const Run& run, const Arrays& arrays) {
    Statement::forward(run, arrays);
  }
  [[gnu::target("avx2"), gnu::flatten]] static void avx2_backward(const Run& run, const Arrays& arrays) {
    Statement::backward(run, arrays);
  }
#if defined(__clang__)  // AVX-512 has fused products, and clang no attribute against them
  static void avx512_forward(const Run& run, const Arrays& arrays) { avx2_forward(run, arrays); }
  static void avx512_backward(const Run& run, const Arrays& arrays) { avx2_backward(run, arrays); }
#else
  [[gnu::target("avx512f,avx512dq,avx512vl,avx2,prefer-vector-width=512"), gnu::optimize("fp-contract=off"),
    gnu::flatten]] static void
  avx512_forward(const Run& run, const Arrays& arrays) {
    Statement::forward(run, arrays);
  }
  [[gnu::target("avx512f,avx512dq,avx512vl,avx2,prefer-vector-width=512"), gnu::optimize("fp-contract=off"),
    gnu::flatten]] static void
  avx512_backward(const Run& run, const Arrays& arrays) {
    Statement::backward(run, arrays);
  }
#endif
#endif
};

/// Statements of expression type E for several inputs at once: value `lane` of slot i stands at i · lanes +
/// lane, and so do adjoints and partial derivatives. Formulas are computed a lane at a time, in loops that
/// compilers vectorise. Each lane has the bits of one alone, since no product is fused with a sum.
template <class E>
struct LaneStatement {
  using T = typename E::ExpressionScalar;
  using Formula = typename Placed<E>::type;
  static constexpr std::size_t lanes = LeafCounts<E>::lanes;
  static constexpr std::size_t variables = LeafCounts<E>::variables;
  static constexpr std::size_t constants = LeafCounts<E>::constants;
  static constexpr bool keeps_partials =
      ReplayStatement<E>::keeps_partials || (has_lane_function<E> && variables == 1 && pushes_all<E>());

  using Run = ReplayRun<T>;
  using Arrays = ReplayArrays<T>;

  /// Places of the operands of statement i.
  struct Places {
    std::array<const T*, variables> operands;
    std::array<T, constants> numbers;
    [[gnu::always_inline]] Places(const Run& run, const Arrays& arrays, std::size_t i)
        : numbers(constants_of<T, constants>(arrays.constants + run.constant + i * constants)) {
      const std::uint32_t* const slots = arrays.operands + run.operand + i * variables;
      for_each_place<variables>([&](auto k) { operands[k] = arrays.values + slots[k] * lanes; });
    }
    [[nodiscard, gnu::always_inline]] Formula formula(std::size_t lane) const {
      ReplayOperands<T, variables> leaves(numbers.data());
      for_each_place<variables>([&](auto k) { leaves.values[k] = operands[k][lane]; });
      return Formula::read(leaves);
    }
  };

  /// Partial derivatives of statement i; null where they are not kept.
  [[nodiscard, gnu::always_inline]] static inline T* partials_of(const Run& run, const Arrays& arrays,
                                                                 std::size_t i) {
    return keeps_partials ? arrays.partials + (run.partial + i * variables) * lanes : nullptr;
  }

  [[gnu::always_inline]] static inline void forward(const Run& run, const Arrays& arrays) {
    for (std::size_t i = 0, count = run.count; i < count; ++i) {
      const Places places(run, arrays, i);
      T* const results = arrays.values + (run.result + i) * lanes;
      T* const partials = partials_of(run, arrays, i);
      for_each_lane<lanes>([=](std::size_t lane) {
        const Formula formula = places.formula(lane);
        if constexpr (keeps_partials) {
          PlacedSink<T, variables, false> sink{T(1)};
          formula.push(T(1), sink);
          for_each_place<variables>([&](auto k) { partials[k * lanes + lane] = sink.pushed[k]; });
        }
        results[lane] = formula.value();
      });
    }
  }

  [[gnu::always_inline]] static inline void backward(const Run& run, const Arrays& arrays) {
    for (std::size_t i = run.count; i-- > 0;) {
      const Places places(run, arrays, i);
      const T* const partials = partials_of(run, arrays, i);
      T* const results = arrays.adjoints + (run.result + i) * lanes;
      std::array<std::array<T, lanes>, variables> pushed;
      auto* const out = pushed.data();
      for_each_lane<lanes>([=](std::size_t lane) {
        const T adjoint = results[lane];
        results[lane] = T(0);
        if constexpr (keeps_partials) {
          for_each_place<variables>(
              [&](auto k) { out[k][lane] = chain(adjoint, partials[k * lanes + lane]); });
        } else {
          PlacedSink<T, variables, true> sink{adjoint};
          places.formula(lane).push(One{}, sink);
          for_each_place<variables>([&](auto k) { out[k][lane] = sink.pushed[k]; });
        }
      });
      const std::uint32_t* const slots = arrays.operands + run.operand + i * variables;
      for_each_place<variables>([&](auto k) {
        T* const adjoints = arrays.adjoints + slots[k] * lanes;
        for_each_lane<lanes>([=](std::size_t lane) { adjoints[lane] += out[k][lane]; });
      });
    }
  }

  /// Passes on the gradients as one lane alone does, also where zeros meet infinite partial derivatives.
  static void backward_with_care(const Run& run, const Arrays& arrays) {
    if constexpr (keeps_partials) return backward(run, arrays);
    for (std::size_t i = run.count; i-- > 0;) {
      const Places places(run, arrays, i);
      const std::uint32_t* const slots = arrays.operands + run.operand + i * variables;
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        const T adjoint = std::exchange(arrays.adjoints[(run.result + i) * lanes + lane], T(0));
        PlacedSink<T, variables, true> plain{adjoint};
        places.formula(lane).push(One{}, plain);
        T sum = 0;
        for_each_place<variables>([&](auto k) { sum += plain.pushed[k]; });
        PlacedSink<T, variables, false> careful{adjoint};
        if (sum != sum) places.formula(lane).push(One{}, careful);
        for_each_place<variables>([&](auto k) {
          arrays.adjoints[slots[k] * lanes + lane] += sum != sum ? careful.pushed[k] : plain.pushed[k];
        });
      }
    }
  }

  static constexpr ReplayOperation<T> description{
      .backward_with_care = backward_with_care,
      .operand_count = variables,
      .constant_count = constants,
      .partial_count = keeps_partials ? variables : 0,
      .has_result = true,
      .is_cheap = is_cheap<E>() && !has_lane_function<E>,
      .reads_operands = !keeps_partials && counts_of_expression<E, One>().general != 0};
};

/// A comparison of two formulas for several inputs at once.
template <class X, class Y>
struct LaneGuard {
  using T = typename X::ExpressionScalar;
  using Guard = ReplayGuard<X, Y>;
  static constexpr std::size_t lanes = std::max(LeafCounts<X>::lanes, LeafCounts<Y>::lanes);

  [[gnu::always_inline]] static inline void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    for (std::size_t i = 0; i < run.count; ++i) {
      const std::uint32_t* const slots = arrays.operands + run.operand + i * Guard::variables;
      const auto constants =
          constants_of<T, Guard::constants>(arrays.constants + run.constant + i * Guard::constants);
      for_each_lane<lanes>([&](std::size_t lane) {
        ReplayOperands<T, Guard::variables> operands(constants.data());
        for_each_place<Guard::variables>(
            [&](auto k) { operands.values[k] = arrays.values[slots[k] * lanes + lane]; });
        const T x = Guard::Left::read(operands).value();
        const T y = Guard::Right::read(operands).value();
        arrays.refused[lane] |= ComparedAs::value(x, y) != operands.next_constant();
      });
    }
  }
  static void backward(const ReplayRun<T>&, const ReplayArrays<T>&) {}

  static constexpr ReplayOperation<T> description{
      .backward_with_care = backward, .operand_count = Guard::variables, .constant_count = Guard::constants};
};

#if defined(__clang__)
#pragma clang diagnostic pop
#endif

}  // namespace tapestry::detail
