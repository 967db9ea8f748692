#pragma once
#include <tapestry/nn/detail/convolution_weight_adjoint.hpp>
#include <tapestry/nn/detail/network/operators.hpp>

namespace tapestry::nn {
/// Extents of c[rows, columns] = a[rows, depth] · b[depth, columns].
struct ProductShape {
  std::size_t rows = 1, depth = 1, columns = 1;

  /// Whether nothing is multiplied.
  [[nodiscard]] bool is_empty() const { return rows == 0 || depth == 0 || columns == 0; }

  /// The same as a convolution of single pixels.
  [[nodiscard]] ConvolutionShape convolution() const {
    ConvolutionShape shape;
    shape.rows.input = shape.rows.output = rows;
    shape.in_channels = depth;
    shape.out_channels = columns;
    return shape;
  }
};

/// Operand b of a product, packed; b[k, n] is at b[k · row_step + n · column_step].
template <std::floating_point T>
[[nodiscard]] PackedConvolution<T> pack_matrix(const ProductShape& shape, const T* b, std::size_t row_step,
                                               std::size_t column_step) {
  if (shape.is_empty()) return {.shape = shape.convolution()};
  return pack_convolution<T>(shape.convolution(), [&](std::size_t i) {
    return b[i % shape.depth * row_step + i / shape.depth * column_step];
  });
}

/// c (+)= a · b, row-major.
template <std::floating_point T>
void multiply(const T* a, const PackedConvolution<T>& b, bool adds, T* c) {
  if (b.weights->empty()) {  // nothing is multiplied
    if (!adds) std::fill_n(c, b.shape.rows.output * b.shape.out_channels, T(0));
    return;
  }
  Epilogue<T> end{};
  end.adds = adds;
  convolve(b, 1, a, end, c, b.shape.out_size());
}

/// b_adjoint += scale · aᵀ · c_adjoint, where b[k, n] is at b_adjoint[k · row_step + n · column_step].
/// \param a, c_adjoint  readable 128 bytes past their end
template <std::floating_point T>
void multiply_adjoint(const ProductShape& shape, const T* a, const T* c_adjoint, T scale,
                      std::size_t row_step, std::size_t column_step, T* b_adjoint) {
  if (shape.is_empty()) return;
  static thread_local Buffer<T> partial, sum;
  sum.resize(shape.depth * shape.columns);
  sum.fill_zero();
  convolution_weight_adjoint(shape.convolution(), 1, a, c_adjoint, partial, sum.data());
  for (std::size_t n = 0; n < shape.columns; ++n)
    for (std::size_t k = 0; k < shape.depth; ++k)
      b_adjoint[k * row_step + n * column_step] += scale * sum.data()[n * shape.depth + k];
}

/// to[columns, rows] = from[rows, columns]ᵀ
template <std::floating_point T>
void transpose_matrix(const T* from, std::size_t rows, std::size_t columns, T* to) {
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) to[j * rows + i] = from[i * columns + j];
}

/// How the matrices of two stacks are paired, by the rules of NumPy's matmul.
struct MatMulPlan {
  ProductShape product{};
  Shape out{};
  std::vector<std::size_t> a{}, b{};  ///< the matrix of each operand that makes each matrix of the result

  /// Whether all matrices of `a`, in order, are multiplied with one matrix b: then it is one tall product.
  [[nodiscard]] bool shares_b() const {
    if (!std::ranges::all_of(b, [](std::size_t matrix) { return matrix == 0; })) return false;
    for (std::size_t i = 0; i < a.size(); ++i)
      if (a[i] != i) return false;
    return true;
  }
};

