#pragma once
#include <tapestry/autodiff/detail/arrays/elementwise.hpp>

namespace tapestry {
namespace detail {
/// c[rows, columns] += a · b[depth, columns], b and c row-major; a(i, k) is at i · row_step + k · depth_step.
template <class T>
struct ProductArguments {
  const T* a;
  std::size_t row_step, depth_step;
  const T* b;
  T* c;
  std::size_t rows, depth, columns;
};

/// Tiles of 4 rows and two vectors of VectorSize bytes stay in registers during the loop over the depth. The
/// last columns, fewer than fill a vector, are copied to a padded buffer. Every sum runs in the order of the
/// depth.
template <class T, std::size_t VectorSize>
class ProductTiles {
  using Vector [[gnu::vector_size(VectorSize), gnu::may_alias, gnu::aligned(alignof(T))]] = T;
  static constexpr std::size_t lanes = VectorSize / sizeof(T), tile_rows = 4;

 public:
  [[gnu::always_inline]] static inline void run(const ProductArguments<T>& p) {
    std::size_t j = 0;
    for (; j + 2 * lanes <= p.columns; j += 2 * lanes)
      run_columns<2>(p, p.b + j, p.columns, p.c + j, p.columns);
    if (j + lanes <= p.columns) {
      run_columns<1>(p, p.b + j, p.columns, p.c + j, p.columns);
      j += lanes;
    }
    if (j < p.columns) run_rest(p, j);
  }

 private:
  [[gnu::always_inline]] static inline void run_rest(const ProductArguments<T>& p, std::size_t first) {
    std::vector<T> copies((p.depth + p.rows) * lanes);
    T *const b = copies.data(), *const c = b + p.depth * lanes;
    const std::size_t count = p.columns - first;
    for (std::size_t k = 0; k < p.depth; ++k)
      for (std::size_t j = 0; j < count; ++j) b[k * lanes + j] = p.b[k * p.columns + first + j];
    for (std::size_t i = 0; i < p.rows; ++i)
      for (std::size_t j = 0; j < count; ++j) c[i * lanes + j] = p.c[i * p.columns + first + j];
    run_columns<1>(p, b, lanes, c, lanes);
    for (std::size_t i = 0; i < p.rows; ++i)
      for (std::size_t j = 0; j < count; ++j) p.c[i * p.columns + first + j] = c[i * lanes + j];
  }

  template <std::size_t Vectors>
  [[gnu::always_inline]] static inline void run_columns(const ProductArguments<T>& p, const T* b,
                                                        std::size_t b_step, T* c, std::size_t c_step) {
    std::size_t i = 0;
    for (; i + tile_rows <= p.rows; i += tile_rows) tile<tile_rows, Vectors>(p, i, b, b_step, c, c_step);
    for (; i < p.rows; ++i) tile<1, Vectors>(p, i, b, b_step, c, c_step);
  }

