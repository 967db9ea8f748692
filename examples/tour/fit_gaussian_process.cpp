// Fits a Gaussian process to noisy measurements of a curve: how far the curve varies, over what length, and
// how noisy the measurements are, by the greatest likelihood. Matrices of variables are solved and have
// determinants as one record each; Eigen alone would record each of their n³ / 3 multiplications.
#include <cstdio>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/optim/adam.hpp>

using tapestry::Tape, tapestry::Variable;
using Matrix = Eigen::Matrix<Variable<double>, Eigen::Dynamic, Eigen::Dynamic>;

namespace {
constexpr Eigen::Index n = 60;

/// −log p(y) but for a constant: (yᵀ K⁻¹ y + log det K) / 2, K[i, j] = a² exp(−(i − j)² h² / 2 l²) + s² δ[i,
/// j].
Variable<double> misfit(const std::array<Variable<double>, 3>& logarithms, const Eigen::VectorXd& y,
                        double spacing) {
  const Variable<double> variance = exp(2 * logarithms[0]), noise = exp(2 * logarithms[2]);
  const Variable<double> rate = exp(-2 * logarithms[1]) / 2;
  std::array<Variable<double>, n> covariance;  // by distance
  for (std::size_t k = 0; k < covariance.size(); ++k)
    covariance[k] = variance * exp(-rate * std::pow(spacing * static_cast<double>(k), 2));
  covariance[0] += noise;
  Matrix k(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) k(i, j) = covariance[static_cast<std::size_t>(std::abs(i - j))];
  const auto weights = tapestry::matrix::solve_positive_definite(k, y);
  return (y.dot(weights) + tapestry::matrix::log_determinant_positive_definite(k)) / 2;
}
}  // namespace

int main() {
  constexpr double spacing = 0.2, true_noise = 0.1;
  tapestry::Random random(3);
  Eigen::VectorXd y(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double x = spacing * static_cast<double>(i);
    double error = -6;  // of about the normal distribution
    for (int draw = 0; draw < 12; ++draw) error += random.uniform(0, 1);
    y(i) = std::sin(x) + true_noise * error;
  }
  std::array<double, 3> logarithms = {0, 0, 0}, gradient;
  tapestry::optim::Adam<double> adam(logarithms.size(), {.learning_rate = 0.05});
  Tape<double> tape;
  for (int step = 0; step < 300; ++step) {
    tape.clear();
    const auto scope = tape.activate();
    std::array<Variable<double>, 3> inputs;
    tape.input(logarithms, inputs);
    tape.reverse(misfit(inputs, y, spacing));
    tape.adjoints(inputs, gradient);
    adam.step(logarithms, gradient);
  }
  std::printf("two records for two decompositions: %s\n", tape.record_count() == 2 ? "yes" : "no");
  std::printf("noise %.2f, length %.1f\n", std::exp(logarithms[2]), std::exp(logarithms[1]));
}
