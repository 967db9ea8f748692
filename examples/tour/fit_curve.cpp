// Fits y = a·exp(−b·t) + c to measured points by Newton's method: gradient and exact Hessian of the squared
// error.
#include <Eigen/Cholesky>
#include <cstdio>
#include <tapestry/autodiff.hpp>

namespace {
struct Point {
  double t;
  double y;
};

std::vector<Point> measured_points() {
  std::vector<Point> points;
  for (int i = 0; i < 20; ++i) {
    const double t = 0.25 * i;
    points.push_back({t, 2 * std::exp(-0.75 * t) + 0.5 + 0.01 * std::sin(37.0 * i)});  // and a little noise
  }
  return points;
}
}  // namespace

int main() {
  const auto points = measured_points();
  const auto squared_error = [&]<class S>(std::span<S> parameters) {  // of any scalar type
    const auto& a = parameters[0];
    const auto& b = parameters[1];
    const auto& c = parameters[2];
    std::remove_const_t<S> error = 0;
    for (const Point& point : points) error += square(a * exp(-b * point.t) + c - point.y);
    return error;
  };

  std::vector<double> parameters = {1.5, 0.5, 0.7};
  for (int step = 0; step < 12; ++step) {
    const auto gradient = tapestry::gradient(squared_error, parameters).gradient;
    const auto hessian = tapestry::hessian(squared_error, parameters);
    const Eigen::Vector3d down = Eigen::Map<const Eigen::Matrix3d>(hessian.data())
                                     .ldlt()
                                     .solve(Eigen::Map<const Eigen::Vector3d>(gradient.data()));
    for (std::size_t i = 0; i < 3; ++i) parameters[i] -= down[static_cast<Eigen::Index>(i)];
  }
  const auto fitted = tapestry::gradient(squared_error, parameters);
  double slope = 0;
  for (const double entry : fitted.gradient) slope += entry * entry;
  std::printf("y = %.4f exp(-%.4f t) + %.4f\n", parameters[0], parameters[1], parameters[2]);
  std::printf("squared error %.6f, gradient %s\n", fitted.value,
              std::sqrt(slope) < 1e-10 ? "zero" : "not zero");
}
