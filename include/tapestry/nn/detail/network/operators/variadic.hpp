#pragma once
#include <tapestry/nn/detail/network/operators/binary.hpp>

namespace tapestry::nn {
/// An operation on any number of operands, each repeated to the common shape.
template <std::floating_point T>
class Variadic : public Operation<T> {
 public:
  explicit Variadic(const std::vector<Operand>& operands)
      : Operation<T>({{common_shape(operands), operands.front().type}}) {
    for (const Operand& operand : operands) {
      nests_.push_back(broadcast_nest<1>(this->result_shape(), {&operand.shape}));
      operands_.emplace_back(operand.shape, this->result_shape());
    }
  }

 protected:
  /// Calls body(values of the operand, place in the result, count, whether the operand moves).
  template <class Body>
  void for_each_run_of(std::size_t i, const T* operand, const Body& body) const {
    const bool moves = nests_[i].loops.back().strides[1] != 0;
    parallel_for_each_run(
        nests_[i], [&](const auto& at, std::size_t count) { body(operand + at[1], at[0], count, moves); });
  }
  [[nodiscard]] const LoopNest<2>& nest(std::size_t i) const { return nests_[i]; }
  [[nodiscard]] const BroadcastOperand& operand(std::size_t i) const { return operands_[i]; }

 private:
  [[nodiscard]] static Shape common_shape(const std::vector<Operand>& operands) {
    Shape shape;
    for (const Operand& operand : operands) shape = broadcast_shape(shape, operand.shape);
    return shape;
  }

  std::vector<LoopNest<2>> nests_;
  std::vector<BroadcastOperand> operands_;
};

/// Sum and Mean.
template <std::floating_point T>
class SumOf : public Variadic<T> {
 public:
  /// \param scale  of the sum
  SumOf(const std::vector<Operand>& operands, T scale) : Variadic<T>(operands), scale_(scale) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const y = call.outputs[0].values;
    if (call.inputs[0].values != y) repeat(this->nest(0), call.inputs[0].values, y);
    for (std::size_t i = 1; i < call.inputs.size(); ++i)
      this->for_each_run_of(i, call.inputs[i].values,
                            [&](const T* x, std::ptrdiff_t at, std::size_t count, bool moves) {
                              detail::binary_forward<binary::Add<T>>(y + at, x, y + at, count, true, moves);
                            });
    if (scale_ == T(1)) return;
    detail::for_each_block(call.outputs[0].size(), [&](std::size_t begin, std::size_t count) {
      detail::binary_forward<binary::Mul<T>>(y + begin, &scale_, y + begin, count, true, false);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    for (std::size_t i = 0; i < call.inputs.size(); ++i)
      if (call.wants(i)) this->operand(i).pull_back(call.output_adjoints[0].values, scale_, call, i);
  }

  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  T scale_;
};

/// Max and Min of each element. The first of equal operands gets the whole adjoint; NaN comes before
/// everything.
template <std::floating_point T>
class ExtremeOf : public Variadic<T> {
 public:
  ExtremeOf(const std::vector<Operand>& operands, bool is_largest)
      : Variadic<T>(operands), is_largest_(is_largest) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const y = call.outputs[0].values;
    const std::size_t size = call.outputs[0].size();
    if (call.inputs[0].values != y) repeat(this->nest(0), call.inputs[0].values, y);
    if (call.keeps) {
      call.state.choices.resize(size);
      std::fill_n(call.state.choices.data(), size, ElementIndex<T>(0));
    }
    ElementIndex<T>* const choices = call.keeps ? call.state.choices.data() : nullptr;
    for (std::size_t i = 1; i < call.inputs.size(); ++i)
      this->for_each_run_of(i, call.inputs[i].values,
                            [&](const T* x, std::ptrdiff_t at, std::size_t count, bool moves) {
                              choose(x, moves, static_cast<ElementIndex<T>>(i), y + at,
                                     choices == nullptr ? nullptr : choices + at, count);
                            });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const dy = call.output_adjoints[0].values;
    const std::size_t size = call.output_adjoints[0].size();
    call.state.values.resize(size);
    T* const part = call.state.values.data();
    for (std::size_t i = 0; i < call.inputs.size(); ++i) {
      if (!call.wants(i)) continue;
      const ElementIndex<T>* const choices = call.state.choices.data();
      detail::for_each_block(size, [&](std::size_t begin, std::size_t count) {
        for (std::size_t k = begin; k < begin + count; ++k)
          part[k] = choices[k] == static_cast<ElementIndex<T>>(i) ? dy[k] : T(0);
      });
      this->operand(i).pull_back(part, T(1), call, i);
    }
  }

  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  void choose(const T* x, bool moves, ElementIndex<T> operand, T* y, ElementIndex<T>* choices,
              std::size_t count) const {
    for (std::size_t k = 0; k < count; ++k) {
      const T value = x[moves ? k : 0];
      const bool is_better = (is_largest_ ? value > y[k] : value < y[k]) || (value != value && y[k] == y[k]);
      if (!is_better) continue;
      y[k] = value;
      if (choices != nullptr) choices[k] = operand;
    }
  }

