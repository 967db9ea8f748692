#pragma once
#include <tapestry/nn/detail/network/operators/kernel_attributes.hpp>

namespace tapestry::nn {
/// MaxPool and GlobalMaxPool. Values outside the picture count as −∞. The first of equal values in reading
/// order gets the adjoint. NaN counts as the largest value.
template <std::floating_point T>
class MaxPool : public Operation<T> {
 public:
  explicit MaxPool(PoolingPlan plan)
      : Operation<T>({{plan.out_shape(), ElementType::floating}}), plan_(std::move(plan)) {}

  [[nodiscard]] std::optional<MapWindow> window_reached(Engine, std::span<const MapWindow> changed,
                                                        bool) const override {
    return MapWindow{outputs_reached(plan_.rows, {}, changed[0].rows),
                     outputs_reached(plan_.columns, {}, changed[0].columns)};
  }
  [[nodiscard]] MapWindow window_read(Engine, std::size_t, const MapWindow& computed) const override {
    return {inputs_needed(plan_.rows, {}, computed.rows), inputs_needed(plan_.columns, {}, computed.columns)};
  }

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    ElementIndex<T>* choice = nullptr;
    if (call.keeps) {
      call.state.choices.resize(plan_.images * plan_.out_size());
      choice = call.state.choices.data();
    }
    const bool touches = plan_.rows.spacing == 1 && plan_.columns.spacing == 1;
    if (!touches) return pool_spaced(in, out, choice);
    if (choice == nullptr && plan_.rows.taps > 1 && plan_.columns.taps > 3) return pool_by_axis(in, out);
    pool(in, out, choice);
  }

  /// The adjoint of each output goes to the pixel that was chosen for it.
  void adjoint(const AdjointCall<T>& call) const override {
    const ElementIndex<T>* const choice = call.state.choices.data();
    const T* const out_adjoint = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    const std::size_t channels = plan_.channels, pixels = plan_.rows.output * plan_.columns.output;
    constexpr std::size_t slice = 32;  // pictures, and slices of channels of each, are independent
    const std::size_t slices = block_count(channels, slice);
    parallel_for(plan_.images * slices, [&](std::size_t task) {
      const std::size_t image = task / slices;
      const BlockRange range = block_range(task % slices, channels, slice);
      T* const picture = in_adjoint + image * plan_.in_size();
      for (std::size_t pixel = 0; pixel < pixels; ++pixel)
        for (std::size_t c = range.begin; c < range.end; ++c) {
          const std::size_t output = (image * pixels + pixel) * channels + c;
          picture[static_cast<std::size_t>(choice[output]) * channels + c] += out_adjoint[output];
        }
    });
  }
  void apply_choice(const OperationState<T>& state, const T* from, T* to) const override {
    const std::size_t channels = plan_.channels;
    parallel_for(plan_.images * plan_.rows.output, [&](std::size_t row) {
      const std::size_t size = plan_.columns.output * channels;
      const T* const picture = from + row / plan_.rows.output * plan_.in_size();
      for (std::size_t i = row * size; i < (row + 1) * size; ++i)
        to[i] = picture[static_cast<std::size_t>(state.choices.data()[i]) * channels + i % channels];
    });
  }

 private:
  [[nodiscard]] ElementIndex<T> position(std::size_t in) const {
    return static_cast<ElementIndex<T>>(in % plan_.in_size() / plan_.channels);
  }

  void pool(const T* in, T* out, ElementIndex<T>* choice) const {
    plan_.for_each_output(
        [&](std::size_t first, std::size_t to, const KernelTaps& row, const KernelTaps& column) {
          kernels<T>().max_pool_pixel({in + first, row.count, column.count, plan_.row_size(), plan_.channels,
                                       position(first), plan_.columns.input, out + to,
                                       choice == nullptr ? nullptr : choice + to});
        });
  }

