#pragma once
#include <Eigen/SVD>
#include <tapestry/autodiff/detail/matrix/eigenvalues.hpp>

namespace tapestry {
namespace detail {
/// A = U diag(s) Vᵀ, thin.
template <class T>
struct SingularTriples {
  DenseMatrix<T> u, s, v;
};

template <std::floating_point T>
[[nodiscard]] std::shared_ptr<const SingularTriples<T>> singular_triples_of(const char* operation,
                                                                            const DenseMatrix<T>& a) {
  if (!a.allFinite()) throw NumericError({operation, ": a has a number that is not finite"});
  SingularTriples<T> triples{DenseMatrix<T>(a.rows(), 0), DenseMatrix<T>(0, 1), DenseMatrix<T>(a.cols(), 0)};
  if (a.size() > 0) {
    const Eigen::JacobiSVD<DenseMatrix<T>> svd(a, Eigen::ComputeThinU | Eigen::ComputeThinV);
    triples = {svd.matrixU(), svd.singularValues(), svd.matrixV()};
  }
  return std::make_shared<const SingularTriples<T>>(std::move(triples));
}

/// (F ∘ (P − Pᵀ)) diag(s) with F[i, j] = 1 / (s[j]² − s[i]²), 0 on the diagonal.
template <std::floating_point T>
[[nodiscard]] DenseMatrix<T> turned_singular_vectors(const DenseMatrix<T>& s, const DenseMatrix<T>& p) {
  const Eigen::Index k = s.rows();
  const T rounding = T(16) * static_cast<T>(k) * std::numeric_limits<T>::epsilon();
  const T turn_size = k == 0 ? T(0) : rounding * p.cwiseAbs().maxCoeff();
  DenseMatrix<T> turned = DenseMatrix<T>::Zero(k, k);
  for (Eigen::Index j = 0; j < k; ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      const T by_difference =
          divided_by_gap("singular_values", p(i, j) - p(j, i), s(j) - s(i), turn_size, rounding * s(0));
      if (by_difference == T(0)) continue;
      turned(i, j) = by_difference * (s(j) / (s(j) + s(i)));  // F alone may overflow
      turned(j, i) = by_difference * (s(i) / (s(j) + s(i)));
    }
  return turned;
}

/// Ū's part of Ā: (U (F ∘ (Uᵀ Ū − Ūᵀ U)) diag(s) + (1 − U Uᵀ) Ū diag(s)⁻¹) Vᵀ. For V̄'s part the transpose,
/// with U and V exchanged.
template <std::floating_point T>
[[nodiscard]] DenseMatrix<T> pull_back_singular_vectors(const DenseMatrix<T>& u, const DenseMatrix<T>& s,
                                                        const DenseMatrix<T>& v,
                                                        const DenseMatrix<T>& u_adjoint) {
  const DenseMatrix<T> p = u.transpose() * u_adjoint;
  DenseMatrix<T> left = u * turned_singular_vectors(s, p);
  if (u.rows() > u.cols() && s.rows() > 0) {
    const T least = T(16) * static_cast<T>(u.rows()) * std::numeric_limits<T>::epsilon() * s(0);
    const T rounding =
        T(16) * static_cast<T>(u.rows()) * std::numeric_limits<T>::epsilon() * u_adjoint.norm();
    DenseMatrix<T> turned_out = u_adjoint - u * p;
    for (Eigen::Index j = 0; j < s.rows(); ++j) {
      if (s(j) <= least && turned_out.col(j).norm() > rounding)
        throw NumericError("singular_values: one is 0, so that its vectors have no derivative");
      turned_out.col(j) *= s(j) <= least ? T(0) : 1 / s(j);
    }
    left += turned_out;
  }
  return left * v.transpose();
}
}  // namespace detail

namespace matrix {
/// Result of singular_values(): arrays or Eigen matrices of variables.
template <class Values, class Vectors>
struct SingularValues {
  Vectors u;      ///< U, [M, K], a unit vector a column
  Values values;  ///< s, [K], descending, not negative
  Vectors v;      ///< V, [N, K], a unit vector a column; signs of U and V as Eigen's JacobiSVD gives them
};

/// The thin singular value decomposition A = U diag(s) Vᵀ, K = min(M, N). It is computed once; U, s and V
/// have a record each.
///
///   Ā = U diag(s̄) Vᵀ + (U (F ∘ (Uᵀ Ū − Ūᵀ U)) diag(s) + (1 − U Uᵀ) Ū diag(s)⁻¹) Vᵀ
///       + U (diag(s) (F ∘ (Vᵀ V̄ − V̄ᵀ V)) Vᵀ + diag(s)⁻¹ V̄ᵀ (1 − V Vᵀ)),
///
/// F[i, j] = 1 / (s[j]² − s[i]²), 0 on the diagonal. Sources: values, Giles 2008, "Collected matrix
/// derivative results for forward and reverse mode algorithmic differentiation", 3.2; vectors, Townsend 2016,
/// "Differentiating the singular value decomposition".
///
/// Equal values, and values that are 0, have no derivative each. The result is then one of many, right for
/// symmetric functions of all equal ones; for values that are 0 it is a subgradient. Vectors of equal values
/// may then be used only in functions of the space that they span. Equal means up to 16 K rounding errors of
/// the largest.
///
/// \param a  A, [M, N], of floating-point variables: Eigen matrix, array variable or formula; M, N may be 0
/// \returns  U, s and V, held as a is
/// \throws NumericError if a number is not finite; in the reverse sweep, if vectors of equal values have an
///   adjoint that turns them, or vectors of the longer side belong to a value 0
template <detail::MatrixOfFloats A>
[[nodiscard]] auto singular_values(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto triples = detail::singular_triples_of<T>("singular_values", input.value);
  const auto by_values = [triples](const Matrix& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = triples->u * value_adjoint.col(0).asDiagonal() * triples->v.transpose();
  };
  const auto by_u = [triples](const Matrix& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = detail::pull_back_singular_vectors(triples->u, triples->s, triples->v, value_adjoint);
  };
  const auto by_v = [triples](const Matrix& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint =
        detail::pull_back_singular_vectors(triples->v, triples->s, triples->u, value_adjoint).transpose();
  };
  auto values = detail::record_matrix<1>(triples->s, by_values, input);
  auto u = detail::record_matrix<Eigen::Dynamic>(triples->u, by_u, input);
  auto v = detail::record_matrix<Eigen::Dynamic>(triples->v, by_v, input);
  return SingularValues<decltype(values), decltype(u)>{std::move(u), std::move(values), std::move(v)};
}

/// The largest singular value, as one record; 0 for an empty matrix. Ā = u vᵀ · adjoint; where several are
/// the largest, or all are 0, it follows one of them, a subgradient.
/// \param a  A, [M, N]
/// \throws NumericError if a number is not finite
template <detail::MatrixOfFloats A>
[[nodiscard]] auto spectral_norm(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto triples = detail::singular_triples_of<T>("spectral_norm", input.value);
  const auto pullback = [triples](const T& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = Matrix::Zero(triples->u.rows(), triples->v.rows());
    if (triples->s.rows() > 0) *a_adjoint = value_adjoint * triples->u.col(0) * triples->v.col(0).transpose();
  };
  return detail::record_number<T>(triples->s.rows() > 0 ? triples->s(0) : T(0), pullback, input);
}

/// The sum of the singular values, as one record; 0 of an empty matrix. Ā = U Vᵀ · adjoint; where values are
/// 0, a subgradient.
/// \param a  A, [M, N].
/// \throws NumericError if a number is not finite
template <detail::MatrixOfFloats A>
[[nodiscard]] auto nuclear_norm(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto triples = detail::singular_triples_of<T>("nuclear_norm", input.value);
  const auto pullback = [triples](const T& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = value_adjoint * triples->u * triples->v.transpose();
  };
  return detail::record_number<T>(triples->s.sum(), pullback, input);
}
}  // namespace matrix
}  // namespace tapestry
