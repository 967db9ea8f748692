#pragma once
#include <tapestry/autodiff/detail/arrays/expression/node_cursors.hpp>
#include <tapestry/autodiff/record.hpp>

namespace tapestry {
namespace detail {
/// A sum in double whose error does not grow with the number of terms: blocks in eight lanes, the blocks'
/// sums compensated (Neumaier), always in the same order. Relative error at most about 70 ε · Σ|term| / |Σ
/// term|. Sums of duals are not compensated.
template <class Sum = double>
class CompensatedSum {
 public:
  /// Adds term(0) … term(count − 1); up to 512 terms are one block.
  template <class Term>
  void add(std::size_t count, Term term) {
    for (std::size_t first = 0; first < count; first += 512)
      add_block(first, std::min(count, first + 512), term);
  }
  [[nodiscard]] Sum total() const { return total_ + lost_; }

 private:
  template <class Term>
  void add_block(std::size_t first, std::size_t last, Term term) {
    Sum lanes[8] = {};
    std::size_t i = first;
    for (; i + 8 <= last; i += 8)
      for (std::size_t lane = 0; lane < 8; ++lane) lanes[lane] += widened(term(i + lane));
    for (; i < last; ++i) lanes[0] += widened(term(i));
    Sum block = 0;
    for (const Sum& lane : lanes) block += lane;
    const Sum sum = total_ + block;
    if constexpr (std::floating_point<Sum>)
      if (std::isfinite(sum))
        lost_ += std::abs(total_) >= std::abs(block) ? (total_ - sum) + block : (block - sum) + total_;
    total_ = sum;
  }

