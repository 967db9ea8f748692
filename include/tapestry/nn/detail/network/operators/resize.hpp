#pragma once
#include <tapestry/nn/detail/layout.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/resize_attributes.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
namespace detail {
/// to[i] += weight · from[i], or = where it is fresh
template <bool Adds, std::floating_point T>
void add_weighted(const T* from, T weight, T* to, std::size_t count) {
  struct Body {
    const T* from;
    T weight;
    T* to;
    [[gnu::always_inline]] void operator()(std::size_t i) const {
      to[i] = Adds ? to[i] + weight * from[i] : weight * from[i];
    }
  };
  tapestry::detail::for_block(count, Body{from, weight, to});
}
}  // namespace detail

/// Resize and Upsample, one axis after the other.
template <std::floating_point T>
class Resize : public Operation<T> {
 public:
  /// \param tables  of the axes that change, in the order of resizing
  /// \param extrapolation  the value of outputs that lie outside the tensor
  Resize(Shape in, Shape out, ElementType type, std::vector<ResizeTable> tables, double extrapolation)
      : Operation<T>({{std::move(out), type}}),
        in_(std::move(in)),
        tables_(std::move(tables)),
        extrapolation_(static_cast<T>(extrapolation)) {
    if (in_.size() == 4 && tables_.size() == 2 && tables_[0].axis == 2 && tables_[1].axis == 1 &&
        tables_[0].repeat() == tables_[1].repeat())
      repeat_ = tables_[0].repeat();
  }

  [[nodiscard]] std::optional<MapWindow> window_reached(Engine, std::span<const MapWindow> changed,
                                                        bool) const override {
    if (repeat_ == 0) return std::nullopt;
    return pixels_of_blocks(changed[0], repeat_, repeat_);
  }
  [[nodiscard]] MapWindow window_read(Engine, std::size_t, const MapWindow& computed) const override {
    return blocks_of_pixels(computed, repeat_, repeat_);
  }

