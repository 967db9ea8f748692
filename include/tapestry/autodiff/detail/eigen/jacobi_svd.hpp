#pragma once
#include <tapestry/autodiff/detail/eigen/changes.hpp>

// The singular value decomposition A = U diag(s) Vᵀ in place of Eigen's, which ends an iteration where a
// value is 0, and drops its derivatives.

namespace tapestry::detail {
/// Singular vectors of variables, U, from those of numbers, U₀, [M, P], and Ȧ V₀, [M, K], or for V from V₀
/// and Ȧᵀ U₀. With Ẇ = U₀ᵀ Ȧ V₀,
///
///   u̇ⱼ = Σ_{l ≠ j} uₗ (sⱼ Ẇₗⱼ + sₗ Ẇⱼₗ) / (sⱼ² − sₗ²) + (1 − U₀ U₀ᵀ) Ȧ vⱼ / sⱼ  of the first K,
///   u̇ⱼ = −Σₗ uₗ Ẇⱼₗ / sₗ                                                        of the others.
///
/// Source: as SymmetricTurn, 3.2.
template <class S>
[[nodiscard]] Changes<S> singular_vectors_of(const Numbers<S>& u, const Changes<S>& changes,
                                             const Numbers<S>& s) {
  using T = typename S::value_type;
  const Eigen::Index k = s.rows();
  const Changes<S> turn = of_changes<S>(u.transpose(), changes);
  Changes<S> result(u.rows(), u.cols());
  for (Eigen::Index i = 0; i < u.rows(); ++i)
    for (Eigen::Index j = 0; j < u.cols(); ++j) {
      std::vector<S> turns;
      std::vector<T> partials;
      const auto add = [&](const S& change, const T& partial) {
        turns.push_back(change);
        partials.push_back(partial);
      };
      for (Eigen::Index l = 0; l < k; ++l) {
        if (j >= k || u.rows() > k) add(turn(j < k ? l : j, j < k ? j : l), -u(i, l) / s(j < k ? j : l));
        if (j >= k || j == l) continue;
        const T gap = u(i, l) / (s(j) - s(l));
        add(turn(l, j), gap * (s(j) / (s(j) + s(l))));
        add(turn(j, l), gap * (s(l) / (s(j) + s(l))));
      }
      if (j < k && u.rows() > k) add(changes(i, j), 1 / s(j));
      result(i, j) = of_range(u(i, j), turns, partials);
    }
  return result;
}
}  // namespace tapestry::detail

namespace Eigen {
/// Singular values and vectors of a matrix of variables, with the numbers of Eigen's own JacobiSVD. Where
/// values are equal, their derivatives follow one choice of vectors: right for symmetric functions of all
/// equal values. Derivatives of their vectors are infinite or NaN, and so are those for a value 0. A value 0
/// has the slope of one side.
template <tapestry::detail::MatrixOfDifferentiable Matrix, int Preconditioner>
class JacobiSVD<Matrix, Preconditioner> {
 public:
  using MatrixType = Matrix;
  using Scalar = typename Matrix::Scalar;
  using RealScalar = Scalar;
  using MatrixUType = Eigen::Matrix<Scalar, Matrix::RowsAtCompileTime, Matrix::RowsAtCompileTime>;
  using MatrixVType = Eigen::Matrix<Scalar, Matrix::ColsAtCompileTime, Matrix::ColsAtCompileTime>;
  using SingularValuesType = typename internal::plain_diag_type<Matrix, Scalar>::type;

  JacobiSVD() = default;
  template <class Input>
  explicit JacobiSVD(const EigenBase<Input>& a, unsigned options = 0) {
    compute(a, options);
  }
  /// \param options  any of ComputeThinU, ComputeFullU, ComputeThinV and ComputeFullV
  template <class Input>
  JacobiSVD& compute(const EigenBase<Input>& input, unsigned options = 0) {
    using Numbers = tapestry::detail::Numbers<Scalar>;
    constexpr unsigned parts = ComputeFullU | ComputeThinU | ComputeFullV | ComputeThinV;
    constexpr auto given = static_cast<unsigned>(Preconditioner);
    options |= given & parts;  // if Eigen, after 3.4, has them
    const MatrixType a(input.derived());
    const JacobiSVD<Numbers, static_cast<int>(given & ~parts)> svd(
        tapestry::detail::numbers_of(a), ((options & ComputeFullU) != 0 ? ComputeFullU : ComputeThinU) |
                                             ((options & ComputeFullV) != 0 ? ComputeFullV : ComputeThinV));
    info_ = svd.info();
    const Numbers u = svd.matrixU(), v = svd.matrixV(), s = svd.singularValues();
    const Index k = s.rows();
    const auto of_changes = tapestry::detail::of_changes<Scalar>;
    const tapestry::detail::Changes<Scalar> changes = tapestry::detail::changes_of(a);
    const tapestry::detail::Changes<Scalar> of_u =
        of_changes(v.leftCols(k).transpose(), changes.transpose()).transpose();
    values_.resize(k);
    for (Index j = 0; j < k; ++j) values_(j) = s(j) + of_changes(u.col(j).transpose(), of_u.col(j))(0, 0);
    if ((options & (ComputeFullU | ComputeThinU)) != 0)
      u_ = tapestry::detail::singular_vectors_of<Scalar>(u, of_u, s);
    if ((options & (ComputeFullV | ComputeThinV)) != 0)
      v_ = tapestry::detail::singular_vectors_of<Scalar>(
          v, of_changes(u.leftCols(k).transpose(), changes).transpose(), s);
    return *this;
  }

  [[nodiscard]] const MatrixUType& matrixU() const { return u_; }
  [[nodiscard]] const MatrixVType& matrixV() const { return v_; }
  [[nodiscard]] const SingularValuesType& singularValues() const { return values_; }
  [[nodiscard]] ComputationInfo info() const { return info_; }

 private:
  MatrixUType u_;
  MatrixVType v_;
  SingularValuesType values_;
  ComputationInfo info_ = InvalidInput;
};

/// The same.
template <tapestry::detail::MatrixOfDifferentiable Matrix>
class BDCSVD<Matrix> : public JacobiSVD<Matrix> {
 public:
  using JacobiSVD<Matrix>::JacobiSVD;
};
}  // namespace Eigen
