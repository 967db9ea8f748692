#pragma once
#include <complex>
#include <tapestry/autodiff/detail/eigen/changes.hpp>

// Solvers for eigenvalues in place of Eigen's. Eigen's solvers end an iteration at a value 0, and drop its
// derivatives.

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

 public:
  /// \param a  [N, N], only the lower triangle is read
  template <class Matrix, class Values, class Vectors>
  SymmetricTurn(const Matrix& a, const Values& values, const Vectors& vectors)
      : values_(values), vectors_(vectors), turn_(a.rows(), a.rows()) {
    const Changes<S> change = changes_of(a);
    const Changes<S> whole = change.template selfadjointView<Eigen::Lower>();
    turn_ = of_changes<S>(vectors_.transpose(), of_changes<S>(vectors_.transpose(), whole).transpose());
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
  Eigen::Matrix<T, Eigen::Dynamic, 1> values_;
  Numbers<S> vectors_;
  Changes<S> turn_;
};

/// The same of any square matrix, with complex values and vectors of length one. With Ẇ = V₀⁻¹ Ȧ V₀,
///
///   λ̇ₖ = Ẇₖₖ        v̇ₖ = Σ_{j ≠ k} (vⱼ − vₖ (vₖᴴ vⱼ)) Ẇⱼₖ / (λₖ − λⱼ),
///
/// so that vₖᴴ v̇ₖ = 0: the length stays one, and a complex vector keeps its phase.
template <class S>
class GeneralTurn {
  using T = typename S::value_type;
  using ComplexNumber = std::complex<T>;

 public:
  template <class Matrix, class Solver>
  GeneralTurn(const Matrix& a, const Solver& solver)
      : values_(solver.eigenvalues()), vectors_(solver.eigenvectors()), turn_(2 * a.rows(), a.rows()) {
    const Eigen::Index n = a.rows();
    Numbers<S> pair(2 * n, 2 * n);  // V₀ as real numbers
    pair << vectors_.real(), -vectors_.imag(), vectors_.imag(), vectors_.real();
    Numbers<S> both(2 * n, n);
    both << vectors_.real().transpose(), vectors_.imag().transpose();
    const Changes<S> turned = of_changes<S>(both, changes_of(a).transpose());  // (Ȧ V₀)ᵀ
    Changes<S> stacked(2 * n, n);
    stacked << turned.topRows(n).transpose(), turned.bottomRows(n).transpose();
    turn_ = of_changes<S>(pair.inverse(), stacked);
  }

  [[nodiscard]] std::complex<S> value(Eigen::Index k) const {
    const ComplexNumber& value = values_(k);
    return {value.real() + turn_(k, k), is_real(k) ? S(0) : S(value.imag() + turn_(values_.size() + k, k))};
  }
  [[nodiscard]] std::complex<S> vector_entry(Eigen::Index i, Eigen::Index k) const {
    std::vector<S> turns;
    std::vector<T> real, imaginary;
    for (Eigen::Index j = 0; j < values_.size(); ++j) {
      if (j == k) continue;
      const ComplexNumber along = vectors_.col(k).dot(vectors_.col(j));
      const ComplexNumber partial = (vectors_(i, j) - vectors_(i, k) * along) / (values_(k) - values_(j));
      turns.insert(turns.end(), {turn_(j, k), turn_(values_.size() + j, k)});
      real.insert(real.end(), {partial.real(), -partial.imag()});
      imaginary.insert(imaginary.end(), {partial.imag(), partial.real()});
    }
    const ComplexNumber& entry = vectors_(i, k);
    return {of_range(entry.real(), turns, real),
            is_real(k) ? S(0) : S(of_range(entry.imag(), turns, imaginary))};
  }

 private:
  [[nodiscard]] bool is_real(Eigen::Index k) const { return values_(k).imag() == T(0); }

  Eigen::Matrix<ComplexNumber, Eigen::Dynamic, 1> values_;
  Eigen::Matrix<ComplexNumber, Eigen::Dynamic, Eigen::Dynamic> vectors_;
  Changes<S> turn_;  // Re Ẇ above Im Ẇ
};
}  // namespace tapestry::detail

