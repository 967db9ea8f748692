#pragma once
#include <tapestry/autodiff/detail/arrays/expression/node.hpp>

namespace tapestry::detail {
template <class T, std::size_t Rank, class Adjoints>
struct ElementPass {
  const RowPlan<Rank>& plan;
  const Adjoints& adjoints;  ///< adjoints of the leaves, in order; null if not wanted
  T* root;                   ///< values of a costly root, else null
  T* kept;                   ///< other costly values, [kept_count, plan.size], or null
  bool goes_back;            ///< root is read, not written
};

/// Place of a node in the expression: its first leaf, and its first kept array.
template <std::size_t FirstLeaf, std::size_t FirstKept>
struct Standing {};

/// State of a node while its elements are computed, a block at a time.
///  seek(index)                     goes to a row
///  forward(position, first, count) makes elements first … of the row ready, at `position` of them all
///  reader()                        reads them: Value(reader, i) has the value of element i of the block,
///                                  and what it was made of; reader.push(that, i, g) hands g back to the
///                                  leaves
///  backward(first, count)          adds what was handed back to the leaves' adjoints
///
/// Readers are plain pointers and numbers, so that a loop over a block keeps them in registers, with all
/// values between the leaves and the root of the expression.
template <class Node>
class Cursor;

/// Reads a block of numbers, and writes their gradients into another.
template <class T>
struct BlockReader {
  const T* values;
  T* back;

  struct Value {
    T value;
    [[gnu::always_inline]] Value(const BlockReader& reader, std::size_t i) : value(reader.values[i]) {}
  };
  [[gnu::always_inline]] void push(const Value&, std::size_t i, T g) const { back[i] = g; }
};

template <class T>
class Cursor<NumberNode<T>> {
 public:
  template <class S, class P>
  Cursor(S, const NumberNode<T>& node, const P&) : value_(node.value) {}
  void seek(const auto&) {}
  void forward(std::size_t, std::size_t, std::size_t) {}
  void backward(std::size_t, std::size_t) {}

  struct Reader {
    T number;

    struct Value {
      T value;
      [[gnu::always_inline]] Value(const Reader& reader, std::size_t) : value(reader.number) {}
    };
  };
  [[nodiscard]] Reader reader() { return {value_}; }

 private:
  T value_;
};

/// The adjoint of a scalar sums over the elements, in double.
template <class T>
class Cursor<ScalarNode<T>> {
 public:
  template <std::size_t L, std::size_t K, class P>
  Cursor(Standing<L, K>, const ScalarNode<T>& node, const P& pass)
      : value_(node.variable.value()), adjoint_(std::get<L>(pass.adjoints)) {}
  Cursor(const Cursor&) = delete;
  Cursor& operator=(const Cursor&) = delete;
  ~Cursor() {
    if (adjoint_ != nullptr) *adjoint_ += narrowed<T>(total_);
  }
  void seek(const auto&) {}
  void forward(std::size_t, std::size_t, std::size_t) {}
  void backward(std::size_t, std::size_t count) {
    if (adjoint_ == nullptr) return;
    Widened<T> sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += widened(back_[i]);
    total_ += sum;
  }

  struct Reader {
    T number;
    T* back;

    struct Value {
      T value;
      [[gnu::always_inline]] Value(const Reader& reader, std::size_t) : value(reader.number) {}
    };
    [[gnu::always_inline]] void push(const Value&, std::size_t i, T g) const { back[i] = g; }
  };
  [[nodiscard]] Reader reader() { return {value_, back_}; }

 private:
  T value_;
  T* adjoint_;
  Widened<T> total_ = 0;
  alignas(64) T back_[array_block];
};

/// Elements that do not follow each other in memory are copied into a block.
template <class T, std::size_t Rank>
class ViewCursor {
 public:
  template <class View, class P>
  ViewCursor(const View& view, const P& pass) : from_(view.whole().value().data() + view.offset()) {
    if constexpr (Rank > 0) {
      strides_ = view.strides_in(pass.plan.extents);
      step_ = strides_[Rank - 1];
    } else {
      step_ = pass.plan.extents.empty() ? 1 : 0;  // a node without axes repeats
    }
  }
  void seek(const auto& index) {
    row_ = 0;
    for (std::size_t axis = 0; axis < Rank; ++axis)
      row_ += static_cast<std::ptrdiff_t>(index[axis]) * strides_[axis];
  }
  void forward(std::size_t, std::size_t first, std::size_t count) {
    const std::ptrdiff_t step = step_;
    const T* const from = from_ + row_ + static_cast<std::ptrdiff_t>(first) * step;
    values_ = step == 1 ? from : copy_;
    if (step == 1) return;
    T* const copy = copy_;
    for (std::size_t i = 0; i < count; ++i) copy[i] = from[static_cast<std::ptrdiff_t>(i) * step];
  }

 protected:
  [[nodiscard]] const T* values() const { return values_; }
  [[nodiscard]] std::ptrdiff_t step() const { return step_; }
  [[nodiscard]] std::ptrdiff_t place(std::size_t first) const {
    return row_ + static_cast<std::ptrdiff_t>(first) * step_;
  }

 private:
  const T* from_;
  Strides<Rank> strides_{};
  std::ptrdiff_t step_ = 1;
  std::ptrdiff_t row_ = 0;
  const T* values_ = nullptr;
  alignas(64) T copy_[array_block];
};

template <class T, std::size_t Whole, std::size_t Rank>
class Cursor<ConstantView<T, Whole, Rank>> : public ViewCursor<T, Rank> {
 public:
  template <class S, class P>
  Cursor(S, const ConstantView<T, Whole, Rank>& view, const P& pass) : ViewCursor<T, Rank>(view, pass) {}
  void backward(std::size_t, std::size_t) {}
  [[nodiscard]] BlockReader<T> reader() { return {this->values(), nullptr}; }
};

template <class T, std::size_t Whole, std::size_t Rank>
class Cursor<ArrayView<T, Whole, Rank>> : public ViewCursor<T, Rank> {
 public:
  template <std::size_t L, std::size_t K, class P>
  Cursor(Standing<L, K>, const ArrayView<T, Whole, Rank>& view, const P& pass)
      : ViewCursor<T, Rank>(view, pass) {
    if (auto* const adjoint = std::get<L>(pass.adjoints); adjoint != nullptr)
      to_ = adjoint->data() + view.offset();
  }
  void backward(std::size_t first, std::size_t count) {
    if (to_ == nullptr) return;
    T* const to = to_ + this->place(first);
    const T* const back = back_;
    const std::ptrdiff_t step = this->step();
    if (step == 1) {
      for_block(count, [=](std::size_t i) { to[i] += back[i]; });
    } else if (step == 0) {
      Widened<T> sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += widened(back[i]);
      *to += narrowed<T>(sum);
    } else {
      for (std::size_t i = 0; i < count; ++i) to[static_cast<std::ptrdiff_t>(i) * step] += back[i];
    }
  }
  [[nodiscard]] BlockReader<T> reader() { return {this->values(), back_}; }

 private:
  T* to_ = nullptr;
  alignas(64) T back_[array_block];
};
}  // namespace tapestry::detail
