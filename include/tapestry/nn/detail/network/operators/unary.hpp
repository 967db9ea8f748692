#pragma once
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/unary_loops.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// A function of each element.
template <std::floating_point T>
class UnaryOperation : public Operation<T> {
 public:
  UnaryOperation(const Operand& x, ElementType type, const UnaryLoops<T>& loops, T a, T b)
      : Operation<T>({{x.shape, type}}), loops_(loops), a_(a), b_(b) {
    this->set_pixelwise();
  }

  [[nodiscard]] bool has_tangent() const { return loops_.with_tangent != nullptr; }

  void forward(const ForwardCall<T>& call) const override {
    const T* const x = call.inputs[0].values;
    T* const y = call.outputs[0].values;
    detail::for_each_block(call.outputs[0].size(), [&](std::size_t begin, std::size_t count) {
      loops_.forward(x + begin, y + begin, count, a_, b_);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const dy = call.output_adjoints[0].values;  // later calls do not read it
    const T* kept = dy;
    if (loops_.reads == unary::Reads::input) kept = call.inputs[0].values;
    if (loops_.reads == unary::Reads::output) kept = call.outputs[0].values;
    T* const dx = call.input_adjoints[0].values;
    const bool is_uninitialised = call.is_uninitialised[0];
    detail::for_each_block(call.output_adjoints[0].size(), [&](std::size_t begin, std::size_t count) {
      T* const to = (is_uninitialised ? dx : dy) + begin;
      loops_.adjoint(kept + begin, dy + begin, to, count, a_, b_);
      if (!is_uninitialised) kernels<T>().add(to, dx + begin, count);
    });
    call.is_uninitialised[0] = false;
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return {loops_.reads == unary::Reads::input ? 1U : 0U, loops_.reads == unary::Reads::output ? 1U : 0U};
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override {
    return input == 0 && loops_.reads != unary::Reads::no_derivative;
  }
  [[nodiscard]] bool works_in_place() const override { return true; }

 protected:
  UnaryOperation(const UnaryOperation& other, std::vector<typename Operation<T>::Result> results)
      : Operation<T>(std::move(results)), loops_(other.loops_), a_(other.a_), b_(other.b_) {
    this->set_pixelwise();
  }

  UnaryLoops<T> loops_;
  T a_, b_;
};

/// Relu and LeakyRelu, whose adjoints need only one bit for each element.
template <std::floating_point T>
class Rectifier : public Operation<T> {
 public:
  /// \param slope  at and below 0
  Rectifier(const Operand& x, T slope) : Operation<T>({{x.shape, x.type}}), slope_(slope) {
    this->set_pixelwise();
  }

  void forward(const ForwardCall<T>& call) const override {
    const std::size_t size = call.outputs[0].size();
    if (call.keeps) call.state.bits.resize((size + 7) / 8);
    detail::for_each_block(size, [&](std::size_t begin, std::size_t count) {
      const T* const x = call.inputs[0].values + begin;
      T* const y = call.outputs[0].values + begin;
      if (slope_ == 0) {
        if (call.keeps) kernels<T>().positive_bits(x, call.state.bits.data() + begin / 8, count);
        return detail::unary_forward<unary::Relu<T>>(x, y, count, slope_, slope_);
      }
      static thread_local Buffer<std::uint8_t> own;
      if (!call.keeps) own.resize((count + 7) / 8);
      std::uint8_t* const bits = call.keeps ? call.state.bits.data() + begin / 8 : own.data();
      kernels<T>().positive_bits(x, bits, count);
      kernels<T>().leaky_adjoint(bits, slope_, x, y, count);  // x times its slope is the value
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const dy = call.output_adjoints[0].values;  // later calls do not read it
    T* const dx = call.input_adjoints[0].values;
    const bool is_uninitialised = call.is_uninitialised[0];
    detail::for_each_block(call.output_adjoints[0].size(), [&](std::size_t begin, std::size_t count) {
      T* const to = (is_uninitialised ? dx : dy) + begin;
      kernels<T>().leaky_adjoint(call.state.bits.data() + begin / 8, slope_, dy + begin, to, count);
      if (!is_uninitialised) kernels<T>().add(to, dx + begin, count);
    });
    call.is_uninitialised[0] = false;
  }

  void apply_choice(const OperationState<T>& state, const T* from, T* to) const override {
    leaky_adjoint(state.bits.data(), slope_, from, to, size_of(this->result_shape()));
  }

  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  T slope_;
};

namespace detail {
struct UnaryParameter {
  const char* name = nullptr;  ///< the attribute's name, or null
  double otherwise = 0;
};

template <std::floating_point T>
[[nodiscard]] Operator<T> unary_operator(const UnaryLoops<T>& loops, UnaryParameter a, UnaryParameter b) {
  const auto make = [loops, a, b](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
    const auto value = [&](const UnaryParameter& from) {
      return static_cast<T>(from.name == nullptr ? from.otherwise
                                                 : context.number(from.name, from.otherwise));
    };
    const Operand& x = context.input(0);
    return std::make_unique<UnaryOperation<T>>(x, loops.is_test ? ElementType::boolean : x.type, loops,
                                               value(a), value(b));
  };
  return {LayoutRule::any, 1, false, {{1, 1}}, make};
}

template <class F, std::floating_point T>
void add_unary(OperatorTable<T>& table, const char* name, UnaryParameter a = {}, UnaryParameter b = {}) {
  table[name] = unary_operator(unary_loops<F, T>(), a, b);
}

/// Bounds of Clip: attributes up to opset 10, then operands, which must be constant.
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_clip(OperatorContext& context) {
  T bounds[] = {std::numeric_limits<T>::lowest(), std::numeric_limits<T>::max()};
  const char* const names[] = {"min", "max"};
  for (std::size_t i = 0; i < 2; ++i) {
    if (context.opset() < 11) {
      if (context.has_attribute(names[i])) bounds[i] = static_cast<T>(context.number(names[i], 0));
    } else if (context.has_input(i + 1)) {
      if (context.constant(i + 1).size() != 1)
        throw ShapeError({names[i], " has ", context.constant(i + 1).size(), " elements, expected 1"});
      bounds[i] = static_cast<T>(context.constant(i + 1).at(0));
    }
  }
  const Operand& x = context.input(0);
  return std::make_unique<UnaryOperation<T>>(x, x.type, unary_loops<unary::Clip<T>, T>(), bounds[0],
                                             bounds[1]);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_is_inf(OperatorContext& context) {
  const T below = context.flag("detect_negative", 1) ? T(1) : T(0);
  const T above = context.flag("detect_positive", 1) ? T(1) : T(0);
  return std::make_unique<UnaryOperation<T>>(context.input(0), ElementType::boolean,
                                             unary_loops<unary::IsInf<T>, T>(), below, above);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_gelu(OperatorContext& context) {
  const std::string approximation = context.text("approximate", "none");
  if (approximation != "none" && approximation != "tanh")
    throw DomainError({"approximate is ", in_quotes(approximation), ", expected 'none' or 'tanh'"});
  const Operand& x = context.input(0);
  const auto loops =
      approximation == "none" ? unary_loops<unary::Gelu<T>, T>() : unary_loops<unary::GeluTanh<T>, T>();
  return std::make_unique<UnaryOperation<T>>(x, x.type, loops, T(0), T(0));
}

/// Functions of mathematics.
template <std::floating_point T>
void add_elementary_operators(OperatorTable<T>& table) {
  add_unary<unary::Erf<T>>(table, "Erf");
  add_unary<unary::Exp<T>>(table, "Exp");
  add_unary<unary::OfTape<T, tapestry::detail::Log>>(table, "Log");
  add_unary<unary::OfTape<T, tapestry::detail::Sqrt, unary::Reads::output>>(table, "Sqrt");
  add_unary<unary::Reciprocal<T>>(table, "Reciprocal");
  add_unary<unary::Abs<T>>(table, "Abs");
  add_unary<unary::Neg<T>>(table, "Neg");
  add_unary<unary::OfTape<T, tapestry::detail::Sin>>(table, "Sin");
  add_unary<unary::OfTape<T, tapestry::detail::Cos>>(table, "Cos");
  add_unary<unary::OfTape<T, tapestry::detail::Tan, unary::Reads::output>>(table, "Tan");
  add_unary<unary::OfTape<T, tapestry::detail::Asin>>(table, "Asin");
  add_unary<unary::OfTape<T, tapestry::detail::Acos>>(table, "Acos");
  add_unary<unary::Atan<T>>(table, "Atan");
  add_unary<unary::OfTape<T, tapestry::detail::Sinh>>(table, "Sinh");
  add_unary<unary::OfTape<T, tapestry::detail::Cosh>>(table, "Cosh");
  add_unary<unary::OfTape<T, tapestry::detail::Asinh>>(table, "Asinh");
  add_unary<unary::OfTape<T, tapestry::detail::Acosh>>(table, "Acosh");
  add_unary<unary::OfTape<T, tapestry::detail::Atanh>>(table, "Atanh");
  add_unary<unary::Floor<T>>(table, "Floor");
  add_unary<unary::Ceil<T>>(table, "Ceil");
  add_unary<unary::Round<T>>(table, "Round");
  add_unary<unary::StraightRound<T>>(table, "StraightRound");
  add_unary<unary::Sign<T>>(table, "Sign");
}
}  // namespace detail

/// Functions of each element alone. "Swish" is Tapestry's name for x · σ(x), and StraightRound is its own,
/// too; ONNX has neither.
template <std::floating_point T>
void add_unary_operators(OperatorTable<T>& table) {
  using detail::add_unary;
  const auto rectifier = [](double otherwise, const char* name) {
    return [otherwise, name](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
      const double slope = name == nullptr ? otherwise : context.number(name, otherwise);
      return std::make_unique<Rectifier<T>>(context.input(0), static_cast<T>(slope));
    };
  };
  table["Relu"] = {LayoutRule::any, 1, false, {{1, 1}}, rectifier(0, nullptr)};
  table["LeakyRelu"] = {LayoutRule::any, 1, false, {{1, 1}}, rectifier(0.01, "alpha")};
  table["Clip"] = {LayoutRule::any, 1, false, {{1, 1}, {1, 3, 11}}, detail::make_clip<T>};
  table["Gelu"] = {LayoutRule::any, 1, false, {{1, 1}}, detail::make_gelu<T>};
  add_unary<unary::Sigmoid<T>>(table, "Sigmoid");
  add_unary<unary::Swish<T>>(table, "Swish", {"alpha", 1});
  add_unary<unary::HardSigmoid<T>>(table, "HardSigmoid", {"alpha", 0.2}, {"beta", 0.5});
  add_unary<unary::HardSwish<T>>(table, "HardSwish");
  add_unary<unary::HardMish<T>>(table, "HardMish");
  add_unary<unary::Mish<T>>(table, "Mish");
  add_unary<unary::Elu<T>>(table, "Elu", {"alpha", 1});
  add_unary<unary::Selu<T>>(table, "Selu", {"alpha", 1.67326319217681884765625},
                            {"gamma", 1.05070102214813232421875});
  add_unary<unary::Celu<T>>(table, "Celu", {"alpha", 1});
  add_unary<unary::ThresholdedRelu<T>>(table, "ThresholdedRelu", {"alpha", 1});
  add_unary<unary::Softplus<T>>(table, "Softplus");
  add_unary<unary::Softsign<T>>(table, "Softsign");
  add_unary<unary::Tanh<T>>(table, "Tanh");
  add_unary<unary::Shrink<T>>(table, "Shrink", {"lambd", 0.5}, {"bias", 0});
  add_unary<unary::Not<T>>(table, "Not");
  add_unary<unary::IsNan<T>>(table, "IsNaN");
  detail::add_elementary_operators(table);
  table["IsInf"] = {LayoutRule::any, 1, false, {{1, 1}}, detail::make_is_inf<T>};
}
}  // namespace tapestry::nn