namespace Eigen {
template <class Matrix>
class SelfAdjointEigenSolver;
template <class Matrix>
class EigenSolver;

/// Eigenvalues and vectors of a symmetric matrix of variables, with the values of Eigen's own solver. Where
/// values are equal, their derivatives follow one choice of vectors: right for symmetric functions of all
/// equal values. Derivatives of their vectors are infinite or NaN.
template <tapestry::detail::MatrixOfDifferentiable Matrix>
class SelfAdjointEigenSolver<Matrix> {
 public:
  using MatrixType = Matrix;
  using Scalar = typename Matrix::Scalar;
  using RealScalar = Scalar;
  using EigenvectorsType = Eigen::Matrix<Scalar, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime>;
  using RealVectorType = Eigen::Matrix<Scalar, Matrix::RowsAtCompileTime, 1>;

  SelfAdjointEigenSolver() = default;
  /// Makes room for the spectrum of a matrix of this size, for compute().
  explicit SelfAdjointEigenSolver(Index size) : m_eivec(size, size), m_eivalues(size) {}
  template <class Input>
  explicit SelfAdjointEigenSolver(const EigenBase<Input>& a, int options = ComputeEigenvectors) {
    compute(a, options);
  }
  template <class Input>
  SelfAdjointEigenSolver& compute(const EigenBase<Input>& input, int options = ComputeEigenvectors) {
    const EigenvectorsType a(input.derived());
    const Index n = a.rows();
    const SelfAdjointEigenSolver<tapestry::detail::Numbers<Scalar>> solver(tapestry::detail::numbers_of(a));
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

 protected:  // under the names that GeneralizedSelfAdjointEigenSolver uses
  EigenvectorsType m_eivec;
  RealVectorType m_eivalues;
  ComputationInfo m_info = InvalidInput;
};

/// Eigenvalues and vectors of a square matrix of variables, complex, with the values of Eigen's own solver.
/// Derivatives of a vector keep its length and its phase. Where values are equal, their derivatives follow
/// one choice of vectors: right for symmetric functions of all equal values, or infinite or NaN where the
/// matrix has fewer vectors than values; derivatives of their vectors are infinite or NaN.
template <tapestry::detail::MatrixOfDifferentiable Matrix>
class EigenSolver<Matrix> {
 public:
  using MatrixType = Matrix;
  using Scalar = typename Matrix::Scalar;
  using RealScalar = Scalar;
  using ComplexScalar = std::complex<Scalar>;
  using EigenvalueType = Eigen::Matrix<ComplexScalar, Matrix::ColsAtCompileTime, 1>;
  using EigenvectorsType = Eigen::Matrix<ComplexScalar, Matrix::RowsAtCompileTime, Matrix::ColsAtCompileTime>;

  EigenSolver() = default;
  explicit EigenSolver(Index size) : eigenvectors_(size, size), eigenvalues_(size) {}
  template <class Input>
  explicit EigenSolver(const EigenBase<Input>& a, bool has_vectors = true) {
    compute(a, has_vectors);
  }
  template <class Input>
  EigenSolver& compute(const EigenBase<Input>& input, bool has_vectors = true) {
    const MatrixType a(input.derived());
    const Index n = a.rows();
    const EigenSolver<tapestry::detail::Numbers<Scalar>> solver(tapestry::detail::numbers_of(a));
    info_ = solver.info();
    if (info_ != Success) return *this;
    const tapestry::detail::GeneralTurn<Scalar> turn(a, solver);
    eigenvalues_.resize(n);
    for (Index k = 0; k < n; ++k) eigenvalues_(k) = turn.value(k);
    eigenvectors_.resize(n, n);
    for (Index k = 0; k < n && has_vectors; ++k)
      for (Index i = 0; i < n; ++i) eigenvectors_(i, k) = turn.vector_entry(i, k);
    return *this;
  }

  [[nodiscard]] const EigenvalueType& eigenvalues() const { return eigenvalues_; }
  [[nodiscard]] const EigenvectorsType& eigenvectors() const { return eigenvectors_; }
  [[nodiscard]] ComputationInfo info() const { return info_; }

 private:
  EigenvectorsType eigenvectors_;
  EigenvalueType eigenvalues_;
  ComputationInfo info_ = InvalidInput;
};
}  // namespace Eigen
