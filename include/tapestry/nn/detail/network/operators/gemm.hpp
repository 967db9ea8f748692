#pragma once
#include <tapestry/nn/detail/network/operators/matmul.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// alpha · A · B + beta · C of row-major matrices, where A and B may be stored transposed.
struct GemmPlan {
  ProductShape shape{};
  bool turns_a = false, turns_b = false;
  double alpha = 1, beta = 1;
  bool has_c = false;
  std::size_t c_row_step = 0, c_column_step = 0;  ///< 0 along an axis that C is repeated on
  bool is_b_constant = false;

  [[nodiscard]] std::size_t b_row_step() const { return turns_b ? 1 : shape.columns; }
  [[nodiscard]] std::size_t b_column_step() const { return turns_b ? shape.depth : 1; }
};

/// Gemm.
template <std::floating_point T>
class Gemm : public Operation<T> {
 public:
  explicit Gemm(const GemmPlan& plan)
      : Operation<T>({{{plan.shape.rows, plan.shape.columns}, ElementType::floating}}), plan_(plan) {}

  void prepare(std::span<const TensorView<const T>> constants) override {
    if (plan_.is_b_constant) packed_ = pack(constants[1].values);
  }

  void forward(const ForwardCall<T>& call) const override {
    T* const out = call.outputs[0].values;
    Buffer<T> turned;
    const T* const a = rows_of_a(call.inputs[0].values, turned);
    if (plan_.has_c) {
      const T beta = static_cast<T>(plan_.beta);
      for_each_element([&](std::size_t i, std::size_t of_c) { out[i] = beta * call.inputs[2].values[of_c]; });
    }
    if (plan_.is_b_constant) return multiply(a, packed_, plan_.has_c, out);
    multiply(a, pack(call.inputs[1].values), plan_.has_c, out);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const adjoint = call.output_adjoints[0].values;
    if (call.wants(0)) a_adjoint(call, adjoint);
    if (call.wants(1)) {
      Buffer<T> turned;
      multiply_adjoint(plan_.shape, rows_of_a(call.inputs[0].values, turned), adjoint,
                       static_cast<T>(plan_.alpha), plan_.b_row_step(), plan_.b_column_step(),
                       call.accumulate(1));
    }
    if (!call.wants(2)) return;
    const T beta = static_cast<T>(plan_.beta);
    T* const c_adjoint = call.accumulate(2);
    for_each_element([&](std::size_t i, std::size_t of_c) { c_adjoint[of_c] += beta * adjoint[i]; });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return {plan_.is_b_constant ? std::uint64_t(2) : std::uint64_t(3), 0};
  }
  [[nodiscard]] AdjointReads weight_adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_weight(std::size_t) const override { return true; }

 private:
  /// A as it is multiplied.
  /// \param turned  memory for its transpose
  [[nodiscard]] const T* rows_of_a(const T* a, Buffer<T>& turned) const {
    if (!plan_.turns_a) return a;
    turned.resize(plan_.shape.rows * plan_.shape.depth);
    transpose_matrix(a, plan_.shape.depth, plan_.shape.rows, turned.data());
    return turned.data();
  }

  /// alpha · B
  [[nodiscard]] PackedConvolution<T> pack(const T* b) const {
    return packed(plan_.shape, b, plan_.b_row_step(), plan_.b_column_step());
  }

  [[nodiscard]] PackedConvolution<T> packed(const ProductShape& shape, const T* b, std::size_t row_step,
                                            std::size_t column_step) const {
    auto result = pack_matrix(shape, b, row_step, column_step);
    for (std::size_t i = 0; i < result.weights->size() && plan_.alpha != 1; ++i)
      result.weights->data()[i] *= static_cast<T>(plan_.alpha);
    return result;
  }

  template <class Body>
  void for_each_element(Body body) const {
    for (std::size_t m = 0; m < plan_.shape.rows; ++m)
      for (std::size_t n = 0; n < plan_.shape.columns; ++n)
        body(m * plan_.shape.columns + n, m * plan_.c_row_step + n * plan_.c_column_step);
  }

  /// A's adjoint is alpha · Y's · Bᵀ, or the transpose of that.
  void a_adjoint(const AdjointCall<T>& call, const T* adjoint) const {
    const ProductShape& shape = plan_.shape;
    const ProductShape turned{shape.rows, shape.columns, shape.depth};
    const auto b = packed(turned, call.inputs[1].values, plan_.b_column_step(), plan_.b_row_step());
    if (!plan_.turns_a) {
      multiply(adjoint, b, !call.is_uninitialised[0], call.input_adjoints[0].values);
      call.is_uninitialised[0] = false;
      return;
    }
    Buffer<T> product(shape.rows * shape.depth), stored(shape.rows * shape.depth);
    multiply(adjoint, b, false, product.data());
    transpose_matrix(product.data(), shape.rows, shape.depth, stored.data());
    add(stored.data(), call.accumulate(0), stored.size());
  }

  GemmPlan plan_;
  PackedConvolution<T> packed_{};
};

/// \throws ShapeError if the operands do not fit
[[nodiscard]] inline GemmPlan plan_gemm(OperatorContext& context) {
  const Shape &a = context.input(0).shape, &b = context.input(1).shape;
  GemmPlan plan;
  plan.turns_a = context.flag("transA", 0);
  plan.turns_b = context.flag("transB", 0);
  plan.alpha = context.number("alpha", 1);
  plan.beta = context.number("beta", 1);
  const auto refuse = [&] { throw ShapeError({a, " and ", b, " cannot be multiplied"}); };
  if (a.size() != 2 || b.size() != 2) refuse();
  plan.shape = {a[plan.turns_a ? 1 : 0], a[plan.turns_a ? 0 : 1], b[plan.turns_b ? 0 : 1]};
  if (b[plan.turns_b ? 1 : 0] != plan.shape.depth) refuse();
  plan.is_b_constant = context.input(1).constant != nullptr;
  plan.has_c = context.has_input(2) && plan.beta != 0;
  if (!context.has_input(2)) return plan;
  Shape c = context.input(2).shape;
  c.insert(c.begin(), c.size() < 2 ? 2 - c.size() : 0, 1);
  const auto fits = [](std::size_t extent, std::size_t wanted) { return extent == 1 || extent == wanted; };
  if (c.size() != 2 || !fits(c[0], plan.shape.rows) || !fits(c[1], plan.shape.columns))
    throw ShapeError(
        {"C is ", context.input(2).shape, ", which is no [", plan.shape.rows, ", ", plan.shape.columns, "]"});
  plan.c_row_step = c[0] == 1 ? 0 : c[1];
  plan.c_column_step = c[1] == 1 ? 0 : 1;
  return plan;
}

/// Gemm. All its constant operands are weights.
template <std::floating_point T>
void add_gemm(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) { return std::make_unique<Gemm<T>>(plan_gemm(context)); };
  table["Gemm"] = {LayoutRule::plain, 3, false, {{2, 3}}, make};
}
}  // namespace tapestry::nn
