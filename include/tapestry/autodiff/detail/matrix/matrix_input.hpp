#pragma once
#include <tapestry/autodiff/detail/arrays/elementwise.hpp>
#include <tapestry/autodiff/eigen.hpp>

/// Inputs of operations on matrices, whichever way the matrices are held.
namespace tapestry::detail {
/// Numbers in columns, which all decompositions work on.
template <class T>
using DenseMatrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;

template <class X>
concept EigenMatrix = std::derived_from<X, Eigen::MatrixBase<X>>;

template <class X>
struct IsPlainArray : std::false_type {};
template <class T, std::size_t Rank>
struct IsPlainArray<Array<T, Rank>> : std::bool_constant<Rank == 1 || Rank == 2> {};

/// The scalar type of a matrix of variables; void for a plain one.
template <class X>
struct MatrixScalarOf {
  using type = void;
};
template <EigenMatrix X>
requires ScalarExpression<typename X::Scalar>
struct MatrixScalarOf<X> {
  using type = typename X::Scalar::ExpressionScalar;
};
template <DifferentiableArray X>
requires(X::rank == 1 || X::rank == 2) struct MatrixScalarOf<X> {
  using type = ArrayScalarType<X>;
};

template <class X>
concept MatrixOfVariables = !std::is_void_v<typename MatrixScalarOf<X>::type>;

/// The scalar type of the first that holds variables.
template <class A, class B = A>
using MatrixScalar = typename MatrixScalarOf<std::conditional_t<MatrixOfVariables<A>, A, B>>::type;

template <class X>
concept MatrixOfFloats = std::floating_point<MatrixScalar<X>>;
template <class X>
concept AnyMatrix = EigenMatrix<X> || MatrixOfVariables<X> || IsPlainArray<X>::value;
/// A second matrix beside A; one of them may be plain.
template <class B, class A>
concept MatrixBeside = AnyMatrix<B> &&(MatrixOfVariables<A> || MatrixOfVariables<B>);

/// 1 if X is a vector, else Eigen::Dynamic.
template <class X>
[[nodiscard]] consteval int columns_of() {
  if constexpr (EigenMatrix<X>) {
    return X::ColsAtCompileTime == 1 ? 1 : Eigen::Dynamic;
  } else if constexpr (DifferentiableArray<X>) {
    return X::rank == 1 ? 1 : Eigen::Dynamic;
  } else {
    return std::tuple_size_v<typename X::shape_type> == 1 ? 1 : Eigen::Dynamic;
  }
}

/// Places on the tape of the entries of an Eigen matrix, column by column; no links if all are passive.
template <class T>
struct EntriesSlot {
  std::vector<Link> links;
  void drop_if_passive() {
    if (std::none_of(links.begin(), links.end(), [](Link link) { return link.is_active(); })) links.clear();
  }
  struct Adjoint {
    const std::vector<Link>* links;
    T* adjoints;
  };
  [[nodiscard]] bool is_active() const { return !links.empty(); }
  void require_own(const TapeState<T>& state) const {
    for (const Link link : links) state.require_own_if_active(link);
  }
  void list(std::vector<std::uint32_t>& statements) const {
    for (const Link link : links)
      if (link.is_active()) statements.push_back(link.index());
  }
  [[nodiscard]] Adjoint adjoint(T* adjoints) const { return {&links, adjoints}; }
  static void require_shape() {}
};

/// An input's numbers, and a slot that finds its adjoint on the tape: an EntriesSlot or an ArraySlot.
template <class T, class Slot>
struct MatrixInput {
  DenseMatrix<T> value;
  Slot slot;
};

template <class T>
using RowMajorMatrix = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// An array in Eigen's form; a vector is a column.
template <class T, std::size_t Rank>
[[nodiscard]] auto eigen_map(const Array<T, Rank>& array) {
  const auto columns = static_cast<Eigen::Index>(Rank == 1 ? 1 : array.shape()[Rank - 1]);
  return Eigen::Map<const RowMajorMatrix<T>>(array.data(), static_cast<Eigen::Index>(array.shape()[0]),
                                             columns);
}

template <class T, EigenMatrix X>
[[nodiscard]] auto matrix_input(const X& x) {
  MatrixInput<T, EntriesSlot<T>> input;
  if constexpr (!ScalarExpression<typename X::Scalar>) {
    input.value = x.template cast<T>();
  } else {
    const auto& entries = x.eval();
    input.value.resize(entries.rows(), entries.cols());
    input.slot.links.reserve(static_cast<std::size_t>(entries.size()));
    for (Eigen::Index j = 0; j < entries.cols(); ++j)
      for (Eigen::Index i = 0; i < entries.rows(); ++i) {
        const Variable<T>& entry = entries(i, j);
        input.value(i, j) = entry.value();
        input.slot.links.push_back(entry.link());
      }
    input.slot.drop_if_passive();
  }
  return input;
}

template <class T, std::size_t Rank>
[[nodiscard]] auto matrix_input(const ArrayVariable<T, Rank>& x) {
  return MatrixInput<T, ArraySlot<T, Rank>>{eigen_map(x.value()), slot_of(SlotFor<T>(), x)};
}
template <class T, ArrayExpression X>
[[nodiscard]] auto matrix_input(const X& x) {
  return matrix_input<T>(ArrayVariable<T, X::rank>(x));
}
template <class T, std::size_t Rank>
[[nodiscard]] auto matrix_input(const Array<T, Rank>& x) {
  return MatrixInput<T, ArraySlot<T, Rank>>{eigen_map(x), {}};
}

template <class Matrix>
[[nodiscard]] std::string shape_text(const Matrix& matrix) {
  return to_text(std::array{matrix.rows(), matrix.cols()});
}

template <class A>
void require_square(const char* operation, const A& a) {
  if (a.rows() != a.cols())
    throw ShapeError({operation, ": a is ", shape_text(a), ", expected a square matrix"});
}

template <class A, class B>
void require_equal_rows(const char* operation, const A& a, const B& b) {
  if (a.rows() != b.rows())
    throw ShapeError(
        {operation, ": b is ", shape_text(b), ", expected ", a.rows(), " rows as a ", shape_text(a)});
}
}  // namespace tapestry::detail
