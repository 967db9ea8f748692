#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/operand_counts.hpp>
#include <tapestry/autodiff/tape/scalar.hpp>
#include <type_traits>

namespace tapestry {

template <std::floating_point T, std::size_t Lanes = 1>
class Replayable;

namespace detail {
template <class Operation, class X, class Y, class Z>
class Ternary;  // of functions/ternary.hpp

/// Numbers of variables and constants of a formula of Replayables, and of its lanes.
template <class E>
struct LeafCounts;
template <class T, std::size_t Lanes>
struct LeafCounts<Replayable<T, Lanes>> {
  static constexpr std::size_t variables = 1, constants = 0, lanes = Lanes;
};
template <class T>
struct LeafCounts<ConstantLeaf<T>> {
  static constexpr std::size_t variables = 0, constants = 1, lanes = 0;
};
template <class Operation, class X>
struct LeafCounts<Unary<Operation, X>> : LeafCounts<X> {};
template <class Operation, class X, class Y>
struct LeafCounts<Binary<Operation, X, Y>> {
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants;
  static constexpr std::size_t lanes =
      LeafCounts<X>::lanes > LeafCounts<Y>::lanes ? LeafCounts<X>::lanes : LeafCounts<Y>::lanes;
};
template <class Operation, class X, class Y, class Z>
struct LeafCounts<Ternary<Operation, X, Y, Z>> : LeafCounts<Binary<Operation, Binary<Operation, X, Y>, Z>> {};

/// The form of an operation for several lanes: itself, or that of replay/lane_functions.hpp.
template <class Operation>
struct InLanes {
  using type = Operation;
};

/// The operation for lanes in place of `Operation` in a formula of Xs; formulas of long double keep it.
template <class Operation, class... Xs>
[[nodiscard]] constexpr auto operation_of() {
  if constexpr ((observes_comparisons<Xs>() || ...)) {
    constexpr bool is_long = (std::same_as<typename Xs::ExpressionScalar, long double> || ...);
    using Form = typename InLanes<Operation>::type;
    return std::conditional_t<(((LeafCounts<Xs>::lanes > 1) || ...) && !is_long), Form, Operation>();
  } else {
    return Operation();
  }
}
template <class Operation, class... Xs>
using OperationOf = decltype(operation_of<Operation, Xs...>());

/// Variable Place of a formula.
template <class T, std::size_t Place>
class PlacedVariable {
 public:
  using ExpressionScalar = T;
  static constexpr std::size_t operand_bound = 1;
  static constexpr bool is_cheap = true;
  template <class Factor>
  static constexpr OperandCounts operand_counts = Replayable<T, 1>::template operand_counts<Factor>;
  static constexpr bool always_pushes_all = true;

  explicit PlacedVariable(T value) : value_(value) {}
  [[nodiscard]] T value() const { return value_; }
  template <class Factor, class Sink>
  [[gnu::always_inline]] void push(Factor factor, Sink& sink) const {
    sink.template add<Place>(factor);
  }
  template <class Leaves>
  [[nodiscard, gnu::always_inline]] static PlacedVariable read(Leaves& leaves) {
    return PlacedVariable(leaves.template variable<Place>());
  }

 private:
  T value_;
};

/// The formula E with its variables numbered from Place on, so that a loop over it works on numbers alone.
template <class E, std::size_t Place = 0>
struct Placed;
template <class T, std::size_t Lanes, std::size_t Place>
struct Placed<Replayable<T, Lanes>, Place> {
  using type = PlacedVariable<T, Place>;
};
template <class T, std::size_t Place>
struct Placed<ConstantLeaf<T>, Place> {
  using type = ConstantLeaf<T>;
};
template <class Operation, class X, std::size_t Place>
struct Placed<Unary<Operation, X>, Place> {
  using type = Unary<Operation, typename Placed<X, Place>::type>;
};
template <class Operation, class X, class Y, std::size_t Place>
struct Placed<Binary<Operation, X, Y>, Place> {
  using type = Binary<Operation, typename Placed<X, Place>::type,
                      typename Placed<Y, Place + LeafCounts<X>::variables>::type>;
};
template <class Operation, class X, class Y, class Z, std::size_t Place>
struct Placed<Ternary<Operation, X, Y, Z>, Place> {
  static constexpr std::size_t y = Place + LeafCounts<X>::variables;
  using type = Ternary<Operation, typename Placed<X, Place>::type, typename Placed<Y, y>::type,
                       typename Placed<Z, y + LeafCounts<Y>::variables>::type>;
};

/// Sink of products: pushed[i] is the sum for variable i of a placed formula, times `adjoint`.
template <class T, std::size_t Variables, bool IsPlain>
struct PlacedSink {
  static constexpr bool takes_plain_products = IsPlain;
  T adjoint;
  std::array<T, Variables> pushed{};
  template <std::size_t Place, class Factor>
  [[gnu::always_inline]] void add(Factor factor) {
    if constexpr (IsPlain) {
      pushed[Place] = chain_slopes(adjoint, factor, PlainProduct());
    } else {
      pushed[Place] = chain_slopes(adjoint, factor, ChainedProduct());
    }
  }
};

}  // namespace detail
}  // namespace tapestry
