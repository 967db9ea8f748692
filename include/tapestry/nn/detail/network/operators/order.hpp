#pragma once
#include <tapestry/nn/detail/network/operators/reshape.hpp>
#include <tapestry/nn/detail/network/operators/softmax.hpp>

namespace tapestry::nn {
namespace detail {
/// Whether `a` comes before `b`: NaN before everything, then the larger, or the smaller.
template <std::floating_point T>
[[nodiscard]] bool comes_before(T a, T b, bool is_largest) {
  if (a != a || b != b) return a != a && b == b;
  return is_largest ? a > b : a < b;
}
}  // namespace detail

/// ArgMax and ArgMin: where the extreme of each run is, the first or the last of equal ones.
template <std::floating_point T>
class ArgExtreme : public Operation<T> {
 public:
  ArgExtreme(Shape shape, const AxisRuns& runs, bool is_largest, bool takes_last)
      : Operation<T>({{std::move(shape), ElementType::integer}}),
        runs_(runs),
        is_largest_(is_largest),
        takes_last_(takes_last) {}

  void forward(const ForwardCall<T>& call) const override {
    runs_.for_each_group([&](std::size_t place, std::size_t lanes) {
      const T* const x = call.inputs[0].values + place;
      T* const y =
          call.outputs[0].values + place / (runs_.count * runs_.inner) * runs_.inner + place % runs_.inner;
      std::size_t best[detail::lane_block] = {};
      for (std::size_t i = 1; i < runs_.count; ++i)
        for (std::size_t l = 0; l < lanes; ++l) {
          const T value = x[i * runs_.inner + l], leader = x[best[l] * runs_.inner + l];
          const bool is_better = takes_last_ ? !detail::comes_before(leader, value, is_largest_)
                                             : detail::comes_before(value, leader, is_largest_);
          if (is_better) best[l] = i;
        }
      for (std::size_t l = 0; l < lanes; ++l) y[l] = static_cast<T>(best[l]);
    });
  }

  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  AxisRuns runs_;
  bool is_largest_, takes_last_;
};

/// 1 where the largest element of each run is, the first of equal ones, and 0 elsewhere.
template <std::floating_point T>
class Hardmax : public Operation<T> {
 public:
  Hardmax(const Operand& x, const AxisRuns& runs) : Operation<T>({{x.shape, x.type}}), runs_(runs) {}

  void forward(const ForwardCall<T>& call) const override {
    std::fill_n(call.outputs[0].values, call.outputs[0].size(), T(0));
    for (std::size_t run = 0; run < runs_.outer * runs_.inner && runs_.count > 0; ++run) {
      const std::size_t first = run / runs_.inner * runs_.count * runs_.inner + run % runs_.inner;
      const T* const x = call.inputs[0].values + first;
      std::size_t best = 0;
      for (std::size_t i = 1; i < runs_.count; ++i)
        if (detail::comes_before(x[i * runs_.inner], x[best * runs_.inner], true)) best = i;
      call.outputs[0].values[first + best * runs_.inner] = T(1);
    }
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  AxisRuns runs_;
};

/// The k largest or smallest elements of each run, in order, and where they were; of equal ones the first.
template <std::floating_point T>
class TopK : public Operation<T> {
 public:
  TopK(const Operand& x, Shape shape, const AxisRuns& runs, std::size_t k, bool is_largest)
      : Operation<T>({{shape, x.type}, {shape, ElementType::integer}}),
        runs_(runs),
        k_(k),
        is_largest_(is_largest) {}

