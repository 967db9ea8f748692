#include <tapestry/autodiff/derivatives.hpp>
#include <tapestry/autodiff/detail/matrix/product.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>

#include "../../support/catch.hpp"

namespace matrix = tapestry::matrix;

namespace {
template <class S>
using Matrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

constexpr Eigen::Index rows = 4, columns = 3;

template <class S>
Matrix<S> tall(std::span<const S> x) {
  Matrix<S> a(rows, columns);
  for (Eigen::Index k = 0; k < a.size(); ++k) a.data()[k] = x[static_cast<std::size_t>(k)];
  return a;
}
template <class S>
Matrix<S> positive_definite(std::span<const S> x) {
  const Matrix<S> a = tall(x);
  return a.transpose() * a;
}

/// Compares the Hessian of f, of records, with that of g, where Eigen's own decompositions record every step.
template <class F, class G>
void check_hessians(const F& f, const G& g) {
  std::vector<double> x;
  for (std::size_t k = 0; k < rows * columns; ++k)
    x.push_back(std::cos(static_cast<double>(3 * k + 1)) + (k % 5 == 0 ? 2 : 0));
  const auto found = tapestry::hessian(f, x), expected = tapestry::hessian(g, x);
  double largest = 1;
  for (const double entry : expected) largest = std::max(largest, std::abs(entry));
  for (std::size_t k = 0; k < found.size(); ++k) CHECK(std::abs(found[k] - expected[k]) <= 1e-12 * largest);
}
}  // namespace

TEST_CASE("records on a tape of duals have the second derivatives of every step recorded",
          "[autodiff][matrix]") {
  check_hessians(
      []<class S>(std::span<const S> x) {
        const Matrix<S> a = positive_definite(x), l = matrix::cholesky(a);
        const Matrix<S> y = matrix::solve_triangular(l, matrix::product(a, a), matrix::Triangle::lower);
        return S(y.squaredNorm() + matrix::solve_positive_definite(a, l).sum() +
                 matrix::log_determinant_positive_definite(a));
      },
      []<class S>(std::span<const S> x) {
        const Matrix<S> a = positive_definite(x), l = a.llt().matrixL(), square = a * a;
        const Matrix<S> y = l.template triangularView<Eigen::Lower>().solve(square);
        const Matrix<S> z = a.llt().solve(l);
        return S(y.squaredNorm() + z.sum() + log(a.determinant()));
      });
  check_hessians(
      []<class S>(std::span<const S> x) {
        const Matrix<S> a = tall(x).topRows(columns), b = tall(x).bottomRows(1).transpose();
        return S(matrix::inverse(a).squaredNorm() + matrix::solve(a, b).sum() + matrix::log_determinant(a));
      },
      []<class S>(std::span<const S> x) {
        const Matrix<S> a = tall(x).topRows(columns), b = tall(x).bottomRows(1).transpose();
        const Matrix<S> inverse = a.inverse(), y = a.partialPivLu().solve(b);
        return S(inverse.squaredNorm() + y.sum() + log(abs(a.determinant())));
      });
}

TEST_CASE("least squares on a tape of duals has the second derivatives of the normal equations",
          "[autodiff][matrix]") {
  const Eigen::Vector4d b(1, -2, 0.5, 3);
  check_hessians(
      [&]<class S>(std::span<const S> x) { return S(matrix::least_squares(tall(x), b).squaredNorm()); },
      [&]<class S>(std::span<const S> x) {
        const Matrix<S> a = tall(x), side = a.transpose() * b.cast<S>();
        const Matrix<S> normal = a.transpose() * a;
        const Matrix<S> y = normal.partialPivLu().solve(side);
        return S(y.squaredNorm());
      });
}