  /// Pools along rows first, then along columns of the result: fewer comparisons for large windows.
  void pool_by_axis(const T* in, T* out) const {
    static thread_local Buffer<T> kept;
    Buffer<T>& rows = kept;  // this thread's, whichever threads run the tasks
    const std::size_t channels = plan_.channels, row_size = plan_.columns.output * channels;
    rows.resize(plan_.images * plan_.rows.input * row_size);
    parallel_for(plan_.images * plan_.rows.input, [&](std::size_t row) {
      for (std::size_t x = 0; x < plan_.columns.output; ++x) {
        const KernelTaps& window = plan_.column_windows[x];
        kernels<T>().max_pool_pixel({in + row * plan_.row_size() + window.first * channels, 1, window.count,
                                     0, channels, 0, 0, rows.data() + row * row_size + x * channels,
                                     nullptr});
      }
    });
    parallel_for(plan_.images * plan_.rows.output, [&](std::size_t task) {
      const KernelTaps& window = plan_.row_windows[task % plan_.rows.output];
      const T* first = rows.data() + (task / plan_.rows.output * plan_.rows.input + window.first) * row_size;
      // a whole row of pixels, treated as one pixel with many channels
      kernels<T>().max_pool_pixel(
          {first, window.count, 1, row_size, row_size, 0, 0, out + task * row_size, nullptr});
    });
  }

  void pool_spaced(const T* in, T* out, ElementIndex<T>* choice) const {
    plan_.for_each_output(
        [&](std::size_t first, std::size_t to, const KernelTaps& row, const KernelTaps& column) {
          for (std::size_t c = 0; c < plan_.channels; ++c) {
            std::size_t best = first;
            plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
              const T value = in[tap + c], largest = in[best + c];
              if (value > largest || (value != value && largest == largest)) best = tap;
            });
            out[to + c] = in[best + c];
            if (choice != nullptr) choice[to + c] = position(best);
          }
        });
  }

  PoolingPlan plan_;
};

/// A window of the size of the picture. \throws as picture_shape()
[[nodiscard]] inline PoolingPlan plan_global_pooling(const OperatorContext& context) {
  const Shape& picture = picture_shape(context);
  PoolingPlan plan;
  plan.images = picture[0];
  plan.channels = picture[3];
  plan.rows = {picture[1], 1, picture[1], 1, 1, 0};
  plan.columns = {picture[2], 1, picture[2], 1, 1, 0};
  plan.row_windows = {{0, picture[1], picture[1]}};
  plan.column_windows = {{0, picture[2], picture[2]}};
  return plan;
}

/// MaxPool without the result Indices, and GlobalMaxPool.
template <std::floating_point T>
void add_max_pool(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    static_cast<void>(context.flag("storage_order", 0));  // concerns only Indices
    return std::make_unique<MaxPool<T>>(plan_pooling(context, false));
  };
  table["MaxPool"] = {LayoutRule::channels_last, 1, false, {{1, 1}}, make, window_ranges()};
  table["GlobalMaxPool"] = {LayoutRule::channels_last, 1, false, {{1, 1}}, [](OperatorContext& context) {
                              return std::make_unique<MaxPool<T>>(plan_global_pooling(context));
                            }};
}

/// AveragePool and GlobalAveragePool.
template <std::floating_point T>
class AveragePool : public Operation<T> {
 public:
  /// \param counts_padding  zeros around the picture count as values
  AveragePool(PoolingPlan plan, bool counts_padding)
      : Operation<T>({{plan.out_shape(), ElementType::floating}}),
        plan_(std::move(plan)),
        counts_padding_(counts_padding) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    plan_.for_each_output([&](std::size_t first, std::size_t to, const KernelTaps& row,
                              const KernelTaps& column) {
      std::vector<double> total;
      std::size_t summed = 0;
      plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
        if (summed == most_in_t) join(out + to, total, summed);
        if (summed++ == 0) {
          std::copy_n(in + tap, plan_.channels, out + to);
        } else {
          kernels<T>().add(in + tap, out + to, plan_.channels);
        }
      });
      if (summed == 0) std::fill_n(out + to, plan_.channels, T(0));
      if (!total.empty()) join(out + to, total, summed);
      const double factor = factor_of(row, column);
      for (std::size_t c = 0; c < plan_.channels; ++c)
        out[to + c] = static_cast<T>((total.empty() ? static_cast<double>(out[to + c]) : total[c]) * factor);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const adjoint = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    plan_.for_each_output_in_order(
        [&](std::size_t first, std::size_t from, const KernelTaps& row, const KernelTaps& column) {
          const T factor = static_cast<T>(factor_of(row, column));
          for (std::size_t c = 0; c < plan_.channels; ++c) adjoint[from + c] *= factor;
          plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
            kernels<T>().add(adjoint + from, in_adjoint + tap, plan_.channels);
          });
        });
  }

 private:
  /// Number of values summed in T before their sum is added to others in double, so that pictures may be
  /// large.
  static constexpr std::size_t most_in_t = 64;

  void join(const T* sum, std::vector<double>& total, std::size_t& summed) const {
    total.resize(plan_.channels, 0);
    for (std::size_t c = 0; c < plan_.channels; ++c) total[c] += static_cast<double>(sum[c]);
    summed = 0;
  }

  [[nodiscard]] double factor_of(const KernelTaps& row, const KernelTaps& column) const {
    const std::size_t count =
        counts_padding_ ? row.with_padding * column.with_padding : row.count * column.count;
    return 1 / static_cast<double>(std::max<std::size_t>(1, count));
  }

  PoolingPlan plan_;
  bool counts_padding_;
};

