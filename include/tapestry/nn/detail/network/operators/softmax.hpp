#pragma once
#include <tapestry/nn/detail/network/operators/binary.hpp>

namespace tapestry::nn {
/// Neighbouring axes of a tensor that an operation works along, those before them and those behind.
struct AxisRuns {
  std::size_t outer = 1, count = 1, inner = 1;

  /// \param first, last  the axes first … last − 1
  AxisRuns(const Shape& shape, std::size_t first, std::size_t last) {
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
      (axis < first ? outer : axis < last ? count : inner) *= shape[axis];
  }

  /// Calls body(place of the first element, lanes) for groups of at most detail::lane_block neighbouring
  /// runs, whose elements are `inner` apart.
  template <class Body>
  void for_each_group(const Body& body) const {
    const std::size_t blocks = block_count(inner, detail::lane_block);
    const std::size_t work = std::max<std::size_t>(std::min(inner, detail::lane_block) * count, 1);
    const std::size_t tasks = outer * blocks;
    const std::size_t together = std::max<std::size_t>(detail::nest_block / 4 / work, 1);
    parallel_for_blocks(tasks, together, [&](std::size_t begin, std::size_t end) {
      for (std::size_t task = begin; task < end; ++task) {
        const BlockRange lanes = block_range(task % blocks, inner, detail::lane_block);
        body(task / blocks * count * inner + lanes.begin, lanes.end - lanes.begin);
      }
    });
  }
};

/// e^xᵢ / Σ e^xⱼ along some axes, or its logarithm. The largest x is subtracted first, and sums are taken in
/// double. Where all x are −∞ it is NaN, as ONNX's formula is; 0 for Attention, whose rows may be masked.
template <std::floating_point T>
class Softmax : public Operation<T> {
 public:
  /// \param masks  whether shares of nothing are 0
  Softmax(const Operand& x, const AxisRuns& runs, bool is_log, bool masks)
      : Operation<T>({{x.shape, x.type}}), runs_(runs), is_log_(is_log), masks_(masks) {}

  void forward(const ForwardCall<T>& call) const override {
    const T* const x = call.inputs[0].values;
    T* const y = call.outputs[0].values;
    if (runs_.count == 0) return;
    runs_.for_each_group([&](std::size_t place, std::size_t lanes) {
      if (runs_.inner == 1) {
        take_row(x + place, y + place);
      } else {
        take_lanes(x + place, y + place, lanes);
      }
    });
  }

  /// Adjoint: y · (dy − Σ y·dy), and dy − e^y · Σ dy for the logarithm.
  void adjoint(const AdjointCall<T>& call) const override {
    const T *const y = call.outputs[0].values, *const dy = call.output_adjoints[0].values;
    T* const dx = call.input_adjoints[0].values;
    const bool is_uninitialised = call.is_uninitialised[0];
    runs_.for_each_group([&](std::size_t place, std::size_t lanes) {
      if (runs_.inner == 1) {
        pull_row(y + place, dy + place, is_uninitialised, dx + place);
      } else {
        pull_lanes(y + place, dy + place, lanes, is_uninitialised, dx + place);
      }
    });
    call.is_uninitialised[0] = false;
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {0, 1}; }
  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  struct Exponential {
    [[gnu::always_inline]] static T value(T x, T shift) { return tapestry::detail::vector_exp(x - shift); }
  };
  template <class Shift>
  using Exponentials = detail::BinaryBody<Exponential, T, const T*, Shift>;

  [[nodiscard, gnu::always_inline]] static T larger(T best, T value) {
    return value > best || value != value ? value : best;
  }
  /// Whether all x with this largest value are masked.
  [[nodiscard]] bool is_masked(T largest) const {
    return masks_ && largest == -std::numeric_limits<T>::infinity();
  }
  [[nodiscard]] T pulled(T y, T dy, T sum) const { return is_log_ ? dy - std::exp(y) * sum : y * (dy - sum); }

  void take_row(const T* x, T* y) const {
    const std::size_t count = runs_.count;
    const T largest = static_cast<T>(detail::reduce_run<LargestStep>(x, 0, LargestStep::first(), count));
    if (is_masked(largest)) return static_cast<void>(std::fill_n(y, count, T(0)));
    if (is_log_) {
      double sum = 0;
      for (std::size_t i = 0; i < count; ++i) sum += static_cast<double>(std::exp(x[i] - largest));
      const T scale = static_cast<T>(std::log(sum));
      for (std::size_t i = 0; i < count; ++i) y[i] = x[i] - largest - scale;
      return;
    }
    tapestry::detail::for_block<16>(count, Exponentials<T>{x, largest, y});
    const T scale = static_cast<T>(1 / detail::reduce_run<SumStep>(y, 0, 0, count));
    for (std::size_t i = 0; i < count; ++i) y[i] *= scale;
  }

