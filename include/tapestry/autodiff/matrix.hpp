#pragma once
/// Operations of linear algebra as one record each: of Eigen matrices of variables,
/// Eigen::Matrix<Variable<T>, …>, and of array variables, ArrayVariable<T, 2>. The header of a single
/// operation compiles faster.
///
///   const auto a = tape.input(covariance);                         // ArrayVariable<double, 2>
///   const auto z = matrix::solve_triangular(matrix::cholesky(a), x, matrix::Triangle::lower);
///   const Variable<double> loss = sum(z * z) / 2 + matrix::log_determinant_positive_definite(a) / 2;
///   tape.reverse(loss);                                            // a.adjoint(), [N, N]
#include <tapestry/autodiff/detail/matrix/product.hpp>
#include <tapestry/autodiff/detail/matrix/singular_values.hpp>
#include <tapestry/autodiff/detail/matrix/sparse_solve.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>