  void forward(const ForwardCall<T>& call) const override {
    const std::size_t size = runs_.outer * k_ * runs_.inner;
    if (call.keeps) call.state.choices.resize(size);
    T* const indices = call.outputs.size() > 1 ? call.outputs[1].values : nullptr;
    parallel_for(runs_.outer * runs_.inner, [&](std::size_t run) {
      const std::size_t outer = run / runs_.inner, inner = run % runs_.inner;
      const std::size_t from = outer * runs_.count * runs_.inner + inner;
      const T* const x = call.inputs[0].values + from;
      std::vector<std::size_t> order(runs_.count);
      std::iota(order.begin(), order.end(), std::size_t(0));
      const auto comes_before = [&](std::size_t a, std::size_t b) {
        const T first = x[a * runs_.inner], second = x[b * runs_.inner];
        if (detail::comes_before(first, second, is_largest_)) return true;
        return !detail::comes_before(second, first, is_largest_) && a < b;
      };
      std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(k_), order.end(),
                        comes_before);
      for (std::size_t i = 0; i < k_; ++i) {
        const std::size_t to = (outer * k_ + i) * runs_.inner + inner;
        call.outputs[0].values[to] = x[order[i] * runs_.inner];
        if (indices != nullptr) indices[to] = static_cast<T>(order[i]);
        if (call.keeps)
          call.state.choices.data()[to] = static_cast<ElementIndex<T>>(from + order[i] * runs_.inner);
      }
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const dy = call.output_adjoints[0].values;
    T* const dx = call.accumulate(0);
    for (std::size_t i = 0; dy != nullptr && i < call.output_adjoints[0].size(); ++i)
      dx[call.state.choices.data()[i]] += dy[i];
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  AxisRuns runs_;
  std::size_t k_;
  bool is_largest_;
};

/// Running sums: of the elements up to each one, or behind each one if reversed; without the element itself
/// if exclusive.
template <std::floating_point T>
class CumSum : public Operation<T> {
 public:
  CumSum(const Operand& x, const AxisRuns& runs, bool is_exclusive, bool is_reverse)
      : Operation<T>({{x.shape, x.type}}),
        runs_(runs),
        is_exclusive_(is_exclusive),
        is_reverse_(is_reverse) {}

  void forward(const ForwardCall<T>& call) const override {
    sum_up(call.inputs[0].values, call.outputs[0].values, is_reverse_, true);
  }
  void adjoint(const AdjointCall<T>& call) const override {
    sum_up(call.output_adjoints[0].values, call.input_adjoints[0].values, !is_reverse_,
           call.is_uninitialised[0]);
    call.is_uninitialised[0] = false;
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  void sum_up(const T* from, T* to, bool is_reverse, bool is_uninitialised) const {
    runs_.for_each_group([&](std::size_t place, std::size_t lanes) {
      double sums[detail::lane_block] = {};
      for (std::size_t i = 0; i < runs_.count; ++i) {
        const std::size_t row = place + (is_reverse ? runs_.count - 1 - i : i) * runs_.inner;
        for (std::size_t l = 0; l < lanes; ++l) {
          const double before = sums[l];
          sums[l] += static_cast<double>(from[row + l]);
          to[row + l] =
              static_cast<T>(is_exclusive_ ? before : sums[l]) + (is_uninitialised ? T(0) : to[row + l]);
        }
      }
    });
  }

  AxisRuns runs_;
  bool is_exclusive_, is_reverse_;
};

namespace detail {
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_arg_extreme(OperatorContext& context, bool is_largest) {
  const Operand& x = context.input(0);
  const std::size_t axis = axis_of(context, x.shape, 0);
  if (x.shape[axis] == 0) throw ShapeError({"axis ", axis, " has no elements"});
  Shape shape = x.shape;
  shape[axis] = 1;
  if (!context.flag("keepdims", 1)) shape.erase(shape.begin() + static_cast<std::ptrdiff_t>(axis));
  return std::make_unique<ArgExtreme<T>>(shape, AxisRuns(x.shape, axis, axis + 1), is_largest,
                                         context.flag("select_last_index", 0));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_top_k(OperatorContext& context) {
  const Operand& x = context.input(0);
  const std::size_t axis = axis_of(context, x.shape, -1);
  const bool is_largest = context.flag("largest", 1);
  static_cast<void>(context.flag("sorted", 1));
  std::int64_t k = context.opset() < 10 ? context.integer("k", -1) : 0;
  if (context.opset() >= 10) {
    const auto wanted = context.integers(1);
    if (wanted.size() != 1) throw ShapeError({"k has ", wanted.size(), " elements, expected 1"});
    k = wanted[0];
  }
  if (k < 0 || static_cast<std::size_t>(k) > x.shape[axis])
    throw DomainError({"k is ", k, " of ", x.shape[axis], " elements"});
  Shape shape = x.shape;
  shape[axis] = static_cast<std::size_t>(k);
  return std::make_unique<TopK<T>>(x, shape, AxisRuns(x.shape, axis, axis + 1), shape[axis], is_largest);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_cum_sum(OperatorContext& context) {
  const Operand& x = context.input(0);
  const auto wanted = context.integers(1);
  if (wanted.size() != 1 || x.shape.empty()) throw ShapeError("axis is not one of the operand's");
  const std::size_t axis = context.axis(wanted[0], x.shape.size());
  return std::make_unique<CumSum<T>>(x, AxisRuns(x.shape, axis, axis + 1), context.flag("exclusive", 0),
                                     context.flag("reverse", 0));
}
}  // namespace detail

/// Operators that compare or sum up the elements along an axis.
template <std::floating_point T>
void add_order_operators(OperatorTable<T>& table) {
  for (const bool is_largest : {false, true}) {
    const auto make = [is_largest](OperatorContext& context) {
      return detail::make_arg_extreme<T>(context, is_largest);
    };
    table[is_largest ? "ArgMax" : "ArgMin"] = {LayoutRule::plain, 1, false, {{1, 1}}, make};
  }
  table["TopK"] = {LayoutRule::plain, 1, false, {{1, 1}, {2, 2, 10}}, detail::make_top_k<T>};
  table["Hardmax"] = {LayoutRule::plain, 1, false, {{1, 1}}, [](OperatorContext& context) {
                        return std::make_unique<Hardmax<T>>(context.input(0), detail::softmax_runs(context));
                      }};
  table["CumSum"] = {LayoutRule::any, 1, false, {{2, 2}}, detail::make_cum_sum<T>};
}
}  // namespace tapestry::nn
