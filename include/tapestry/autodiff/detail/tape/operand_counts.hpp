#pragma once
#include <tapestry/autodiff/detail/tape/scalar.hpp>
#include <tapestry/autodiff/detail/tape/statement.hpp>
#include <utility>

namespace tapestry::detail {
/// Partial derivatives known to the compiler: a statement keeps no number for them. An operation whose
/// partial derivative is always 1 or −1 declares a type Slope, or SlopeX and SlopeY.
struct One {};
struct MinusOne {};

template <class T, class Factor>
[[nodiscard]] constexpr T as_number(const Factor& factor) {
  if constexpr (std::is_same_v<Factor, One>) {
    return T(1);
  } else if constexpr (std::is_same_v<Factor, MinusOne>) {
    return T(-1);
  } else {
    return factor;
  }
}

/// chain(factor, partial), without a product where either is One or MinusOne.
template <class Factor, class Partial>
[[nodiscard]] constexpr auto chain_slopes(const Factor& factor, const Partial& partial) {
  if constexpr (std::is_same_v<Factor, One>) {
    return partial;
  } else if constexpr (std::is_same_v<Partial, One>) {
    return factor;
  } else if constexpr (std::is_same_v<Factor, MinusOne> && std::is_same_v<Partial, MinusOne>) {
    return One{};
  } else if constexpr (std::is_same_v<Factor, MinusOne>) {
    return -partial;
  } else if constexpr (std::is_same_v<Partial, MinusOne>) {
    return -factor;
  } else if constexpr (std::floating_point<Partial>) {
    return chain_in_sum(factor, partial);
  } else {
    return chain(factor, partial);
  }
}

template <class Factor, class Slope>
using Chained = std::remove_cvref_t<decltype(chain_slopes(std::declval<Factor>(), std::declval<Slope>()))>;

/// The types of an operation's partial derivatives: numbers, unless it declares others.
template <class Operation, class T>
struct SlopeOf {
  using type = T;
};
template <class Operation, class T>
requires requires { typename Operation::Slope; }
struct SlopeOf<Operation, T> {
  using type = typename Operation::Slope;
};
template <class Operation, class T>
struct SlopesOf {
  using X = T;
  using Y = T;
};
template <class Operation, class T>
requires requires { typename Operation::SlopeX; }
struct SlopesOf<Operation, T> {
  using X = typename Operation::SlopeX;
  using Y = typename Operation::SlopeY;
};

/// An expression that counts how many operands of each sort it pushes under a factor of a given type, and
/// whether its variables are of one generation. Any other is pushed with numbers, and recorded with more
/// care.
template <class E>
concept CountsOperands = requires {
  E::template operand_counts<One>;
};

/// The operands that E pushes under a factor of type Factor.
template <class E, class Factor>
[[nodiscard]] constexpr OperandCounts counts_of_expression() {
  if constexpr (CountsOperands<E>) {
    return E::template operand_counts<Factor>;
  } else {
    return {0, 0, E::operand_bound};
  }
}

/// Whether E always pushes exactly these operands, whatever its values.
template <class E>
[[nodiscard]] constexpr bool pushes_all() {
  if constexpr (CountsOperands<E>) {
    return E::always_pushes_all;
  } else {
    return false;
  }
}

/// Below 2³² if all variables of E are of the link's generation; never below for an E without that count.
template <class E>
[[nodiscard]] constexpr std::uint64_t difference(const E& expression, Link link) {
  if constexpr (CountsOperands<E>) {
    return expression.difference(link);
  } else {
    return ~std::uint64_t(0);
  }
}

template <class E, class Factor, class Sink>
[[gnu::always_inline]] constexpr void push_factor(const E& expression, const Factor& factor, Sink& sink) {
  if constexpr (CountsOperands<E>) {
    expression.push(factor, sink);
  } else {
    expression.push(as_number<typename E::ExpressionScalar>(factor), sink);
  }
}
}  // namespace tapestry::detail
