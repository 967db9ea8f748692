#include <Eigen/SparseQR>
#include <tapestry/autodiff/eigen.hpp>

void f(const Eigen::SparseMatrix<tapestry::Variable<double>>& a) {
  const Eigen::SparseQR<Eigen::SparseMatrix<tapestry::Variable<double>>, Eigen::COLAMDOrdering<int>> qr(a);
}