  bool is_largest_;
};

/// condition ? x : y, of each element.
template <std::floating_point T>
class Where : public Operation<T> {
 public:
  Where(const Operand& condition, const Operand& x, const Operand& y)
      : Operation<T>({{broadcast_shape(broadcast_shape(condition.shape, x.shape), y.shape), x.type}}),
        nest_(broadcast_nest<3>(this->result_shape(), {&condition.shape, &x.shape, &y.shape})),
        condition_(broadcast_nest<1>(this->result_shape(), {&condition.shape})),
        operands_{{x.shape, this->result_shape()}, {y.shape, this->result_shape()}} {}

  void forward(const ForwardCall<T>& call) const override {
    const T* values[3];
    for (std::size_t i = 0; i < 3; ++i) values[i] = call.inputs[i].values;
    const auto& steps = nest_.loops.back().strides;
    parallel_for_each_run(nest_, [&](const auto& at, std::size_t count) {
      const T *condition = values[0] + at[1], *x = values[1] + at[2], *y = values[2] + at[3];
      T* const to = call.outputs[0].values + at[0];
      for (std::size_t i = 0; i < count; ++i, condition += steps[1], x += steps[2], y += steps[3])
        to[i] = *condition != 0 ? *x : *y;
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const dy = call.output_adjoints[0].values;
    const T* const condition = call.inputs[0].values;
    call.state.values.resize(call.output_adjoints[0].size());
    T* const part = call.state.values.data();
    const bool moves = condition_.loops.back().strides[1] != 0;
    for (std::size_t i = 1; i < 3; ++i) {
      if (!call.wants(i)) continue;
      parallel_for_each_run(condition_, [&](const auto& at, std::size_t count) {
        for (std::size_t k = 0; k < count; ++k) {
          const bool is_first = condition[at[1] + static_cast<std::ptrdiff_t>(moves ? k : 0)] != 0;
          const auto place = at[0] + static_cast<std::ptrdiff_t>(k);
          part[place] = is_first == (i == 1) ? dy[place] : T(0);
        }
      });
      operands_[i - 1].pull_back(part, T(1), call, i);
    }
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input > 0; }

 private:
  LoopNest<4> nest_;
  LoopNest<2> condition_;
  BroadcastOperand operands_[2];
};

/// Operators of any number of operands, and Where.
template <std::floating_point T>
void add_variadic_operators(OperatorTable<T>& table) {
  const auto require_operands = [](const OperatorContext& context) {
    for (std::size_t i = 0; i < std::max<std::size_t>(context.inputs.size(), 1); ++i)
      static_cast<void>(context.input(i));
  };
  for (const bool is_mean : {false, true}) {
    const auto make = [=](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
      require_operands(context);
      const T scale = is_mean ? 1 / static_cast<T>(context.inputs.size()) : T(1);
      return std::make_unique<SumOf<T>>(context.inputs, scale);
    };
    table[is_mean ? "Mean" : "Sum"] = {LayoutRule::any, all_inputs, true, {{1, all_inputs}}, make};
  }
  for (const bool is_largest : {false, true}) {
    const auto make = [=](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
      require_operands(context);
      return std::make_unique<ExtremeOf<T>>(context.inputs, is_largest);
    };
    table[is_largest ? "Max" : "Min"] = {LayoutRule::any, all_inputs, true, {{1, all_inputs}}, make};
  }
  const auto make_where = [](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
    return std::make_unique<Where<T>>(context.input(0), context.input(1), context.input(2));
  };
  table["Where"] = {LayoutRule::any, all_inputs, true, {{3, 3}}, make_where};
}
}  // namespace tapestry::nn
