#pragma once
#include <tapestry/autodiff/detail/arrays/expression/cursor.hpp>

namespace tapestry::detail {
/// Gradient of one side of an operation; those whose partials are 0 or ±1 define pass_x(), without a product.
template <class Operation, class T>
[[nodiscard, gnu::always_inline]] inline T pass_x_of(T g, T x, T y, T value) {
  if constexpr (requires { Operation::pass_x(g, x, y); }) {
    return Operation::pass_x(g, x, y);
  } else {
    return chain(g, Operation::partial_x(x, y, value));
  }
}
template <class Operation, class T>
[[nodiscard, gnu::always_inline]] inline T pass_y_of(T g, T x, T y, T value) {
  if constexpr (requires { Operation::pass_y(g, x, y); }) {
    return Operation::pass_y(g, x, y);
  } else {
    return chain(g, Operation::partial_y(x, y, value));
  }
}

/// Whether the slope of an operation on T is slope_of(), for partial() would cancel in duals.
template <class Operation, class T>
inline constexpr bool has_curvature = false;
template <class Operation, DualNumber T>
inline constexpr bool has_curvature<Operation, T> = requires(typename T::value_type x) {
  Operation::curvature(x, x, x);
};

/// Slope of an operation, which may have settings, given x and its value there.
template <class Operation, class T>
[[nodiscard, gnu::always_inline]] inline T slope_by(const Operation& operation, const T& x, const T& value) {
  if constexpr (has_curvature<Operation, T>) {
    return slope_of<Operation>(x, value);
  } else {
    return T(operation.partial(x, value));
  }
}

template <class Operation, class XReader, class T, bool x_may_be_active>
struct UnaryReader {
  [[no_unique_address]] Operation operation;
  XReader x;

  struct Value {
    typename XReader::Value of_x;
    T value;
    [[gnu::always_inline]] Value(const UnaryReader& reader, std::size_t i)
        : of_x(reader.x, i), value(reader.operation.value(of_x.value)) {}
    /// The same for a value that is already known.
    [[gnu::always_inline]] Value(const UnaryReader& reader, std::size_t i, T known)
        : of_x(reader.x, i), value(known) {}
  };
  [[gnu::always_inline]] void push(const Value& v, std::size_t i, T g) const {
    if constexpr (x_may_be_active)
      x.push(v.of_x, i, chain(g, slope_by<Operation, T>(operation, v.of_x.value, v.value)));
  }
};

template <class Operation, class XReader, class YReader, class T, bool x_may_be_active, bool y_may_be_active>
struct BinaryReader {
  XReader x;
  YReader y;

  struct Value {
    typename XReader::Value of_x;
    typename YReader::Value of_y;
    T value;
    [[gnu::always_inline]] Value(const BinaryReader& reader, std::size_t i)
        : of_x(reader.x, i), of_y(reader.y, i), value(Operation::value(of_x.value, of_y.value)) {}
    [[gnu::always_inline]] Value(const BinaryReader& reader, std::size_t i, T known)
        : of_x(reader.x, i), of_y(reader.y, i), value(known) {}
  };
  [[gnu::always_inline]] void push(const Value& v, std::size_t i, T g) const {
    if constexpr (x_may_be_active)
      x.push(v.of_x, i, pass_x_of<Operation, T>(g, v.of_x.value, v.of_y.value, v.value));
    if constexpr (y_may_be_active)
      y.push(v.of_y, i, pass_y_of<Operation, T>(g, v.of_x.value, v.of_y.value, v.value));
  }
};

template <class MReader, class XReader, class YReader, class T, bool x_may_be_active, bool y_may_be_active>
struct WhereReader {
  MReader mask;
  XReader x;
  YReader y;

