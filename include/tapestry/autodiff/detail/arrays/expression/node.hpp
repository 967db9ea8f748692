#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/detail/arrays/expression/plan.hpp>
#include <tapestry/autodiff/variable.hpp>

namespace tapestry {
/// A view of some elements of an array variable: a slice, a transpose, a repetition. It has no memory and no
/// record of its own: formulas with it read the array, and add to the array's adjoint, in place. Made by the
/// functions of arrays/view.hpp.
template <class T, std::size_t Whole, std::size_t Rank>
class ArrayView {
 public:
  using ArrayScalar = T;
  static constexpr std::size_t rank = Rank;
  static constexpr std::size_t kept_count = 0;
  static constexpr bool may_be_active = true;

  ArrayView(ArrayVariable<T, Whole> whole, std::ptrdiff_t offset, const Extents<Rank>& extents,
            const detail::Strides<Rank>& strides)
      : whole_(std::move(whole)), offset_(offset), extents_(extents), strides_(strides) {}

  [[nodiscard]] const Extents<Rank>& shape() const { return extents_; }
  [[nodiscard]] const ArrayVariable<T, Whole>& whole() const { return whole_; }
  [[nodiscard]] std::ptrdiff_t offset() const { return offset_; }
  [[nodiscard]] const detail::Strides<Rank>& strides() const { return strides_; }
  [[nodiscard]] std::tuple<ArrayVariable<T, Whole>> leaves() const { return {whole_}; }

  /// The view's strides at these extents, where an axis of extent 1 may repeat.
  [[nodiscard]] detail::Strides<Rank> strides_in(const Extents<Rank>& extents) const {
    detail::Strides<Rank> strides = strides_;
    for (std::size_t axis = 0; axis < Rank; ++axis)
      if (extents_[axis] != extents[axis]) strides[axis] = 0;
    return strides;
  }
  [[nodiscard]] bool joins(std::size_t axis, const Extents<Rank>& extents) const {
    const auto strides = strides_in(extents);
    return strides[axis] == strides[axis + 1] * static_cast<std::ptrdiff_t>(extents[axis + 1]);
  }

 private:
  ArrayVariable<T, Whole> whole_;
  std::ptrdiff_t offset_;
  Extents<Rank> extents_;
  detail::Strides<Rank> strides_;
};

namespace detail {
/// A view that is known to be constant at compile time, so that it costs no pullback.
template <class T, std::size_t Whole, std::size_t Rank>
struct ConstantView : ArrayView<T, Whole, Rank> {
  static constexpr bool may_be_active = false;
  explicit ConstantView(const ArrayView<T, Whole, Rank>& view)
      : ArrayView<T, Whole, Rank>(passive(view.whole()), view.offset(), view.shape(), view.strides()) {}
  [[nodiscard]] std::tuple<> leaves() const { return {}; }
};

template <class T>
struct ScalarNode {
  using ArrayScalar = T;
  static constexpr std::size_t rank = 0;
  static constexpr std::size_t kept_count = 0;
  static constexpr bool may_be_active = true;
  Variable<T> variable;
  [[nodiscard]] std::tuple<Variable<T>> leaves() const { return {variable}; }
};

template <class T>
struct NumberNode {
  using ArrayScalar = T;
  static constexpr std::size_t rank = 0;
  static constexpr std::size_t kept_count = 0;
  static constexpr bool may_be_active = false;
  T value;
  [[nodiscard]] std::tuple<> leaves() const { return {}; }
};

/// Costly operations: their values are kept for the pullback.
template <class Operation>
inline constexpr bool is_costly = !requires {
  Operation::is_cheap;
};

/// Operations without a derivative, such as comparisons.
template <class Operation>
concept HasNoDerivative = requires {
  Operation::has_no_derivative;
};

/// Nodes without a shape, which go with arrays of any extents.
template <class X>
inline constexpr bool is_scalar_node = !requires(const X& x) {
  x.shape();
};

/// The extents of a node beside others of `extents`; nodes of no axes repeat along all of them.
template <class X, std::size_t Rank>
[[nodiscard]] Extents<Rank> extents_beside(const char* name, const Extents<Rank>& extents, const X& x,
                                           const char* argument) {
  if constexpr (is_scalar_node<X> || X::rank != Rank) {
    return extents;
  } else {
    return broadcast_extents(name, extents, x.shape(), argument);
  }
}

template <class X, std::size_t Rank>
[[nodiscard]] bool node_joins(const X& x, std::size_t axis, const Extents<Rank>& extents) {
  if constexpr (X::rank == 0) {
    return true;
  } else {
    return x.joins(axis, extents);
  }
}

/// f(x) element by element, for an Operation of functions/.
template <class Operation, class X>
class ArrayUnary {
 public:
  using ArrayScalar = typename X::ArrayScalar;
  static constexpr std::size_t rank = X::rank;
  static constexpr std::size_t kept_count = X::kept_count + (is_costly<Operation> ? 1 : 0);
  static constexpr bool may_be_active = X::may_be_active;

