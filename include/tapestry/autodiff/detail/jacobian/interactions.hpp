#pragma once
#include <tapestry/autodiff/detail/jacobian/jacobian_pattern.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <unordered_set>

namespace tapestry {
namespace detail {
/// Records which variables meet in an operation that is not linear. The origin of a number is a node: a
/// variable, or two nodes. Its variables are looked up only where it meets another number: the sum over a
/// long problem never does, so that its many terms cost nothing.
class Interactions {
 public:
  using Node = std::uint32_t;  ///< 0 for a constant

  [[nodiscard]] Node variable() {
    const auto member = static_cast<Node>(variables_++);
    return made({0, 0, sets_.single(member)});
  }

  [[nodiscard]] Node both(Node a, Node b) {
    if (a == 0 || a == b) return b;
    return b == 0 ? a : made({a, b, 0});
  }

  void meet(Node a, Node b) {
    if (a == 0 || b == 0) return;
    const IndexSets::Name of_a = variables_of(a), of_b = variables_of(b);
    met_.insert(std::uint64_t(of_a < of_b ? of_a : of_b) << 32U | (of_a < of_b ? of_b : of_a));
  }

  /// All pairs that met, in both triangles.
  [[nodiscard]] JacobianPattern pattern() {
    PendingSets neighbours(variables_);
    for (const std::uint64_t pair : met_) {
      const auto a = static_cast<IndexSets::Name>(pair >> 32U), b = static_cast<IndexSets::Name>(pair);
      for (const auto i : sets_.members(a)) neighbours.add(i, b);
      for (const auto i : sets_.members(b)) neighbours.add(i, a);
    }
    std::vector<JacobianPattern::Entry> entries;
    for (std::size_t i = 0; i < variables_; ++i)
      for (const auto j : sets_.members(neighbours.take(i, sets_))) entries.push_back({i, j});
    return {variables_, variables_, std::move(entries)};
  }

 private:
  struct Part {
    Node a, b;
    IndexSets::Name variables;  ///< 0 until they are looked up
    Node last_search = 0;       ///< last node whose search reached this one
  };

  [[nodiscard]] Node made(const Part& part) {
    parts_.push_back(part);
    return static_cast<Node>(parts_.size() - 1);
  }

  [[nodiscard]] IndexSets::Name variables_of(Node node) {
    if (parts_[node].variables != 0) return parts_[node].variables;
    std::vector<IndexSets::Name> found;
    std::vector<Node> open{node};
    while (!open.empty()) {
      Part& part = parts_[open.back()];
      open.pop_back();
      if (std::exchange(part.last_search, node) == node) continue;
      if (part.variables != 0) {
        found.push_back(part.variables);
      } else {
        open.push_back(part.a);
        open.push_back(part.b);
      }
    }
    return parts_[node].variables = sets_.join(found);
  }

