#include <Eigen/SVD>
#include <tapestry/autodiff/eigen.hpp>

void f(const Eigen::Matrix<tapestry::Variable<double>, 2, 2>& a) {
  const Eigen::JacobiSVD<Eigen::Matrix<tapestry::Variable<double>, 2, 2>> svd(a);
}
