#include <Eigen/SparseCore>
#include <tapestry/autodiff/eigen.hpp>

void f(const Eigen::SparseMatrix<tapestry::Variable<double>>& a,
       Eigen::SparseMatrix<tapestry::Variable<double>>& b) {
  a.triangularView<Eigen::Lower>().solveInPlace(b);
}
