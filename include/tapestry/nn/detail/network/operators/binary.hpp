#pragma once
#include <tapestry/nn/detail/network/broadcast.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/operators/binary_functions.hpp>

namespace tapestry::nn {
/// Loops of a function of two numbers, see binary_functions.hpp. Each operand is an array or one repeated
/// number.
template <std::floating_point T>
struct BinaryLoops {
  using Loop = void (*)(const T* a, const T* b, T* y, std::size_t count, bool a_moves, bool b_moves);
  /// to[i] = dy[i] · derivative; `to` may be dy.
  using Partial = void (*)(const T* a, const T* b, const T* dy, T* to, std::size_t count, bool a_moves,
                           bool b_moves);
  Loop forward = nullptr;
  Partial partial[2] = {nullptr, nullptr};  ///< null where the derivative is `constant`
  T constant[2] = {0, 0};                   ///< if 0, and `partial` is null, there is no derivative
};

namespace detail {
/// y[i] = F(a[i], b[i]), where either operand may be one number.
template <class F, std::floating_point T, class A, class B>
struct BinaryBody {
  A a;
  B b;
  T* y;
  [[gnu::always_inline]] static T at(T one, std::size_t) { return one; }
  [[gnu::always_inline]] static T at(const T* values, std::size_t i) { return values[i]; }
  [[gnu::always_inline]] void operator()(std::size_t i) const { y[i] = F::value(at(a, i), at(b, i)); }
};

template <class F, std::floating_point T>
void binary_forward(const T* a, const T* b, T* y, std::size_t count, bool a_moves, bool b_moves) {
  if constexpr (F::is_vector) {
    using tapestry::detail::for_block;
    using Array = const T*;
    if (a_moves && b_moves) return for_block<16>(count, BinaryBody<F, T, Array, Array>{a, b, y});
    if (a_moves) return for_block<16>(count, BinaryBody<F, T, Array, T>{a, *b, y});
    if (b_moves) return for_block<16>(count, BinaryBody<F, T, T, Array>{*a, b, y});
  }
  for (std::size_t i = 0; i < count; ++i) y[i] = F::value(a[a_moves ? i : 0], b[b_moves ? i : 0]);
}

template <class F, int Operand, std::floating_point T>
void binary_partial(const T* a, const T* b, const T* dy, T* to, std::size_t count, bool a_moves,
                    bool b_moves) {
  for (std::size_t i = 0; i < count; ++i) {
    const T x = a[a_moves ? i : 0], z = b[b_moves ? i : 0];
    to[i] = dy[i] * (Operand == 0 ? F::by_a(x, z) : F::by_b(x, z));
  }
}

template <int Operand, std::floating_point T>
void product_partial(const T* a, const T* b, const T* dy, T* to, std::size_t count, bool a_moves,
                     bool b_moves) {
  binary_forward<binary::Mul<T>>(dy, Operand == 0 ? b : a, to, count, true, Operand == 0 ? b_moves : a_moves);
}

template <class F, std::floating_point T>
[[nodiscard]] BinaryLoops<T> binary_loops() {
  BinaryLoops<T> loops;
  loops.forward = &binary_forward<F, T>;
  if constexpr (std::same_as<F, binary::Add<T>> || std::same_as<F, binary::Sub<T>>) {
    loops.constant[0] = 1;
    loops.constant[1] = std::same_as<F, binary::Add<T>> ? T(1) : T(-1);
  } else if constexpr (std::same_as<F, binary::Mul<T>>) {
    loops.partial[0] = &product_partial<0, T>;
    loops.partial[1] = &product_partial<1, T>;
  } else if constexpr (F::has_derivative) {
    loops.partial[0] = &binary_partial<F, 0, T>;
    loops.partial[1] = &binary_partial<F, 1, T>;
  }
  return loops;
}
}  // namespace detail

/// A function of each element of two operands, which are repeated to a common shape.
template <std::floating_point T>
class BinaryOperation : public Operation<T> {
 public:
  BinaryOperation(const Operand& a, const Operand& b, ElementType type, const BinaryLoops<T>& loops,
                  bool b_is_weight)
      : Operation<T>({{broadcast_shape(a.shape, b.shape), type}}),
        loops_(loops),
        nest_(broadcast_nest<2>(this->result_shape(), {&a.shape, &b.shape})),
        operands_{{a.shape, this->result_shape()}, {b.shape, this->result_shape()}},
        b_is_weight_(b_is_weight) {
    const auto is_map = [&](const Operand& one) {
      return one.constant != nullptr || one.shape == this->result_shape();
    };
    if (is_map(a) && is_map(b)) this->set_pixelwise();
  }

