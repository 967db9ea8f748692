#pragma once
#include <tapestry/nn/detail/network/operators/reshape.hpp>

namespace tapestry::nn {
/// Σ |x|.
struct AbsoluteSumStep : SumStep {
  static double next(double sum, double value) { return sum + (value < 0 ? -value : value); }
};
/// Σ x².
struct SquareStep : SumStep {
  static double next(double sum, double value) { return sum + value * value; }
};
/// Σ e^x.
struct ExponentialStep : SumStep {
  static double next(double sum, double value) { return sum + std::exp(value); }
};
/// Π x.
struct ProductStep {
  static double first() { return 1; }
  static double next(double product, double value) { return product * value; }
  static double join(double product, double part) { return product * part; }
};
/// The smallest x.
struct SmallestStep {
  static double first() { return std::numeric_limits<double>::infinity(); }
  static double next(double best, double value) { return value < best || value != value ? value : best; }
  static double join(double best, double part) { return best != best ? best : next(best, part); }
};

enum class Reduction { sum, mean, max, min, product, l1, l2, log_sum, log_sum_exp, sum_square };

/// A tensor reduced along some axes; sums are taken in double. The first of equal extremes gets the whole
/// adjoint. The derivative of L1 and L2 is 0 at 0. NaN counts as an extreme of either kind.
template <std::floating_point T>
class Reduce : public Operation<T> {
 public:
  /// \param kept_strides  of the result, for the axes of x that stay
  Reduce(Reduction kind, const Operand& x, Shape result, const std::vector<bool>& is_reduced,
         std::vector<std::ptrdiff_t> kept_strides)
      : Operation<T>({{std::move(result), x.type}}),
        kind_(kind),
        is_integer_(x.type == ElementType::integer),
        plan_(x.shape, is_reduced, kept_strides) {
    const auto strides = strides_of(x.shape);
    for (std::size_t axis = 0; axis < x.shape.size(); ++axis)
      nest_.loops.push_back({x.shape[axis], {strides[axis], is_reduced[axis] ? 0 : kept_strides[axis]}});
    nest_.simplify();
  }

  void forward(const ForwardCall<T>& call) const override {
    const T* const x = call.inputs[0].values;
    T* const y = call.outputs[0].values;
    if (kind_ == Reduction::max || kind_ == Reduction::min) return find_extremes(call);
    const auto store = [&](std::ptrdiff_t at, double value) {
      const bool is_root = kind_ == Reduction::l2;
      y[at] = static_cast<T>(is_root                       ? std::sqrt(value)
                             : kind_ == Reduction::log_sum ? std::log(value)
                                                           : value);
    };
    if (kind_ == Reduction::log_sum_exp) return sum_exponentials(x, y);
    if (kind_ == Reduction::product) return reduce<ProductStep>(plan_, x, no_shifts, store);
    if (kind_ == Reduction::l1) return reduce<AbsoluteSumStep>(plan_, x, no_shifts, store);
    if (kind_ == Reduction::sum_square || kind_ == Reduction::l2)
      return reduce<SquareStep>(plan_, x, no_shifts, store);
    reduce<SumStep>(plan_, x, no_shifts, [&](std::ptrdiff_t at, double sum) {
      const double mean = sum / (kind_ == Reduction::mean ? static_cast<double>(plan_.count) : 1);
      store(at, is_integer_ ? std::trunc(mean) : mean);
    });
  }