  void forward(const ForwardCall<T>& call) const override {
    const T* from = call.inputs[0].values;
    T* const out = call.outputs[0].values;
    if (tables_.empty()) return copy(from, out, size_of(in_));
    if (repeat_ != 0) return upsample(in_[0], in_[1], in_[2], in_[3], repeat_, from, out);
    Shape shape = in_;
    Buffer<T>* const between = scratch();
    for (std::size_t k = 0; k < tables_.size(); ++k) {
      const std::size_t count = size_of(shape) / tables_[k].input * tables_[k].output;
      if (k + 1 < tables_.size()) between[k % 2].resize(count);
      T* const to = k + 1 == tables_.size() ? out : between[k % 2].data();
      resize_axis(tables_[k], shape, from, to);
      shape[tables_[k].axis] = tables_[k].output;
      from = to;
    }
    fill_outside(out);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* from = call.output_adjoints[0].values;
    T* const in_adjoint = call.accumulate(0);
    if (tables_.empty()) return add(from, in_adjoint, size_of(in_));
    if (repeat_ != 0) return upsample_adjoint(in_[0], in_[1], in_[2], in_[3], repeat_, from, in_adjoint);
    Shape shape = this->result_shape();
    Buffer<T>* const between = scratch();
    for (std::size_t k = tables_.size(); k-- > 0;) {
      shape[tables_[k].axis] = tables_[k].input;
      if (k > 0) {
        between[k % 2].resize(size_of(shape));
        between[k % 2].fill_zero();
      }
      T* const to = k == 0 ? in_adjoint : between[k % 2].data();
      resize_axis_adjoint(tables_[k], shape, from, to);
      from = to;
    }
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  /// The two scratch tensors of this thread.
  static Buffer<T>* scratch() {
    static thread_local Buffer<T> buffers[2];
    return buffers;
  }
  static std::size_t inner_of(const Shape& shape, std::size_t axis) {
    std::size_t inner = 1;
    for (std::size_t i = axis + 1; i < shape.size(); ++i) inner *= shape[i];
    return inner;
  }

  static void resize_axis(const ResizeTable& table, const Shape& shape, const T* in, T* out) {
    const std::size_t inner = inner_of(shape, table.axis);
    const std::size_t rows = size_of(shape) / inner / table.input * table.output;
    const std::size_t at_once = std::max<std::size_t>(1, 16384 / inner);
    parallel_for_blocks(rows, at_once, [&](std::size_t begin, std::size_t end) {
      for (std::size_t row = begin; row < end; ++row) {
        const std::size_t i = row % table.output * table.taps;
        const T* const from = in + row / table.output * table.input * inner;
        T* const to = out + row * inner;
        if (table.taps == 1 && table.weight[i] == 1) {
          std::memcpy(to, from + table.index[i] * inner, inner * sizeof(T));
          continue;
        }
        for (std::size_t t = 0; t < table.taps; ++t) {
          const auto put = t == 0 ? detail::add_weighted<false, T> : detail::add_weighted<true, T>;
          put(from + table.index[i + t] * inner, static_cast<T>(table.weight[i + t]), to, inner);
        }
      }
    });
  }

  /// \param shape  before the axis was resized
  static void resize_axis_adjoint(const ResizeTable& table, const Shape& shape, const T* out_adjoint,
                                  T* in_adjoint) {
    const std::size_t inner = inner_of(shape, table.axis);
    const std::size_t outer = size_of(shape) / inner / table.input;
    constexpr std::size_t slice = 1024;  // of the inner values, which are independent
    const std::size_t slices = block_count(inner, slice);
    parallel_for(outer * slices, [&](std::size_t task) {
      const BlockRange range = block_range(task % slices, inner, slice);
      const T* const from = out_adjoint + task / slices * table.output * inner + range.begin;
      T* const to = in_adjoint + task / slices * table.input * inner + range.begin;
      for (std::size_t i = 0; i < table.output * table.taps; ++i)
        if (table.weight[i] != 0)
          detail::add_weighted<true>(from + i / table.taps * inner, static_cast<T>(table.weight[i]),
                                     to + table.index[i] * inner, range.end - range.begin);
    });
  }

  void fill_outside(T* out) const {
    const Shape& shape = this->result_shape();
    for (const ResizeTable& table : tables_) {
      const std::size_t inner = inner_of(shape, table.axis);
      for (std::size_t row = 0; row < size_of(shape) / inner; ++row)
        if (table.is_outside[row % table.output]) std::fill_n(out + row * inner, inner, extrapolation_);
    }
  }

  Shape in_;
  std::vector<ResizeTable> tables_;
  T extrapolation_;
  std::size_t repeat_ = 0;  ///< repeats of each row and column, if that is all; else 0
};

template <std::floating_point T>
void add_resize(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    ResizeAttributes attributes = resize_attributes(context);
    const Operand& x = context.input(0);
    Shape out = x.shape;
    std::vector<ResizeTable> tables;
    for (std::size_t axis = x.shape.size(); axis-- > 0;) {  // last axis first keeps tensors small
      for (const ResizeAxis& one : attributes.axes)
        if (one.axis == axis) tables.push_back(resize_table(attributes.rule, one));
      if (!tables.empty() && tables.back().axis == axis) out[axis] = tables.back().output;
      if (!tables.empty() && tables.back().axis == axis && tables.back().is_identity()) tables.pop_back();
    }
    return std::make_unique<Resize<T>>(x.shape, std::move(out), x.type, std::move(tables),
                                       attributes.extrapolation);
  };
  table["Resize"] = {LayoutRule::channels_last, 1, false, {{2, 2}, {1, 4, 11}}, make};
  table["Upsample"] = {LayoutRule::channels_last, 1, false, {{1, 1}, {2, 2, 9}}, make};
}
}  // namespace tapestry::nn