  struct Value {
    typename XReader::Value of_x;
    typename YReader::Value of_y;
    bool takes_x;
    T value;
    [[gnu::always_inline]] Value(const WhereReader& reader, std::size_t i)
        : of_x(reader.x, i),
          of_y(reader.y, i),
          takes_x(typename MReader::Value(reader.mask, i).value != T(0)),
          value(takes_x ? of_x.value : of_y.value) {}
  };
  [[gnu::always_inline]] void push(const Value& v, std::size_t i, T g) const {
    if constexpr (x_may_be_active) x.push(v.of_x, i, v.takes_x ? g : T(0));
    if constexpr (y_may_be_active) y.push(v.of_y, i, v.takes_x ? T(0) : g);
  }
};

/// The bodies of loops over a block: they must be inlined into the loop, or it is not vectorised.
template <class Reader, class T>
struct StoreValue {
  Reader reader;
  T* to;
  [[gnu::always_inline]] void operator()(std::size_t i) const {
    to[i] = typename Reader::Value(reader, i).value;
  }
};
template <class Reader, class T>
struct PushAdjoint {
  Reader reader;
  const T* adjoints;
  [[gnu::always_inline]] void operator()(std::size_t i) const {
    reader.push(typename Reader::Value(reader, i), i, adjoints[i]);
  }
};
template <class Reader, class T>
struct PushAdjointOfKnown {
  Reader reader;
  const T* adjoints;
  const T* values;
  [[gnu::always_inline]] void operator()(std::size_t i) const {
    reader.push(typename Reader::Value(reader, i, values[i]), i, adjoints[i]);
  }
};

template <class Node>
using ReaderOf = decltype(std::declval<Cursor<Node>&>().reader());

/// A cheap operation, computed again wherever it is read; its reader consists of its operands' readers.
template <class Node>
class InnerCursor;

template <class Operation, class X>
class InnerCursor<ArrayUnary<Operation, X>> {
 public:
  template <std::size_t L, std::size_t K, class P>
  InnerCursor(Standing<L, K>, const ArrayUnary<Operation, X>& node, const P& pass)
      : operation_(node.operation), x_(Standing<L, K>{}, node.x, pass) {}
  void seek(const auto& index) { x_.seek(index); }
  void forward(std::size_t position, std::size_t first, std::size_t count) {
    x_.forward(position, first, count);
  }
  void backward(std::size_t first, std::size_t count) { x_.backward(first, count); }
  [[nodiscard]] auto reader() {
    return UnaryReader<Operation, ReaderOf<X>, typename X::ArrayScalar, X::may_be_active>{operation_,
                                                                                          x_.reader()};
  }

 private:
  Operation operation_;
  Cursor<X> x_;
};

template <class Operation, class X, class Y>
class InnerCursor<ArrayBinary<Operation, X, Y>> {
 public:
  template <std::size_t L, std::size_t K, class P>
  InnerCursor(Standing<L, K>, const ArrayBinary<Operation, X, Y>& node, const P& pass)
      : x_(Standing<L, K>{}, node.x, pass),
        y_(Standing<L + leaf_count<X>, K + X::kept_count>{}, node.y, pass) {}
  void seek(const auto& index) {
    x_.seek(index);
    y_.seek(index);
  }
  void forward(std::size_t position, std::size_t first, std::size_t count) {
    x_.forward(position, first, count);
    y_.forward(position, first, count);
  }
  void backward(std::size_t first, std::size_t count) {
    if constexpr (HasNoDerivative<Operation>) return;
    if constexpr (X::may_be_active) x_.backward(first, count);
    if constexpr (Y::may_be_active) y_.backward(first, count);
  }
  [[nodiscard]] auto reader() {
    constexpr bool of_x = !HasNoDerivative<Operation> && X::may_be_active;
    constexpr bool of_y = !HasNoDerivative<Operation> && Y::may_be_active;
    using T = typename X::ArrayScalar;
    return BinaryReader<Operation, ReaderOf<X>, ReaderOf<Y>, T, of_x, of_y>{x_.reader(), y_.reader()};
  }

 private:
  Cursor<X> x_;
  Cursor<Y> y_;
};

/// A costly operation: its values are computed in a loop of their own, into a block or where they are kept
/// for the backward pass, and read from there.
template <class Node>
class CostlyCursor {
  using T = typename Node::ArrayScalar;