  void apply_choice(const OperationState<T>& state, const T* from, T* to) const override {
    for (std::size_t i = 0; i < size_of(this->result_shape()); ++i) {
      const auto place = state.choices.data()[i];
      to[i] = place < 0 ? T(0) : from[place];
    }
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const dy = call.output_adjoints[0].values;
    if (kind_ == Reduction::max || kind_ == Reduction::min) {
      T* const dx = call.accumulate(0);
      const ElementIndex<T>* const chosen = call.state.choices.data();
      for (std::size_t i = 0; i < call.output_adjoints[0].size(); ++i)
        if (chosen[i] >= 0) dx[chosen[i]] += dy[i];
      return;
    }
    const T *const x = call.inputs[0].values, *const y = call.outputs[0].values;
    T* const dx = call.input_adjoints[0].values;
    const bool is_uninitialised = call.is_uninitialised[0],
               is_linear = kind_ == Reduction::sum || kind_ == Reduction::mean;
    const std::ptrdiff_t step = nest_.loops.back().strides[1];
    const T scale = kind_ == Reduction::mean ? 1 / static_cast<T>(plan_.count) : T(1);
    parallel_for_each_run(nest_, [&](const auto& at, std::size_t count) {
      if (is_linear) return spread(dy + at[1], step, scale, is_uninitialised, dx + at[0], count);
      for (std::size_t i = 0; i < count; ++i) {
        const auto from = at[0] + static_cast<std::ptrdiff_t>(i);
        const auto to = at[1] + static_cast<std::ptrdiff_t>(i) * step;
        const T pulled = dy[to] * slope(x, y, from, to);
        dx[from] = pulled + (is_uninitialised ? T(0) : dx[from]);
      }
    });
    call.is_uninitialised[0] = false;
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    const bool reads_input = kind_ == Reduction::l1 || kind_ == Reduction::l2 ||
                             kind_ == Reduction::product || kind_ == Reduction::log_sum_exp ||
                             kind_ == Reduction::sum_square;
    const bool reads_output = kind_ == Reduction::l2 || kind_ == Reduction::product ||
                              kind_ == Reduction::log_sum || kind_ == Reduction::log_sum_exp;
    return {reads_input ? 1U : 0U, reads_output ? 1U : 0U};
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  static constexpr const T* no_shifts = nullptr;

  /// log Σ e^(x − m) + m with m the largest x; where that is infinite, so is the result.
  void sum_exponentials(const T* x, T* y) const {
    reduce<LargestStep>(plan_, x, no_shifts, [&](std::ptrdiff_t at, double largest) {
      y[at] = static_cast<T>(std::isinf(largest) ? 0 : largest);
    });
    reduce<ExponentialStep>(plan_, x, static_cast<const T*>(y),
                            [&](std::ptrdiff_t at, double sum) { y[at] += static_cast<T>(std::log(sum)); });
  }

  void find_extremes(const ForwardCall<T>& call) const {
    const T* const x = call.inputs[0].values;
    T* const y = call.outputs[0].values;
    const auto store = [&](std::ptrdiff_t at, double value) { y[at] = static_cast<T>(value); };
    if (kind_ == Reduction::max) {
      reduce<LargestStep>(plan_, x, no_shifts, store);
    } else {
      reduce<SmallestStep>(plan_, x, no_shifts, store);
    }
    if (!call.keeps) return;
    call.state.choices.resize(call.outputs[0].size());
    ElementIndex<T>* const chosen = call.state.choices.data();
    std::fill_n(chosen, call.outputs[0].size(), ElementIndex<T>(-1));
    const std::ptrdiff_t step = nest_.loops.back().strides[1];
    for_each_run(nest_, [&](const auto& at, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        const auto from = at[0] + static_cast<std::ptrdiff_t>(i);
        const auto to = at[1] + static_cast<std::ptrdiff_t>(i) * step;
        const bool is_it = x[from] == y[to] || (x[from] != x[from] && y[to] != y[to]);
        if (is_it && chosen[to] < 0) chosen[to] = static_cast<ElementIndex<T>>(from);
      }
    });
  }

  /// dx = scale · dy, or += that, with dy `step` apart.
  static void spread(const T* dy, std::ptrdiff_t step, T scale, bool is_uninitialised, T* dx,
                     std::size_t count) {
    if (is_uninitialised) {
      for (std::size_t i = 0; i < count; ++i, dy += step) dx[i] = scale * *dy;
    } else {
      for (std::size_t i = 0; i < count; ++i, dy += step) dx[i] += scale * *dy;
    }
  }