/// \throws ShapeError if the extents do not fit
[[nodiscard]] inline MatMulPlan plan_matmul(Shape a, Shape b) {
  const auto refuse = [&] { throw ShapeError({a, " and ", b, " cannot be multiplied"}); };
  if (a.empty() || b.empty()) refuse();
  const bool is_row = a.size() == 1, is_column = b.size() == 1;
  if (is_row) a.insert(a.begin(), 1);
  if (is_column) b.push_back(1);
  MatMulPlan plan;
  plan.product = {a[a.size() - 2], a.back(), b.back()};
  if (b[b.size() - 2] != plan.product.depth) refuse();
  const std::size_t rank = std::max(a.size(), b.size()) - 2;
  const auto stack = [&](const Shape& shape, std::size_t axis) {  // axes counted with leading ones
    const std::size_t own = shape.size() - 2;
    return axis + own < rank ? 1 : shape[axis + own - rank];
  };
  plan.a = plan.b = {0};
  constexpr std::size_t most = std::size_t(1) << 20U;  // matrices
  for (std::size_t axis = 0; axis < rank; ++axis) {
    const std::size_t of_a = stack(a, axis), of_b = stack(b, axis);
    if (of_a != of_b && of_a != 1 && of_b != 1) refuse();
    const std::size_t extent = of_a == 1 ? of_b : of_a;
    if (plan.a.size() * extent > most) throw ShapeError("more than 1048576 matrices are to be multiplied");
    plan.out.push_back(extent);
    std::vector<std::size_t> next_a, next_b;
    for (std::size_t i = 0; i < plan.a.size(); ++i)
      for (std::size_t k = 0; k < extent; ++k) {
        next_a.push_back(plan.a[i] * of_a + (of_a == 1 ? 0 : k));
        next_b.push_back(plan.b[i] * of_b + (of_b == 1 ? 0 : k));
      }
    plan.a = std::move(next_a);
    plan.b = std::move(next_b);
  }
  if (!is_row) plan.out.push_back(plan.product.rows);
  if (!is_column) plan.out.push_back(plan.product.columns);
  if (plan.shares_b()) {
    plan.product.rows *= plan.a.size();
    plan.a = plan.b = {0};
  }
  return plan;
}

/// MatMul.
template <std::floating_point T>
class MatMul : public Operation<T> {
 public:
  MatMul(MatMulPlan plan, bool is_b_constant)
      : Operation<T>({{plan.out, ElementType::floating}}),
        plan_(std::move(plan)),
        is_b_constant_(is_b_constant && plan_.b == std::vector<std::size_t>{0}) {}

  void prepare(std::span<const TensorView<const T>> constants) override {
    if (is_b_constant_) packed_ = pack(constants[1].values);
  }

  void forward(const ForwardCall<T>& call) const override {
    for (std::size_t i = 0; i < plan_.a.size(); ++i) {
      const T* const a = call.inputs[0].values + plan_.a[i] * a_size();
      T* const c = call.outputs[0].values + i * c_size();
      if (is_b_constant_) {
        multiply(a, packed_, false, c);
      } else {
        multiply(a, pack(call.inputs[1].values + plan_.b[i] * b_size()), false, c);
      }
    }
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const ProductShape& shape = plan_.product;
    T* const a_adjoint = call.wants(0) ? call.accumulate(0) : nullptr;
    T* const b_adjoint = call.wants(1) ? call.accumulate(1) : nullptr;
    const ProductShape turned{shape.rows, shape.columns, shape.depth};
    for (std::size_t i = 0; i < plan_.a.size(); ++i) {
      const T* const c_adjoint = call.output_adjoints[0].values + i * c_size();
      const T* const b = call.inputs[1].values + plan_.b[i] * b_size();
      if (a_adjoint != nullptr)
        multiply(c_adjoint, pack_matrix(turned, b, 1, shape.columns), true,
                 a_adjoint + plan_.a[i] * a_size());
      if (b_adjoint != nullptr)
        multiply_adjoint(shape, call.inputs[0].values + plan_.a[i] * a_size(), c_adjoint, T(1), shape.columns,
                         std::size_t(1), b_adjoint + plan_.b[i] * b_size());
    }
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return {is_b_constant_ ? std::uint64_t(2) : std::uint64_t(3), 0};
  }
  [[nodiscard]] AdjointReads weight_adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override { return input < 2; }

 private:
  [[nodiscard]] std::size_t a_size() const { return plan_.product.rows * plan_.product.depth; }
  [[nodiscard]] std::size_t b_size() const { return plan_.product.depth * plan_.product.columns; }
  [[nodiscard]] std::size_t c_size() const { return plan_.product.rows * plan_.product.columns; }
  [[nodiscard]] PackedConvolution<T> pack(const T* b) const {
    return pack_matrix(plan_.product, b, plan_.product.columns, std::size_t(1));
  }

  MatMulPlan plan_;
  bool is_b_constant_;  ///< and a single matrix
  PackedConvolution<T> packed_{};
};

template <std::floating_point T>
void add_matmul(OperatorTable<T>& table) {
  const auto make = [](OperatorContext& context) {
    return std::make_unique<MatMul<T>>(plan_matmul(context.input(0).shape, context.input(1).shape),
                                       context.input(1).constant != nullptr);
  };
  table["MatMul"] = {LayoutRule::plain, 2, false, {{2, 2}}, make};
}
}  // namespace tapestry::nn