  void take_lanes(const T* x, T* y, std::size_t lanes) const {
    using tapestry::detail::plain_block;
    T largest[detail::lane_block], scale[detail::lane_block];
    double sums[detail::lane_block] = {};
    const std::size_t step = runs_.inner, end = runs_.count * step;
    std::copy_n(x, lanes, largest);
    for (std::size_t i = step; i < end; i += step)
      plain_block<16>(lanes, [&](std::size_t l) { largest[l] = larger(largest[l], x[i + l]); });
    for (std::size_t l = 0; l < lanes; ++l)
      if (is_masked(largest[l])) largest[l] = 0;
    for (std::size_t i = 0; i < end; i += step) {
      if (is_log_) {
        for (std::size_t l = 0; l < lanes; ++l)
          sums[l] += static_cast<double>(std::exp(x[i + l] - largest[l]));
        continue;
      }
      tapestry::detail::for_block<16>(lanes, Exponentials<const T*>{x + i, largest, y + i});
      plain_block<16>(lanes, [&](std::size_t l) { sums[l] += static_cast<double>(y[i + l]); });
    }
    for (std::size_t l = 0; l < lanes; ++l)
      scale[l] = static_cast<T>(is_log_ ? std::log(sums[l]) : masks_ && sums[l] == 0 ? 0 : 1 / sums[l]);
    for (std::size_t i = 0; i < end; i += step)
      if (is_log_) {
        plain_block<16>(lanes, [&](std::size_t l) { y[i + l] = x[i + l] - largest[l] - scale[l]; });
      } else {
        plain_block<16>(lanes, [&](std::size_t l) { y[i + l] *= scale[l]; });
      }
  }

  void pull_row(const T* y, const T* dy, bool is_uninitialised, T* dx) const {
    double parts[16] = {}, sum = 0;
    std::size_t i = 0;
    const auto term = [&](std::size_t k) {
      return static_cast<double>(dy[k]) * (is_log_ ? 1 : static_cast<double>(y[k]));
    };
    for (; i + 16 <= runs_.count; i += 16)
      for (std::size_t k = 0; k < 16; ++k) parts[k] += term(i + k);
    for (const double part : parts) sum += part;
    for (; i < runs_.count; ++i) sum += term(i);
    const T whole = static_cast<T>(sum);
    for (i = 0; i < runs_.count; ++i) dx[i] = pulled(y[i], dy[i], whole) + (is_uninitialised ? T(0) : dx[i]);
  }

  void pull_lanes(const T* y, const T* dy, std::size_t lanes, bool is_uninitialised, T* dx) const {
    double sums[detail::lane_block] = {};
    const std::size_t step = runs_.inner, end = runs_.count * step;
    for (std::size_t i = 0; i < end; i += step)
      for (std::size_t l = 0; l < lanes; ++l)
        sums[l] += static_cast<double>(dy[i + l]) * (is_log_ ? 1 : static_cast<double>(y[i + l]));
    for (std::size_t i = 0; i < end; i += step)
      for (std::size_t l = 0; l < lanes; ++l)
        dx[i + l] =
            pulled(y[i + l], dy[i + l], static_cast<T>(sums[l])) + (is_uninitialised ? T(0) : dx[i + l]);
  }

  AxisRuns runs_;
  bool is_log_, masks_;
};

namespace detail {
/// Attribute of a Softmax within Attention: rows that are −∞ throughout give 0.
inline constexpr const char* masks_rows = "tapestry.masks";

/// Axes of Softmax and the like: one axis from opset 13 on, before that this axis and all behind it.
[[nodiscard]] inline AxisRuns softmax_runs(OperatorContext& context) {
  const Shape& shape = context.input(0).shape;
  const std::size_t rank = shape.size();
  const bool has_one = context.opset() >= 13;
  std::int64_t axis = context.integer("axis", has_one ? -1 : 1);
  std::size_t first = context.axis(axis, rank), last = first + 1;
  if (first >= rank) throw ShapeError("a scalar has no axes");
  if (axis < 0) axis += static_cast<std::int64_t>(rank);
  for (std::int64_t a = axis; !has_one && a < static_cast<std::int64_t>(rank); ++a) {
    first = std::min(first, context.axis(a, rank));
    last = std::max(last, context.axis(a, rank) + 1);
  }
  return AxisRuns(shape, first, last);
}
}  // namespace detail

template <std::floating_point T>
void add_softmax_operators(OperatorTable<T>& table) {
  for (const bool is_log : {false, true}) {
    const auto make = [is_log](OperatorContext& context) {
      const AxisRuns runs = detail::softmax_runs(context);
      const bool masks = !is_log && context.flag(detail::masks_rows, 0);
      return std::make_unique<Softmax<T>>(context.input(0), runs, is_log, masks);
    };
    table[is_log ? "LogSoftmax" : "Softmax"] = {LayoutRule::any, 1, false, {{1, 1}}, make};
  }
}
}  // namespace tapestry::nn