  /// ∂y[to]/∂x[from] for reductions other than sums and means.
  [[nodiscard]] T slope(const T* x, const T* y, std::ptrdiff_t from, std::ptrdiff_t to) const {
    if (kind_ == Reduction::product) return x[from] != 0 ? y[to] / x[from] : product_of_others(x, from, to);
    if (kind_ == Reduction::l1) return x[from] > 0 ? T(1) : x[from] < 0 ? T(-1) : T(0);
    if (kind_ == Reduction::l2) return y[to] == 0 ? T(0) : x[from] / y[to];
    if (kind_ == Reduction::sum_square) return 2 * x[from];
    if (kind_ == Reduction::log_sum) return std::exp(-y[to]);
    return kind_ == Reduction::log_sum_exp ? std::exp(x[from] - y[to]) : T(1);
  }

  [[nodiscard]] T product_of_others(const T* x, std::ptrdiff_t from, std::ptrdiff_t to) const {
    T product = 1;
    const std::ptrdiff_t step = nest_.loops.back().strides[1];
    for_each_run(nest_, [&](const auto& at, std::size_t count) {
      for (std::size_t i = 0; i < count; ++i) {
        const auto k = static_cast<std::ptrdiff_t>(i);
        if (at[1] + k * step == to && at[0] + k != from) product *= x[at[0] + k];
      }
    });
    return product;
  }

  Reduction kind_;
  bool is_integer_;
  AxisReduction plan_;
  LoopNest<2> nest_;  ///< loops over x: places in x and in y
};

namespace detail {
/// \param since  first opset with the axes as an operand
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_reduce(OperatorContext& context, Reduction kind,
                                                        std::int64_t since) {
  const Operand& x = context.input(0);
  const std::size_t rank = x.shape.size();
  bool keeps_axes = context.flag("keepdims", 1);
  const bool none_is_all = !context.flag("noop_with_empty_axes", 0);
  const auto axes = axes_of(context, since, rank);
  const bool has_axes = axes && !axes->empty();
  std::vector<bool> is_reduced(rank, !has_axes && none_is_all);
  for (std::size_t i = 0; has_axes && i < axes->size(); ++i) is_reduced.at((*axes)[i]) = true;
  keeps_axes = keeps_axes || std::ranges::count(is_reduced, true) == 0;
  // Axes as the description numbers them; they set the order of the axes that stay.
  Shape shape;
  std::vector<std::size_t> places;
  for (std::size_t axis = 0; axis < rank; ++axis) {
    const std::size_t place = keeps_axes ? axis : context.axis(static_cast<std::int64_t>(axis), rank);
    if (is_reduced[place] && !keeps_axes) continue;
    shape.push_back(is_reduced[place] ? 1 : x.shape[place]);
    places.push_back(place);
  }
  const auto strides = strides_of(shape);
  std::vector<std::ptrdiff_t> kept_strides(rank, 0);
  for (std::size_t i = 0; i < places.size(); ++i) kept_strides[places[i]] = strides[i];
  return std::make_unique<Reduce<T>>(kind, x, shape, is_reduced, kept_strides);
}
}  // namespace detail

/// Reductions along axes; their axes are an attribute up to opset 17, of ReduceSum up to opset 12.
template <std::floating_point T>
void add_reduce_operators(OperatorTable<T>& table) {
  const std::pair<const char*, Reduction> kinds[] = {{"ReduceSum", Reduction::sum},
                                                     {"ReduceMean", Reduction::mean},
                                                     {"ReduceMax", Reduction::max},
                                                     {"ReduceMin", Reduction::min},
                                                     {"ReduceProd", Reduction::product},
                                                     {"ReduceL1", Reduction::l1},
                                                     {"ReduceL2", Reduction::l2},
                                                     {"ReduceLogSum", Reduction::log_sum},
                                                     {"ReduceLogSumExp", Reduction::log_sum_exp},
                                                     {"ReduceSumSquare", Reduction::sum_square}};
  for (const auto& [name, kind] : kinds) {
    const std::int64_t since = kind == Reduction::sum ? 13 : 18;
    const auto make = [reduction = kind, since](OperatorContext& context) {
      return detail::make_reduce<T>(context, reduction, since);
    };
    table[name] = {LayoutRule::any, 1, false, {{1, 1}, {1, 2, since}}, make};
  }
}
}  // namespace tapestry::nn
