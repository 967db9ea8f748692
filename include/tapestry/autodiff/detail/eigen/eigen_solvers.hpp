#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <tapestry/autodiff/detail/tape/expression.hpp>
#include <tapestry/autodiff/functions.hpp>
#include <type_traits>
#include <vector>

// Eigen's decompositions that iterate. They end an iteration where a value is 0, and drop its derivatives.

namespace tapestry::detail {

/// Eigenvalues λ and vectors V of a symmetric matrix of variables, from those of its values, λ₀ and V₀. With
/// Ẇ = V₀ᵀ Ȧ V₀,
///
///   λ̇ₖ = Ẇₖₖ        V̇ = V₀ (F ∘ Ẇ),  F[j, k] = 1 / (λₖ − λⱼ), 0 on the diagonal.
///
/// Source: Giles 2008, "Collected matrix derivative results for forward and reverse mode algorithmic
/// differentiation", 3.1.
template <class S>
class SymmetricTurn {
  using T = typename S::value_type;
  template <class Entry>
  using Square = Eigen::Matrix<Entry, Eigen::Dynamic, Eigen::Dynamic>;

 public:
  /// \param a  [N, N], of which the lower triangle is read
  template <class Matrix, class Values, class Vectors>
  SymmetricTurn(const Matrix& a, const Values& values, const Vectors& vectors)
      : values_(values), vectors_(vectors), turn_(a.rows(), a.rows()) {
    const Eigen::Index n = a.rows();
    const Square<S> half =
        of_columns([&](Eigen::Index i, Eigen::Index j) { return a(i < j ? j : i, i < j ? i : j); });
    turn_ = of_columns([&](Eigen::Index i, Eigen::Index j) { return half(i, j); });
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) turn_(i, j) -= turn_(i, j).value();
  }

  [[nodiscard]] S value(Eigen::Index k) const { return values_(k) + turn_(k, k); }
  [[nodiscard]] S vector_entry(Eigen::Index i, Eigen::Index k) const {
    std::vector<S> turns;
    std::vector<T> partials;
    for (Eigen::Index j = 0; j < values_.size(); ++j) {
      if (j == k) continue;
      turns.push_back(turn_(j, k));
      partials.push_back(vectors_(i, j) / (values_(k) - values_(j)));
    }
    return of_range(vectors_(i, k), turns, partials);
  }

 private:
  /// Mᵀ V₀ transposed, for the matrix of m(i, j): [k, i] is column k of V₀ by row i of M.
  template <class Entry>
  [[nodiscard]] Square<S> of_columns(const Entry& m) const {
    const Eigen::Index n = values_.size();
    Square<S> result(n, n);
    std::vector<S> row(static_cast<std::size_t>(n));
    std::vector<T> partials(row.size());
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index k = 0; k < n; ++k) {
        T total(0);
        for (Eigen::Index j = 0; j < n; ++j) {
          row[static_cast<std::size_t>(j)] = m(i, j);
          partials[static_cast<std::size_t>(j)] = vectors_(j, k);
          total += m(i, j).value() * vectors_(j, k);
        }
        result(k, i) = of_range(total, row, partials);
      }
    return result;
  }

  Eigen::Matrix<T, Eigen::Dynamic, 1> values_;
  Square<T> vectors_;
  Square<S> turn_;
};

template <class>
inline constexpr bool is_right_for_variables = false;
}  // namespace tapestry::detail

namespace Eigen {
template <class Matrix>
class SelfAdjointEigenSolver;
template <class Matrix>
class EigenSolver;
template <class Matrix>
class RealSchur;
template <class Matrix>
class RealQZ;

/// Eigenvalues and vectors of a symmetric matrix of variables, with the values of Eigen's own solver. Where
/// values are equal, their derivatives are those of one choice, right for symmetric functions of all equal
/// ones; derivatives of their vectors are infinite or NaN.
template <class Matrix>
requires tapestry::Differentiable<typename Matrix::Scalar>
class SelfAdjointEigenSolver<Matrix> {
 public:
  using MatrixType = Matrix;
  using Scalar = typename Matrix::Scalar;
  using RealScalar = Scalar;
  using EigenvectorsType = Eigen::Matrix<Scalar, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime>;
  using RealVectorType = Eigen::Matrix<Scalar, Matrix::RowsAtCompileTime, 1>;

