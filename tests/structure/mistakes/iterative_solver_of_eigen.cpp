#include <Eigen/IterativeLinearSolvers>
#include <tapestry/autodiff/eigen.hpp>

void f(const Eigen::SparseMatrix<tapestry::Variable<double>>& a) {
  const Eigen::ConjugateGradient<Eigen::SparseMatrix<tapestry::Variable<double>>> solver(a);
}
