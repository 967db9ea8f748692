#pragma once
#include <tapestry/nn/detail/network/operators/reshape.hpp>
#include <tapestry/nn/detail/network/operators/softmax.hpp>

namespace tapestry::nn {
/// start + i · step: Range, and with a step of 0 ConstantOfShape.
template <std::floating_point T>
class Ramp : public Operation<T> {
 public:
  Ramp(Shape shape, ElementType type, double start, double step)
      : Operation<T>({{std::move(shape), type}}), start_(start), step_(step) {}

  void forward(const ForwardCall<T>& call) const override {
    for (std::size_t i = 0; i < call.outputs[0].size(); ++i)
      call.outputs[0].values[i] = static_cast<T>(start_ + static_cast<double>(i) * step_);
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  double start_, step_;
};

/// One value where an index along an axis equals the operand, another one elsewhere. Indices out of range
/// give the other value everywhere.
template <std::floating_point T>
class OneHot : public Operation<T> {
 public:
  /// \param runs  of the result along the new axis
  OneHot(Shape shape, ElementType type, const AxisRuns& runs, T off, T on)
      : Operation<T>({{std::move(shape), type}}), runs_(runs), off_(off), on_(on) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const y = call.outputs[0].values;
    std::fill_n(y, call.outputs[0].size(), off_);
    const T* index = call.inputs[0].values;
    for (std::size_t outer = 0; outer < runs_.outer; ++outer)
      for (std::size_t inner = 0; inner < runs_.inner; ++inner, ++index) {
        const std::size_t place = place_of_index(*index, runs_.count);
        if (place < runs_.count) y[(outer * runs_.count + place) * runs_.inner + inner] = on_;
      }
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  AxisRuns runs_;
  T off_, on_;
};

/// A matrix with 1 on one diagonal, of elements [i, i + diagonal], and 0 elsewhere.
template <std::floating_point T>
class Eye : public Operation<T> {
 public:
  Eye(const Shape& shape, ElementType type, std::int64_t diagonal)
      : Operation<T>({{shape, type}}), diagonal_(diagonal) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const y = call.outputs[0].values;
    std::fill_n(y, call.outputs[0].size(), T(0));
    const Shape& shape = this->result_shape();
    const auto columns = static_cast<std::int64_t>(shape[1]);
    for (std::size_t row = 0; row < shape[0]; ++row)
      if (const std::int64_t column = static_cast<std::int64_t>(row) + diagonal_;
          column >= 0 && column < columns)
        y[row * shape[1] + static_cast<std::size_t>(column)] = T(1);
  }
  [[nodiscard]] bool is_differentiable(std::size_t) const override { return false; }

 private:
  std::int64_t diagonal_;
};

/// The part of matrices on one side of a diagonal, and 0 elsewhere.
template <std::floating_point T>
class Trilu : public Operation<T> {
 public:
  /// \param diagonal  of elements [i, i + diagonal]
  Trilu(const Operand& x, std::int64_t diagonal, bool is_upper)
      : Operation<T>({{x.shape, x.type}}), diagonal_(diagonal), is_upper_(is_upper) {}

