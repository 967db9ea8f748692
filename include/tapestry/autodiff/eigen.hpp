#pragma once
#include <tapestry/autodiff/detail/eigen/determinant.hpp>
#include <tapestry/autodiff/detail/eigen/eigen_solvers.hpp>
#include <tapestry/autodiff/detail/eigen/householder.hpp>
#include <tapestry/autodiff/detail/eigen/jacobi_rotation.hpp>
#include <tapestry/autodiff/detail/eigen/jacobi_svd.hpp>
#include <tapestry/autodiff/detail/eigen/refused.hpp>
#include <tapestry/autodiff/detail/eigen/sparse_view.hpp>
#include <tapestry/autodiff/detail/eigen/stable_norm.hpp>
#include <tapestry/autodiff/detail/eigen/unit_triangle.hpp>
#include <tapestry/autodiff/dual.hpp>

/// Variables and duals as scalars of Eigen: Eigen::Matrix<tapestry::Variable<double>, 3, 3> with its products
/// and decompositions. Each of their operations is differentiated. Pivoting compares the values.
///
/// A number that is 0 keeps its derivatives: in LU, Cholesky and QR decompositions, dense ones of any size
/// and SparseLU, SimplicialLLT and SimplicialLDLT, in triangular solves, determinants and sparseView(). The
/// decomposition of a matrix without full rank has no derivative: the computed one is meaningless.
/// SelfAdjointEigenSolver, EigenSolver, JacobiSVD and BDCSVD are our own, with Eigen's values. umeyama(),
/// Transform::rotation(), Quaternion::FromTwoVectors() and PolynomialSolver use them. Their comments define
/// derivatives at equal values. So vectors a half turn apart, of many axes, have no rotation with
/// derivatives: they are infinite or NaN, or 0 along the axis that was chosen.
///
/// Iterative solvers, SparseQR, solves for a sparse right-hand side, RealSchur, RealQZ and ComplexSchur do
/// not compile for variables. SparseMatrix::prune() leaves out entries of value 0 with their derivatives.

namespace tapestry::detail {
template <class S, class B>
struct EigenTraits : Eigen::GenericNumTraits<S> {
  using Real = S;
  using NonInteger = S;
  using Nested = S;
  using Literal = B;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 2,
    AddCost = 4,
    MulCost = 4
  };
  static S dummy_precision() { return S(Eigen::NumTraits<B>::dummy_precision()); }
};
}  // namespace tapestry::detail

namespace Eigen {
// Also of formulas, which Eigen's functions of numbers then return as variables.
template <tapestry::ScalarExpression E>
struct NumTraits<E> : tapestry::detail::EigenTraits<tapestry::Variable<typename E::ExpressionScalar>,
                                                    tapestry::detail::Base<typename E::ExpressionScalar>> {};
template <class T, std::size_t N, class Tag>
struct NumTraits<tapestry::Dual<T, N, Tag>>
    : tapestry::detail::EigenTraits<tapestry::Dual<T, N, Tag>, tapestry::detail::Base<T>> {};

template <tapestry::Differentiable S, tapestry::Number B, class Operation>
struct ScalarBinaryOpTraits<S, B, Operation> {
  using ReturnType = S;
};
template <tapestry::Differentiable S, tapestry::Number B, class Operation>
struct ScalarBinaryOpTraits<B, S, Operation> {
  using ReturnType = S;
};

namespace internal {
template <class A, class B>
concept NumbersBesideVariables =
    !std::same_as<A, B> && (tapestry::Differentiable<A> || tapestry::Differentiable<B>);

// Products of numbers and variables are computed entry by entry; Eigen's blocked products are for one type.
template <class Left, class Right>
requires NumbersBesideVariables<typename Left::Scalar, typename Right::Scalar>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, GemmProduct>
    : generic_product_impl<Left, Right, DenseShape, DenseShape, CoeffBasedProductMode> {
};
template <class Left, class Right>
requires NumbersBesideVariables<typename Left::Scalar, typename Right::Scalar>
struct generic_product_impl<Left, Right, DenseShape, DenseShape, GemvProduct>
    : generic_product_impl<Left, Right, DenseShape, DenseShape, CoeffBasedProductMode> {
};
}  // namespace internal
}  // namespace Eigen