 public:
  template <std::size_t L, std::size_t K, class P>
  CostlyCursor(Standing<L, K>, const Node& node, const P& pass)
      : inner_(Standing<L, K + 1>{}, node, pass), is_kept_(pass.goes_back) {
    T* const all = K == 0 && pass.root != nullptr ? pass.root : pass.kept;
    if (all != nullptr) kept_ = all + (K == 0 || pass.root == nullptr ? K : K - 1) * pass.plan.size;
  }
  void seek(const auto& index) { inner_.seek(index); }
  void forward(std::size_t position, std::size_t first, std::size_t count) {
    inner_.forward(position, first, count);
    values_ = kept_ == nullptr ? own_ : kept_ + position;
    if (is_kept_ && kept_ != nullptr) return;
    using Reader = decltype(inner_.reader());
    portable_block(count, StoreValue<Reader, T>{inner_.reader(), values_});  // calls functions of <cmath>
  }
  void backward(std::size_t first, std::size_t count) {
    using Reader = decltype(inner_.reader());
    for_block(count, PushAdjointOfKnown<Reader, T>{inner_.reader(), back_, values_});
    inner_.backward(first, count);
  }
  [[nodiscard]] BlockReader<T> reader() { return {values_, back_}; }

 private:
  InnerCursor<Node> inner_;
  bool is_kept_;
  T* kept_ = nullptr;
  T* values_ = nullptr;
  alignas(64) T own_[array_block];
  alignas(64) T back_[array_block];
};

template <class Node>
using OperationCursor = std::conditional_t<is_costly_node<Node>, CostlyCursor<Node>, InnerCursor<Node>>;

template <class Operation, class X>
class Cursor<ArrayUnary<Operation, X>> : public OperationCursor<ArrayUnary<Operation, X>> {
 public:
  template <class S, class P>
  Cursor(S standing, const ArrayUnary<Operation, X>& node, const P& pass)
      : OperationCursor<ArrayUnary<Operation, X>>(standing, node, pass) {}
};
template <class Operation, class X, class Y>
class Cursor<ArrayBinary<Operation, X, Y>> : public OperationCursor<ArrayBinary<Operation, X, Y>> {
 public:
  template <class S, class P>
  Cursor(S standing, const ArrayBinary<Operation, X, Y>& node, const P& pass)
      : OperationCursor<ArrayBinary<Operation, X, Y>>(standing, node, pass) {}
};

template <class M, class X, class Y>
class Cursor<ArrayWhere<M, X, Y>> {
 public:
  template <std::size_t L, std::size_t K, class P>
  Cursor(Standing<L, K>, const ArrayWhere<M, X, Y>& node, const P& pass)
      : mask_(Standing<L, K>{}, node.mask, pass),
        x_(Standing<L + leaf_count<M>, K + M::kept_count>{}, node.x, pass),
        y_(Standing<L + leaf_count<M> + leaf_count<X>, K + M::kept_count + X::kept_count>{}, node.y, pass) {}
  void seek(const auto& index) {
    mask_.seek(index);
    x_.seek(index);
    y_.seek(index);
  }
  void forward(std::size_t position, std::size_t first, std::size_t count) {
    mask_.forward(position, first, count);
    x_.forward(position, first, count);
    y_.forward(position, first, count);
  }
  void backward(std::size_t first, std::size_t count) {
    if constexpr (X::may_be_active) x_.backward(first, count);
    if constexpr (Y::may_be_active) y_.backward(first, count);
  }
  [[nodiscard]] auto reader() {
    return WhereReader<ReaderOf<M>, ReaderOf<X>, ReaderOf<Y>, typename M::ArrayScalar, X::may_be_active,
                       Y::may_be_active>{mask_.reader(), x_.reader(), y_.reader()};
  }

 private:
  Cursor<M> mask_;
  Cursor<X> x_;
  Cursor<Y> y_;
};
}  // namespace tapestry::detail