  void forward(const ForwardCall<T>& call) const override {
    const T *const a = call.inputs[0].values, *const b = call.inputs[1].values;
    T* const y = call.outputs[0].values;
    const bool a_moves = nest_.loops.back().strides[1] != 0, b_moves = nest_.loops.back().strides[2] != 0;
    parallel_for_each_run(nest_, [&](const auto& at, std::size_t count) {
      loops_.forward(a + at[1], b + at[2], y + at[0], count, a_moves, b_moves);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    for (std::size_t i = 0; i < 2; ++i) {
      if (!call.wants(i)) continue;
      T* const dy = call.output_adjoints[0].values;
      if (loops_.partial[i] == nullptr) {
        operands_[i].pull_back(dy, loops_.constant[i], call, i);
        continue;
      }
      const bool is_last = i == 1 || !call.wants(1);  // later calls do not read dy
      const bool is_direct = operands_[i].is_whole && call.is_uninitialised[i];
      if (!is_direct && !is_last) call.state.values.resize(call.output_adjoints[0].size());
      T* const to = is_direct ? call.input_adjoints[i].values : is_last ? dy : call.state.values.data();
      partial(i, call, to);
      if (!is_direct) operands_[i].pull_back(to, T(1), call, i);
      call.is_uninitialised[i] = false;
    }
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return {loops_.partial[0] == nullptr ? 0U : 3U, 0};
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override {
    return loops_.partial[input] != nullptr || loops_.constant[input] != 0;
  }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return b_is_weight_ && input == 1; }
  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  void partial(std::size_t i, const AdjointCall<T>& call, T* to) const {
    const T *const a = call.inputs[0].values, *const b = call.inputs[1].values;
    const T* const dy = call.output_adjoints[0].values;
    const bool a_moves = nest_.loops.back().strides[1] != 0, b_moves = nest_.loops.back().strides[2] != 0;
    parallel_for_each_run(nest_, [&](const auto& at, std::size_t count) {
      loops_.partial[i](a + at[1], b + at[2], dy + at[0], to + at[0], count, a_moves, b_moves);
    });
  }

  BinaryLoops<T> loops_;
  LoopNest<3> nest_;
  BroadcastOperand operands_[2];
  bool b_is_weight_;
};

namespace detail {
enum class BinaryKind { arithmetic, mixed, test, weighted };  ///< mixed: of operands of any types

/// \param integers  where the first operand holds integers
template <std::floating_point T>
[[nodiscard]] Operator<T> binary_operator(BinaryKind kind, const BinaryLoops<T>& loops,
                                          const BinaryLoops<T>& integers) {
  const auto make = [kind, loops, integers](OperatorContext& context) -> std::unique_ptr<Operation<T>> {
    const Operand &a = context.input(0), &b = context.input(1);
    const bool is_discrete = a.type == ElementType::integer;
    const bool is_weighted = kind == BinaryKind::weighted;
    if (kind != BinaryKind::mixed) context.require_type(1, a.type);
    if (is_weighted && broadcast_shape(a.shape, b.shape) != a.shape)
      throw ShapeError({"the slope is ", b.shape, ", expected what goes with ", a.shape});
    return std::make_unique<BinaryOperation<T>>(a, b,
                                                kind == BinaryKind::test ? ElementType::boolean : a.type,
                                                is_discrete ? integers : loops, is_weighted);
  };
  return {LayoutRule::any, all_inputs, true, {{2, 2}}, make};
}

template <class F, std::floating_point T>
void add_binary(OperatorTable<T>& table, const char* name, BinaryKind kind) {
  table[name] = binary_operator(kind, binary_loops<F, T>(), binary_loops<F, T>());
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_mod(OperatorContext& context) {
  const Operand &a = context.input(0), &b = context.input(1);
  const bool has_sign_of_first = context.flag("fmod", 0);
  if (!has_sign_of_first && a.type == ElementType::floating)
    throw DomainError("fmod is 0, expected 1 for numbers that are not integers");
  const auto loops =
      has_sign_of_first ? binary_loops<binary::Fmod<T>, T>() : binary_loops<binary::IntegerMod<T>, T>();
  return std::make_unique<BinaryOperation<T>>(a, b, a.type, loops, false);
}
}  // namespace detail

template <std::floating_point T>
void add_binary_operators(OperatorTable<T>& table) {
  using detail::add_binary, detail::binary_loops, detail::binary_operator;
  using Kind = detail::BinaryKind;
  add_binary<binary::Add<T>>(table, "Add", Kind::arithmetic);
  add_binary<binary::Sub<T>>(table, "Sub", Kind::arithmetic);
  add_binary<binary::Mul<T>>(table, "Mul", Kind::arithmetic);
  table["Div"] = binary_operator(Kind::arithmetic, binary_loops<binary::Div<T>, T>(),
                                 binary_loops<binary::IntegerDiv<T>, T>());
  table["Pow"] = binary_operator(Kind::mixed, binary_loops<binary::Pow<T>, T>(),
                                 binary_loops<binary::IntegerPow<T>, T>());
  table["Mod"] = {LayoutRule::any, all_inputs, true, {{2, 2}}, detail::make_mod<T>};
  add_binary<binary::PRelu<T>>(table, "PRelu", Kind::weighted);
  add_binary<binary::Test<T, std::equal_to>>(table, "Equal", Kind::test);
  add_binary<binary::Test<T, std::greater>>(table, "Greater", Kind::test);
  add_binary<binary::Test<T, std::greater_equal>>(table, "GreaterOrEqual", Kind::test);
  add_binary<binary::Test<T, std::less>>(table, "Less", Kind::test);
  add_binary<binary::Test<T, std::less_equal>>(table, "LessOrEqual", Kind::test);
  add_binary<binary::Test<T, std::logical_and>>(table, "And", Kind::test);
  add_binary<binary::Test<T, std::logical_or>>(table, "Or", Kind::test);
  add_binary<binary::Xor<T>>(table, "Xor", Kind::test);
}
}  // namespace tapestry::nn