  std::vector<Part> parts_ = std::vector<Part>(1);
  IndexSets sets_;
  std::unordered_set<std::uint64_t> met_;  // pairs of sets
  std::size_t variables_ = 0;
};

struct InteractionTag {};

template <class T>
using Interacting = Dual<T, 1, InteractionTag>;

template <class D>
inline constexpr bool is_interacting = false;
template <class T>
inline constexpr bool is_interacting<Interacting<T>> = true;
template <class T>
inline constexpr bool takes_partials<Interacting<T>> = false;

template <class Operation, class... Others>
inline constexpr bool is_any_of = (std::is_same_v<Operation, Others> || ...);
/// A linear operation, perhaps with other factors on either side of a kink or a jump.
template <class Operation>
inline constexpr bool is_linear = is_any_of<Operation, Plus, Minus, Negate, Abs, AtLeast, AtMost, Max, Min,
                                            Fmax, Fmin, Fdim, Fmod, Remainder, Copysign>;

template <class T>
[[nodiscard]] Interacting<T> joined(const T& value, const Interacting<T>& x, const Interacting<T>& y) {
  Interactions* const all = x.all() != nullptr ? x.all() : y.all();
  return {value, all, all == nullptr ? 0 : all->both(x.node(), y.node())};
}
template <class T>
void meet(const Interacting<T>& x, const Interacting<T>& y) {
  if (x.all() != nullptr) x.all()->meet(x.node(), y.node());
}

// Hooks that functions of duals call, for numbers that interact.

template <class Operation, std::floating_point T>
[[nodiscard]] Interacting<T> dual_of(const Interacting<T>& x, const T& value, const T&) {
  meet(x, x);
  return {value, x};
}

template <class Operation, std::floating_point T>
[[nodiscard]] Interacting<T> dual_unary(const Interacting<T>& x) {
  if (!is_linear<Operation>) meet(x, x);
  return {Operation::value(x.value()), x};
}

template <class Operation, class D, class X, class Y>
requires is_interacting<D>
[[nodiscard]] D dual_binary(const X& x, const Y& y) {
  const D a(x), b(y);
  if (!is_linear<Operation>) meet(a, b);
  if (!is_linear<Operation> && !is_any_of<Operation, Times>) {
    if (!is_any_of<Operation, Divide>) meet(a, a);
    meet(b, b);
  }
  return joined(Operation::value(a.value(), b.value()), a, b);
}

template <class Operation, class D>
requires is_interacting<D>
[[nodiscard]] D dual_ternary(const D& x, const D& y, const D& z) {
  const auto value = Operation::value(x.value(), y.value(), z.value());
  const D both = joined(value, x, y), all = joined(value, both, z);
  if constexpr (is_any_of<Operation, FusedMultiplyAdd>) {
    meet(x, y);
  } else if constexpr (is_any_of<Operation, Lerp>) {
    meet(both, z);
  } else {
    meet(all, all);
  }
  return all;
}

/// For derivatives that are taken inside the function.
template <std::floating_point T>
[[nodiscard]] Interacting<T> chain(const Interacting<T>& factor, const Interacting<T>& partial) {
  return factor * partial;
}
}  // namespace detail

/// A number that records which of its variables meet in a nonlinear operation; hessian_pattern() calls a
/// function with such numbers. It works wherever a Dual does.
template <std::floating_point T>
class Dual<T, 1, detail::InteractionTag> {
 public:
  using value_type = T;
  static constexpr std::size_t direction_count = 1;

  constexpr Dual() = default;
  /// A constant.
  template <std::convertible_to<T> X>
  requires(!std::same_as<X, Dual>) constexpr Dual(const X& value) : value_(static_cast<T>(value)) {}
  constexpr Dual(T value, detail::Interactions* all, detail::Interactions::Node node)
      : value_(value), all_(all), node_(node) {}
  /// A value with the origin of another number.
  constexpr Dual(T value, const Dual& from) : Dual(value, from.all_, from.node_) {}

  [[nodiscard]] constexpr const T& value() const { return value_; }
  /// The number itself, which is all that it carries.
  [[nodiscard]] constexpr const Dual& tangents() const { return *this; }
  [[nodiscard]] constexpr bool is_zero() const { return value_ == T(0) && node_ == 0; }
  /// Collector of the meetings; null for a constant.
  [[nodiscard]] constexpr detail::Interactions* all() const { return all_; }
  [[nodiscard]] constexpr detail::Interactions::Node node() const { return node_; }

  Dual& operator+=(const Dual& y) { return *this = *this + y; }
  Dual& operator-=(const Dual& y) { return *this = *this - y; }
  Dual& operator*=(const Dual& y) { return *this = *this * y; }
  Dual& operator/=(const Dual& y) { return *this = *this / y; }
  friend constexpr void swap(Dual& x, Dual& y) noexcept { std::swap(x, y); }

 private:
  T value_ = T(0);
  detail::Interactions* all_ = nullptr;
  detail::Interactions::Node node_ = 0;
};
}  // namespace tapestry