  ArrayUnary(const Operation& f, X operand) : operation(f), x(std::move(operand)) {}
  [[nodiscard]] const Extents<rank>& shape() const { return x.shape(); }
  [[nodiscard]] auto leaves() const { return x.leaves(); }
  [[nodiscard]] bool joins(std::size_t axis, const Extents<rank>& extents) const {
    return node_joins(x, axis, extents);
  }

  [[no_unique_address]] Operation operation;
  X x;
};

template <class Operation, class X, class Y>
class ArrayBinary {
 public:
  using ArrayScalar = typename X::ArrayScalar;
  static_assert(std::is_same_v<ArrayScalar, typename Y::ArrayScalar>,
                "arrays of float and double do not mix");
  static constexpr std::size_t rank = X::rank > Y::rank ? X::rank : Y::rank;
  static_assert(X::rank == 0 || Y::rank == 0 || X::rank == Y::rank, "arrays of different ranks do not mix");
  static constexpr std::size_t kept_count = X::kept_count + Y::kept_count + (is_costly<Operation> ? 1 : 0);
  static constexpr bool may_be_active = !HasNoDerivative<Operation> && (X::may_be_active || Y::may_be_active);

  ArrayBinary(const char* name, X left, Y right) : x(std::move(left)), y(std::move(right)) {
    if constexpr (is_scalar_node<X> || X::rank != rank) {
      extents_ = y.shape();
    } else {
      extents_ = extents_beside(name, x.shape(), y, "right operand");
    }
  }
  [[nodiscard]] const Extents<rank>& shape() const { return extents_; }
  [[nodiscard]] auto leaves() const { return std::tuple_cat(x.leaves(), y.leaves()); }
  [[nodiscard]] bool joins(std::size_t axis, const Extents<rank>& extents) const {
    return node_joins(x, axis, extents) && node_joins(y, axis, extents);
  }

  X x;
  Y y;

 private:
  Extents<rank> extents_;
};

/// x where the mask is not zero, y elsewhere. The mask has no derivative.
template <class M, class X, class Y>
class ArrayWhere {
 public:
  using ArrayScalar = typename M::ArrayScalar;
  static constexpr std::size_t rank = M::rank;
  static constexpr std::size_t kept_count = X::kept_count + Y::kept_count + M::kept_count;
  static constexpr bool may_be_active = X::may_be_active || Y::may_be_active;

  ArrayWhere(M condition, X first, Y second)
      : mask(std::move(condition)), x(std::move(first)), y(std::move(second)), extents_(mask.shape()) {
    extents_ = extents_beside("where", extents_, x, "the first branch");
    extents_ = extents_beside("where", extents_, y, "the second branch");
  }
  [[nodiscard]] const Extents<rank>& shape() const { return extents_; }
  [[nodiscard]] auto leaves() const { return std::tuple_cat(mask.leaves(), x.leaves(), y.leaves()); }
  [[nodiscard]] bool joins(std::size_t axis, const Extents<rank>& extents) const {
    return node_joins(mask, axis, extents) && node_joins(x, axis, extents) && node_joins(y, axis, extents);
  }

  M mask;
  X x;
  Y y;

 private:
  Extents<rank> extents_;
};

template <class X>
inline constexpr std::size_t leaf_count = std::tuple_size_v<decltype(std::declval<const X&>().leaves())>;

/// A node whose values are kept, or computed in a separate loop.
template <class X>
inline constexpr bool is_costly_node = false;
template <class Operation, class X>
inline constexpr bool is_costly_node<ArrayUnary<Operation, X>> = is_costly<Operation>;
template <class Operation, class X, class Y>
inline constexpr bool is_costly_node<ArrayBinary<Operation, X, Y>> = is_costly<Operation>;

template <class T, std::size_t Rank>
[[nodiscard]] ArrayView<T, Rank, Rank> whole_view(ArrayVariable<T, Rank> x) {
  const Extents<Rank> extents = x.shape();
  return {std::move(x), 0, extents, row_major_strides(extents)};
}
}  // namespace detail
}  // namespace tapestry