  void forward(const ForwardCall<T>& call) const override {
    for_each_row(*call.outputs[0].shape, [&](std::size_t row, std::size_t columns, auto range) {
      const T* const from = call.inputs[0].values + row * columns;
      T* const to = call.outputs[0].values + row * columns;
      for (std::size_t i = 0; i < columns; ++i) to[i] = i >= range.begin && i < range.end ? from[i] : T(0);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const dx = call.accumulate(0);
    for_each_row(*call.output_adjoints[0].shape, [&](std::size_t row, std::size_t columns, auto range) {
      for (std::size_t i = range.begin; i < range.end; ++i)
        dx[row * columns + i] += call.output_adjoints[0].values[row * columns + i];
    });
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }
  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  /// Calls body(row, columns, the columns that stay).
  template <class Body>
  void for_each_row(const Shape& shape, const Body& body) const {
    const std::size_t rows = shape[shape.size() - 2], columns = shape.back(), size = size_of(shape);
    for (std::size_t row = 0; row * columns < size; ++row) {
      const auto width = static_cast<std::int64_t>(columns);
      const auto first = static_cast<std::int64_t>(row % rows) + diagonal_;
      const auto begin = is_upper_ ? std::clamp<std::int64_t>(first, 0, width) : 0;
      const auto end = is_upper_ ? width : std::clamp<std::int64_t>(first + 1, 0, width);
      body(row, columns, BlockRange{static_cast<std::size_t>(begin), static_cast<std::size_t>(end)});
    }
  }

  std::int64_t diagonal_;
  bool is_upper_;
};

namespace detail {
/// The value of a constant operand with one element.
[[nodiscard]] inline double scalar_of(const OperatorContext& context, std::size_t input) {
  const Constant& constant = context.constant(input);
  if (constant.size() != 1)
    throw ShapeError({"input ", input, " has ", constant.size(), " elements, expected 1"});
  return constant.at(0);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_constant_of_shape(OperatorContext& context) {
  Shape shape;
  for (const std::int64_t extent : context.integers(std::size_t(0))) shape.push_back(to_extent(extent));
  const Constant* const value = context.tensor("value");
  if (value == nullptr) return std::make_unique<Ramp<T>>(shape, ElementType::floating, 0.0, 0.0);
  if (value->size() != 1) throw ShapeError({"value has ", value->size(), " elements, expected 1"});
  return std::make_unique<Ramp<T>>(shape, value->type, value->at(0), 0.0);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_range(OperatorContext& context) {
  const double start = scalar_of(context, 0), limit = scalar_of(context, 1), delta = scalar_of(context, 2);
  const double count = std::ceil((limit - start) / delta);
  if (!(count <= 2147483647.0))
    throw DomainError({"a range of ", count, " elements, expected at most 2147483647"});
  const auto size = static_cast<std::size_t>(std::max(count, 0.0));
  return std::make_unique<Ramp<T>>(Shape{size}, context.input(0).type, start, delta);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_one_hot(OperatorContext& context) {
  const Operand& indices = context.input(0);
  const Constant& values = context.constant(2);
  if (values.size() != 2) throw ShapeError({"values has ", values.size(), " elements, expected 2"});
  const std::size_t depth = to_extent(OperatorContext::to_integer(scalar_of(context, 1)));
  const std::size_t axis = context.axis(context.integer("axis", -1), indices.shape.size() + 1);
  Shape shape = indices.shape;
  shape.insert(shape.begin() + static_cast<std::ptrdiff_t>(axis), depth);
  const AxisRuns runs(shape, axis, axis + 1);
  return std::make_unique<OneHot<T>>(shape, values.type, runs, static_cast<T>(values.at(0)),
                                     static_cast<T>(values.at(1)));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_eye(OperatorContext& context) {
  const Operand& x = context.input(0);
  if (x.shape.size() != 2) throw ShapeError({x.shape, " is no matrix"});
  const std::int64_t type = context.integer("dtype", 0), diagonal = context.integer("k", 0);
  constexpr std::int64_t most = std::int64_t(1) << 32U;  // further than any matrix reaches
  return std::make_unique<Eye<T>>(x.shape, type == 0 ? x.type : meaning_of(type),
                                  std::clamp(diagonal, -most, most));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_triangle(OperatorContext& context) {
  const Operand& x = context.input(0);
  if (x.shape.size() < 2) throw ShapeError({x.shape, " is no matrix"});
  const double diagonal = context.has_input(1) ? scalar_of(context, 1) : 0;
  return std::make_unique<Trilu<T>>(x, OperatorContext::to_integer(diagonal), context.flag("upper", 1));
}
}  // namespace detail

template <std::floating_point T>
void add_generators(OperatorTable<T>& table) {
  table["ConstantOfShape"] = {LayoutRule::plain, 0, false, {{1, 1}}, detail::make_constant_of_shape<T>};
  table["Range"] = {LayoutRule::plain, 0, false, {{3, 3}}, detail::make_range<T>};
  table["OneHot"] = {LayoutRule::plain, 1, false, {{3, 3}}, detail::make_one_hot<T>};
  table["EyeLike"] = {LayoutRule::plain, 1, false, {{1, 1}}, detail::make_eye<T>};
  table["Trilu"] = {LayoutRule::plain, 1, false, {{1, 2}}, detail::make_triangle<T>};
}
}  // namespace tapestry::nn