/// LpPool and GlobalLpPool: (Σ |x|^p)^(1/p). The derivative is 0 where a whole window is 0.
template <std::floating_point T>
class LpPool : public Operation<T> {
 public:
  LpPool(PoolingPlan plan, double p)
      : Operation<T>({{plan.out_shape(), ElementType::floating}}), plan_(std::move(plan)), p_(p) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    plan_.for_each_output(
        [&](std::size_t first, std::size_t to, const KernelTaps& row, const KernelTaps& column) {
          for (std::size_t c = 0; c < plan_.channels; ++c) {
            double sum = 0;
            plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
              sum += std::pow(std::abs(static_cast<double>(in[tap + c])), p_);
            });
            out[to + c] = static_cast<T>(std::pow(sum, 1 / p_));
          }
        });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const in = call.inputs[0].values;
    const T* const out = call.outputs[0].values;
    const T* const adjoint = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    plan_.for_each_output_in_order(
        [&](std::size_t first, std::size_t from, const KernelTaps& row, const KernelTaps& column) {
          plan_.for_each_tap(first, row, column, [&](std::size_t tap) {
            for (std::size_t c = 0; c < plan_.channels; ++c) {
              const auto x = static_cast<double>(in[tap + c]), y = static_cast<double>(out[from + c]);
              if (x == 0 || y == 0) continue;
              const double slope = std::copysign(std::pow(std::abs(x) / y, p_ - 1), x);
              in_adjoint[tap + c] += static_cast<T>(slope * static_cast<double>(adjoint[from + c]));
            }
          });
        });
  }
  [[nodiscard]] AdjointReads adjoint_reads() const override { return {1, 1}; }

 private:
  PoolingPlan plan_;
  double p_;
};

template <std::floating_point T>
void add_average_pool(OperatorTable<T>& table) {
  const auto average = [](OperatorContext& context) {
    const bool counts_padding = context.flag("count_include_pad", 0);
    return std::make_unique<AveragePool<T>>(plan_pooling(context, true), counts_padding);
  };
  const auto average_all = [](OperatorContext& context) {
    return std::make_unique<AveragePool<T>>(plan_global_pooling(context), false);
  };
  const auto norm = [](OperatorContext& context) {
    const bool is_global = context.node().operation == "GlobalLpPool";
    PoolingPlan plan = is_global ? plan_global_pooling(context) : plan_pooling(context, true);
    return std::make_unique<LpPool<T>>(std::move(plan), static_cast<double>(context.integer("p", 2)));
  };
  const AttributeRange norms{"p", 1, largest_extent};
  constexpr auto layout = LayoutRule::channels_last;
  table["AveragePool"] = {layout, 1, false, {{1, 1}}, average, window_ranges()};
  table["GlobalAveragePool"] = {layout, 1, false, {{1, 1}}, average_all};
  table["LpPool"] = {layout, 1, false, {{1, 1}}, norm, window_ranges({norms})};
  table["GlobalLpPool"] = {layout, 1, false, {{1, 1}}, norm, {norms}};
}
}  // namespace tapestry::nn
