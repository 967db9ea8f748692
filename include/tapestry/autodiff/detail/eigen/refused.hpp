#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

// Algorithms of Eigen that drop derivatives where a value is 0, or end where values have converged and their
// derivatives have not. They do not compile for variables.

namespace tapestry::detail {
template <class>
inline constexpr bool is_right_for_variables = false;
}  // namespace tapestry::detail

namespace Eigen {
template <class Matrix>
class RealSchur;
template <class Matrix>
class RealQZ;
template <class Matrix>
class ComplexSchur;
template <class Solver>
class IterativeSolverBase;
template <class Matrix, class Ordering>
class SparseQR;

template <tapestry::detail::MatrixOfDifferentiable Matrix>
class RealSchur<Matrix> {
  static_assert(tapestry::detail::is_right_for_variables<Matrix>,
                "Eigen's Schur and QZ decompositions drop derivatives of variables where an entry is 0: take "
                "Eigen::EigenSolver, which is one of tapestry for variables");

 public:
  template <class... Arguments>
  explicit RealSchur(const Arguments&...) {}
};
template <tapestry::detail::MatrixOfDifferentiable Matrix>
class RealQZ<Matrix> : public RealSchur<Matrix> {
  using RealSchur<Matrix>::RealSchur;
};
template <tapestry::detail::MatrixOfDerivatives Matrix>
class ComplexSchur<Matrix> {
  static_assert(
      tapestry::detail::is_right_for_variables<Matrix>,
      "Eigen's solvers of complex eigenvalues drop derivatives of variables where an entry is 0; there "
      "is none for complex matrices");

 public:
  template <class... Arguments>
  explicit ComplexSchur(const Arguments&...) {}
};

template <class Solver>
requires tapestry::detail::HasDerivatives<typename internal::traits<Solver>::MatrixType::Scalar>
class IterativeSolverBase<Solver> {
  static_assert(tapestry::detail::is_right_for_variables<Solver>,
                "Eigen's iterative solvers end before the derivatives of variables have converged: take "
                "tapestry::matrix::solve() of tapestry/autodiff/matrix.hpp, or Eigen::SparseLU");

 public:
  template <class... Arguments>
  explicit IterativeSolverBase(const Arguments&...) {}

 protected:  // as solvers name them
  int matrix() const { return 0; }
  int m_error, m_iterations, m_info, m_isInitialized;
};
template <tapestry::detail::MatrixOfDerivatives Matrix, class Ordering>
class SparseQR<Matrix, Ordering> {
  static_assert(tapestry::detail::is_right_for_variables<Matrix>,
                "Eigen's SparseQR drops derivatives of variables where an entry is 0: take "
                "tapestry::matrix::least_squares() of a dense matrix, of tapestry/autodiff/matrix.hpp");

 public:
  template <class... Arguments>
  explicit SparseQR(const Arguments&...) {}
};

namespace internal {
template <class Left, class Right, int Mode, int UpLo, int Order>
struct sparse_solve_triangular_sparse_selector;
template <class Scalar, class StorageIndex>
class AmbiVector;

template <class Left, tapestry::detail::MatrixOfDerivatives Right, int Mode, int UpLo>
struct sparse_solve_triangular_sparse_selector<Left, Right, Mode, UpLo, ColMajor> {
  static_assert(
      tapestry::detail::is_right_for_variables<Left>,
      "Eigen drops derivatives of variables where an entry of a sparse right-hand side is 0: take a dense "
      "one");
  static void run(const Left&, const Right&) {}
};
template <tapestry::detail::HasDerivatives Scalar, class StorageIndex>
class AmbiVector<Scalar, StorageIndex> {
  static_assert(
      tapestry::detail::is_right_for_variables<Scalar>,
      "Eigen drops derivatives of variables where an entry of pruned() of a product is 0: take the product");
};
}  // namespace internal
}  // namespace Eigen