  template <std::size_t Rows, std::size_t Vectors>
  [[gnu::always_inline]] static inline void tile(const ProductArguments<T>& p, std::size_t i, const T* b,
                                                 std::size_t b_step, T* c, std::size_t c_step) {
    Vector sums[Rows][Vectors];
    c += i * c_step;
#pragma GCC unroll 4
    for (std::size_t r = 0; r < Rows; ++r)
#pragma GCC unroll 2
      for (std::size_t v = 0; v < Vectors; ++v)
        sums[r][v] = *reinterpret_cast<const Vector*>(c + r * c_step + v * lanes);
    const T* a = p.a + i * p.row_step;
    for (std::size_t k = 0; k < p.depth; ++k, a += p.depth_step, b += b_step) {
#pragma GCC unroll 2
      for (std::size_t v = 0; v < Vectors; ++v) {
        const Vector row = *reinterpret_cast<const Vector*>(b + v * lanes);
#pragma GCC unroll 4
        for (std::size_t r = 0; r < Rows; ++r) sums[r][v] += a[r * p.row_step] * row;
      }
    }
#pragma GCC unroll 4
    for (std::size_t r = 0; r < Rows; ++r)
#pragma GCC unroll 2
      for (std::size_t v = 0; v < Vectors; ++v)
        *reinterpret_cast<Vector*>(c + r * c_step + v * lanes) = sums[r][v];
  }
};

/// The same with an instruction set of this processor; see for_block().
template <class T>
void add_product(const ProductArguments<T>& p, InstructionSet set = instruction_set()) {
  const auto run = [&](auto bytes) __attribute__((always_inline)) { ProductTiles<T, bytes()>::run(p); };
  run_with(set, run);
}

/// aᵀ of a[rows, columns], row-major.
template <class T>
[[nodiscard]] std::vector<T> transposed(const T* a, std::size_t rows, std::size_t columns) {
  std::vector<T> turned(rows * columns);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t j = 0; j < columns; ++j) turned[j * rows + i] = a[i * columns + j];
  return turned;
}

/// c[m, n] += a[m, k] · b[k, n]
template <class T>
void add_product(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  add_product<T>({a.data(), a.shape(1), 1, b.data(), c.data(), a.shape(0), a.shape(1), b.shape(1)});
}

/// c[m, n] += a[m, k] · b[n, k]ᵀ
template <class T>
void add_product_transposed(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  const auto turned = transposed(b.data(), b.shape(0), b.shape(1));
  add_product<T>({a.data(), a.shape(1), 1, turned.data(), c.data(), a.shape(0), a.shape(1), b.shape(0)});
}

/// c[m, n] += a[k, m]ᵀ · b[k, n]
template <class T>
void add_transposed_product(const Array<T, 2>& a, const Array<T, 2>& b, Array<T, 2>& c) {
  add_product<T>({a.data(), 1, a.shape(1), b.data(), c.data(), a.shape(1), a.shape(0), b.shape(1)});
}

template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> matmul_of(const ArrayVariable<T, 2>& a, const ArrayVariable<T, 2>& b) {
  require_shape("matmul", "right operand", b.value(), {a.shape()[1], b.shape()[1]});
  Array<T, 2> value = zeros<T, 2>({a.shape()[0], b.shape()[1]});
  add_product(a.value(), b.value(), value);
  const auto pullback = [kept_a = a.shared_value(), kept_b = b.shared_value()](
                            const Array<T, 2>& value_adjoint, Array<T, 2>* a_adjoint,
                            Array<T, 2>* b_adjoint) {
    if (a_adjoint != nullptr) add_product_transposed(value_adjoint, *kept_b, *a_adjoint);
    if (b_adjoint != nullptr) add_transposed_product(*kept_a, value_adjoint, *b_adjoint);
  };
  return record_array(std::move(value), pullback, a, b);
}

template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> affine_of(const ArrayVariable<T, 2>& x, const ArrayVariable<T, 2>& weight,
                                            const ArrayVariable<T, 1>& bias) {
  require_shape("affine", "weight", weight.value(), {weight.shape()[0], x.shape()[1]});
  require_shape("affine", "bias", bias.value(), {weight.shape()[0]});
  Array<T, 2> value({x.shape()[0], weight.shape()[0]});
  for (std::size_t n = 0; n < value.shape(0); ++n)
    for (std::size_t o = 0; o < value.shape(1); ++o) value(n, o) = bias.value()(o);
  add_product_transposed(x.value(), weight.value(), value);
  const auto pullback = [kept_x = x.shared_value(), kept_weight = weight.shared_value()](
                            const Array<T, 2>& value_adjoint, Array<T, 2>* x_adjoint,
                            Array<T, 2>* weight_adjoint, Array<T, 1>* bias_adjoint) {
    if (x_adjoint != nullptr) add_product(value_adjoint, *kept_weight, *x_adjoint);
    if (weight_adjoint != nullptr) add_transposed_product(value_adjoint, *kept_x, *weight_adjoint);
    if (bias_adjoint == nullptr) return;
    for (std::size_t n = 0; n < value_adjoint.shape(0); ++n)
      for (std::size_t o = 0; o < value_adjoint.shape(1); ++o) (*bias_adjoint)(o) += value_adjoint(n, o);
  };
  return record_array(std::move(value), pullback, x, weight, bias);
}

/// Products on tapes of duals, by products of the numbers beneath.
template <DualNumber T>
[[nodiscard]] ArrayVariable<T, 2> matmul_of(const ArrayVariable<T, 2>& a, const ArrayVariable<T, 2>& b) {
  const auto product = []<class A>(const A& x, const A& y, const A& x_tangent, const A& y_tangent) {
    return std::pair(matmul_of(x, y), A(matmul_of(x_tangent, y) + matmul_of(x, y_tangent)));
  };
  return record_tangent(product, a, b);
}
template <DualNumber T>
[[nodiscard]] ArrayVariable<T, 2> affine_of(const ArrayVariable<T, 2>& x, const ArrayVariable<T, 2>& weight,
                                            const ArrayVariable<T, 1>& bias) {
  const auto layer = []<class A, class B>(const A& at, const A& w, const B& b, const A& at_tangent,
                                          const A& w_tangent, const B& b_tangent) {
    const B none(zeros<typename B::value_type, 1>(b.shape()));
    return std::pair(affine_of(at, w, b),
                     A(affine_of(at_tangent, w, b_tangent) + affine_of(at, w_tangent, none)));
  };
  return record_tangent(layer, x, weight, bias);
}
}  // namespace detail

/// a · b of [M, K] and [K, N], giving [M, N]; one is an array variable or a formula, the other may be a plain
/// array. In one thread.
/// \throws ShapeError if the inner extents differ
template <class A, detail::ArrayPair<A> B>
[[nodiscard]] auto matmul(const A& a, const B& b) {
  using T = detail::ArrayScalarType<std::conditional_t<DifferentiableArray<A>, A, B>>;
  return detail::matmul_of<T>(ArrayVariable<T, 2>(a), ArrayVariable<T, 2>(b));
}

/// A layer: row n of the result is weight · x[n] + bias, for x [N, I], weight [O, I], bias [O]. At least one
/// of them is an array variable or a formula.
/// \throws ShapeError if they do not fit
template <class X, class W, class B>
requires(DifferentiableArray<X> || DifferentiableArray<W> || DifferentiableArray<B>)
    [[nodiscard]] auto affine(const X& x, const W& weight, const B& bias) {
  using T = detail::ArrayScalarType<
      std::conditional_t<DifferentiableArray<X>, X, std::conditional_t<DifferentiableArray<W>, W, B>>>;
  return detail::affine_of<T>(ArrayVariable<T, 2>(x), ArrayVariable<T, 2>(weight), ArrayVariable<T, 1>(bias));
}
}  // namespace tapestry
