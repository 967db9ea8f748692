#include <Eigen/Eigenvalues>
#include <tapestry/autodiff/eigen.hpp>

void f(const Eigen::Matrix<tapestry::Variable<double>, 3, 3>& a) {
  const Eigen::RealSchur<Eigen::Matrix<tapestry::Variable<double>, 3, 3>> schur(a);
}