  Sum total_ = 0;
  Sum lost_ = 0;
};

template <ArrayExpression E>
[[nodiscard]] auto plan_of(const E& node) {
  return RowPlan<E::rank>(node.shape(), [&](std::size_t axis) {
    if constexpr (E::rank > 1) {
      return node.joins(axis, node.shape());
    } else {
      return static_cast<void>(axis), false;
    }
  });
}

/// The null adjoint, for operands whose adjoint is not needed.
template <class T>
[[nodiscard]] inline T* no_adjoint(const Variable<T>&) {
  return nullptr;
}
template <class T, std::size_t Rank>
[[nodiscard]] inline Array<T, Rank>* no_adjoint(const ArrayVariable<T, Rank>&) {
  return nullptr;
}

template <class E>
[[nodiscard]] bool is_active_expression(const E& node) {
  return std::apply([](const auto&... leaves) { return (leaves.is_active() || ... || false); },
                    node.leaves());
}

template <ArrayExpression E>
[[nodiscard]] std::shared_ptr<Array<typename E::ArrayScalar, 1>> make_kept(const E& node, std::size_t size) {
  if (size == 0 || !is_active_expression(node)) return nullptr;
  return std::make_shared<Array<typename E::ArrayScalar, 1>>(Extents<1>{size});
}

template <class T>
[[nodiscard]] T* kept_data(const std::shared_ptr<Array<T, 1>>& kept) {
  return kept == nullptr ? nullptr : kept->data();
}

/// Memory for the values of a costly root: the result itself.
template <ArrayExpression E>
[[nodiscard]] typename E::ArrayScalar* root_of(typename E::ArrayScalar* result) {
  return is_costly_node<E> ? result : nullptr;
}

/// Goes through an expression's elements a block at a time: visit(cursor, position, first of the row, count).
template <ArrayExpression E, class Adjoints, class Visit>
void for_each_block(const E& node, const ElementPass<typename E::ArrayScalar, E::rank, Adjoints>& pass,
                    Visit visit) {
  Cursor<E> cursor(Standing<0, 0>{}, node, pass);
  pass.plan.for_each_row([&](const auto& index, std::size_t row) {
    cursor.seek(index);
    for (std::size_t first = 0; first < pass.plan.length; first += array_block) {
      const std::size_t count = std::min(array_block, pass.plan.length - first);
      cursor.forward(row + first, first, count);
      visit(cursor, row + first, first, count);
    }
  });
}

/// Computes an expression: take(reader, position, count) takes a block's values.
template <ArrayExpression E, class Take>
void run_forward(const E& node, typename E::ArrayScalar* root, typename E::ArrayScalar* kept, Take take) {
  using T = typename E::ArrayScalar;
  const auto plan = plan_of(node);
  const auto nulls =
      std::apply([](const auto&... leaves) { return std::make_tuple(no_adjoint(leaves)...); }, node.leaves());
  const ElementPass<T, E::rank, decltype(nulls)> pass{plan, nulls, root, kept, false};
  for_each_block(node, pass, [&](auto& cursor, std::size_t position, std::size_t, std::size_t count) {
    take(cursor.reader(), position, count);
  });
}

/// Runs the pullback of an expression: adjoint_of(position) points to the adjoints of a block's elements.
template <ArrayExpression E, class Adjoints, class AdjointOf>
void run_backward(const E& node, typename E::ArrayScalar* root, typename E::ArrayScalar* kept,
                  const Adjoints& adjoints, AdjointOf adjoint_of) {
  using T = typename E::ArrayScalar;
  const auto plan = plan_of(node);
  const ElementPass<T, E::rank, Adjoints> pass{plan, adjoints, root, kept, true};
  for_each_block(node, pass, [&](auto& cursor, std::size_t position, std::size_t first, std::size_t count) {
    using Reader = decltype(cursor.reader());
    for_block(count, PushAdjoint<Reader, T>{cursor.reader(), adjoint_of(position)});
    cursor.backward(first, count);
  });
}

/// Sums an expression in the pass that computes it, without an array of its values, as one operation.
template <ArrayExpression E>
[[nodiscard]] Variable<typename E::ArrayScalar> evaluate_sum(const E& node) {
  using T = typename E::ArrayScalar;
  const auto kept = make_kept(node, E::kept_count * count_of(node.shape()));
  CompensatedSum<Widened<T>> sum;
  T block[array_block];
  run_forward(node, nullptr, kept_data(kept), [&](const auto& reader, std::size_t, std::size_t count) {
    for_block(count, StoreValue<std::remove_cvref_t<decltype(reader)>, T>{reader, block});
    sum.add(count, [&](std::size_t i) { return block[i]; });
  });
  const auto pullback = [node, kept](T value_adjoint, auto*... leaf_adjoints) {
    T g[array_block];
    std::fill_n(g, array_block, value_adjoint);
    run_backward(node, nullptr, kept_data(kept), std::make_tuple(leaf_adjoints...),
                 [&](std::size_t) { return static_cast<const T*>(g); });
  };
  return std::apply(
      [&](const auto&... leaves) {
        return record_scalar(narrowed<T>(sum.total()), CarriesTangents{pullback}, leaves...);
      },
      node.leaves());
}

template <class E>
inline constexpr bool is_matrix_view = false;
template <class T, std::size_t Whole>
inline constexpr bool is_matrix_view<ArrayView<T, Whole, 2>> = true;

/// Whether neighbours in the whole array are neighbours in a column rather than in a row.
template <class T, std::size_t Whole>
[[nodiscard]] bool stands_on_its_side(const ArrayView<T, Whole, 2>& view) {
  return view.strides()[0] != 0 && std::abs(view.strides()[0]) < std::abs(view.strides()[1]);
}

/// Calls visit(element of the whole array, element of the view) for all of a transposed matrix, column by
/// column, so that the whole array is read in order.
template <class T, std::size_t Whole, class Visit>
void for_each_on_its_side(const ArrayView<T, Whole, 2>& view, Visit visit) {
  const std::size_t rows = view.shape()[0], columns = view.shape()[1];
  for (std::size_t j = 0; j < columns; ++j) {
    std::ptrdiff_t at = view.offset() + static_cast<std::ptrdiff_t>(j) * view.strides()[1];
    for (std::size_t i = 0; i < rows; ++i, at += view.strides()[0]) visit(at, i * columns + j);
  }
}

template <class T, std::size_t Whole>
[[nodiscard]] ArrayVariable<T, 2> evaluate_on_its_side(const ArrayView<T, Whole, 2>& view) {
  const auto value = std::make_shared<Array<T, 2>>(view.shape());
  const T* const from = view.whole().value().data();
  T* const to = value->data();
  for_each_on_its_side(view, [=](std::ptrdiff_t at, std::size_t place) { to[place] = from[at]; });
  const auto pullback = [view](const Array<T, 2>& value_adjoint, Array<T, Whole>* whole_adjoint) {
    const T* const g = value_adjoint.data();
    T* const whole = whole_adjoint->data();
    for_each_on_its_side(view, [=](std::ptrdiff_t at, std::size_t place) { whole[at] += g[place]; });
  };
  return record_array(std::shared_ptr<const Array<T, 2>>(value), CarriesTangents{pullback}, view.whole());
}
}  // namespace detail

/// The value of a formula, computed in one pass over its elements and recorded as one operation, whose
/// pullback is one pass, too. Assigning a formula to an ArrayVariable calls it.
template <ArrayExpression E>
[[nodiscard]] ArrayVariable<typename E::ArrayScalar, E::rank> evaluated(const E& node) {
  using T = typename E::ArrayScalar;
  if constexpr (detail::is_matrix_view<E>) {
    if (detail::stands_on_its_side(node)) return detail::evaluate_on_its_side(node);
  }
  constexpr std::size_t rank = E::rank;
  constexpr std::size_t kept_count = E::kept_count - (detail::is_costly_node<E> ? 1 : 0);
  const auto value = std::make_shared<Array<T, rank>>(node.shape());
  const auto kept = detail::make_kept(node, kept_count * value->size());
  T* const to = value->data();
  const auto take = [=](const auto& reader, std::size_t position, std::size_t count) {
    if constexpr (!detail::is_costly_node<E>)
      detail::for_block(count,
                        detail::StoreValue<std::remove_cvref_t<decltype(reader)>, T>{reader, to + position});
  };
  detail::run_forward(node, detail::root_of<E>(to), detail::kept_data(kept), take);
  const auto pullback = [node, kept, value](const Array<T, rank>& value_adjoint, auto*... leaf_adjoints) {
    const T* const g = value_adjoint.data();
    detail::run_backward(node, detail::root_of<E>(value->data()), detail::kept_data(kept),
                         std::make_tuple(leaf_adjoints...),
                         [=](std::size_t position) { return g + position; });
  };
  return std::apply(
      [&](const auto&... leaves) {
        return record_array(std::shared_ptr<const Array<T, rank>>(value), CarriesTangents{pullback},
                            leaves...);
      },
      node.leaves());
}
}  // namespace tapestry
