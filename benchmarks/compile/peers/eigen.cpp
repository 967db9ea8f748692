#include <Eigen/Dense>
#include <iostream>

int main() {
  const Eigen::MatrixXd a = Eigen::MatrixXd::Identity(3, 3);
  std::cout << a * a << '\n';
}