  SelfAdjointEigenSolver() = default;
  template <class Input>
  explicit SelfAdjointEigenSolver(const EigenBase<Input>& a, int options = ComputeEigenvectors) {
    compute(a, options);
  }
  template <class Input>
  SelfAdjointEigenSolver& compute(const EigenBase<Input>& input, int options = ComputeEigenvectors) {
    using T = typename Scalar::value_type;
    using Values = Eigen::Matrix<T, Dynamic, Dynamic>;
    const EigenvectorsType a(input.derived());
    const Index n = a.rows();
    Values values(n, n);
    for (Index i = 0; i < n; ++i)
      for (Index j = 0; j < n; ++j) values(i, j) = a(i, j).value();
    const SelfAdjointEigenSolver<Values> solver(values);
    m_info = solver.info();
    const tapestry::detail::SymmetricTurn<Scalar> turn(a, solver.eigenvalues(), solver.eigenvectors());
    m_eivalues.resize(n);
    for (Index k = 0; k < n; ++k) m_eivalues(k) = turn.value(k);
    m_eivec.resize(n, n);
    for (Index k = 0; k < n && (options & EigVecMask) == ComputeEigenvectors; ++k)
      for (Index i = 0; i < n; ++i) m_eivec(i, k) = turn.vector_entry(i, k);
    return *this;
  }
  /// The same.
  template <class Input>
  SelfAdjointEigenSolver& computeDirect(const EigenBase<Input>& a, int options = ComputeEigenvectors) {
    return compute(a, options);
  }

  [[nodiscard]] const RealVectorType& eigenvalues() const { return m_eivalues; }
  [[nodiscard]] const EigenvectorsType& eigenvectors() const { return m_eivec; }
  [[nodiscard]] ComputationInfo info() const { return m_info; }
  [[nodiscard]] EigenvectorsType operatorSqrt() const {
    return m_eivec * m_eivalues.cwiseSqrt().asDiagonal() * m_eivec.adjoint();
  }
  [[nodiscard]] EigenvectorsType operatorInverseSqrt() const {
    return m_eivec * m_eivalues.cwiseInverse().cwiseSqrt().asDiagonal() * m_eivec.adjoint();
  }

 protected:  // with the names by which GeneralizedSelfAdjointEigenSolver knows them
  EigenvectorsType m_eivec;
  RealVectorType m_eivalues;
  ComputationInfo m_info = InvalidInput;
};

template <class Matrix, int Preconditioner>
requires tapestry::Differentiable<typename Matrix::Scalar>
class JacobiSVD<Matrix, Preconditioner> {
  static_assert(tapestry::detail::is_right_for_variables<Matrix>,
                "Eigen's SVDs drop derivatives of variables where an entry is 0: take "
                "tapestry::matrix::singular_values() of tapestry/autodiff/matrix.hpp");

 public:
  template <class... Arguments>
  explicit JacobiSVD(const Arguments&...) {}
};
template <class Matrix>
requires tapestry::Differentiable<typename Matrix::Scalar>
class BDCSVD<Matrix> : public JacobiSVD<Matrix> {
  using JacobiSVD<Matrix>::JacobiSVD;
};
template <class Matrix>
requires tapestry::Differentiable<typename Matrix::Scalar>
class RealSchur<Matrix> {
  static_assert(tapestry::detail::is_right_for_variables<Matrix>,
                "Eigen's solvers for matrices that are not symmetric drop derivatives of variables where an "
                "entry is 0; there is none for these");

 public:
  template <class... Arguments>
  explicit RealSchur(const Arguments&...) {}
};
template <class Matrix>
requires tapestry::Differentiable<typename Matrix::Scalar>
class EigenSolver<Matrix> : public RealSchur<Matrix> {
  using RealSchur<Matrix>::RealSchur;
};
template <class Matrix>
requires tapestry::Differentiable<typename Matrix::Scalar>
class RealQZ<Matrix> : public RealSchur<Matrix> {
  using RealSchur<Matrix>::RealSchur;
};
}  // namespace Eigen
