#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <tapestry/autodiff/eigen.hpp>
#include <unsupported/Eigen/Polynomials>

#include <tapestry/autodiff/derivatives.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
template <class S>
using AnySize = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
using Point = std::vector<double>;

/// A matrix of numbers, row by row.
template <class S>
AnySize<S> matrix_of(std::span<const S> x, Eigen::Index rows, Eigen::Index columns) {
  AnySize<S> a(rows, columns);
  for (Eigen::Index i = 0; i < rows * columns; ++i)
    a(i / columns, i % columns) = x[static_cast<std::size_t>(i)];
  return a;
}

/// Richardson-extrapolated central difference of f along x[i], in double, by Eigen's own algorithms.
template <class Function>
double difference(const Function& f, const Point& x, std::size_t i) {
  const auto quotient = [&](double h) {
    Point ahead = x, behind = x;
    ahead[i] += h;
    behind[i] -= h;
    return (f(std::span<const double>(ahead)) - f(std::span<const double>(behind))) / (2 * h);
  };
  return (4 * quotient(0x1p-11) - quotient(0x1p-10)) / 3;
}

/// Slopes on the tape, in duals, and the Hessian's row along x[0], against differences.
template <class Function>
void check_slopes(const Function& f, const Point& x) {
  const auto on_tape = tapestry::gradient<double>(f, std::span<const double>(x));
  CHECK(std::abs(on_tape.value - f(std::span<const double>(x))) <= 1e-13 * (1 + std::abs(on_tape.value)));
  for (std::size_t i = 0; i < x.size(); ++i) {
    INFO("by input " << i);
    const double expected = difference(f, x, i);
    CHECK(std::abs(on_tape.gradient[i] - expected) <= 1e-8 * (1 + std::abs(expected)));
    std::vector<Dual<double>> duals(x.begin(), x.end());
    duals[i] = Dual<double>::input(x[i]);
    CHECK(std::abs(f(std::span<const Dual<double>>(duals)).tangent() - on_tape.gradient[i]) <=
          1e-11 * (1 + std::abs(expected)));
  }
}
template <class Function>
void check_second_slopes(const Function& f, const Point& x) {
  const std::vector<double> second = tapestry::hessian<double>(f, std::span<const double>(x));
  for (std::size_t j = 0; j < x.size(); ++j) {
    const auto slope = [&](std::span<const double> at) {
      return tapestry::gradient<double>(f, at).gradient[j];
    };
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double expected = difference(slope, x, i);
      CHECK(std::abs(second[i * x.size() + j] - expected) <= 1e-7 * (1 + std::abs(expected)));
    }
  }
}

const Point turning = {1, -2, 0.5, 1.5, 0.25, 3, 0, 1, -1};  // one real eigenvalue, and a pair
}  // namespace

TEST_CASE("eigenvalues of any matrix of variables are differentiated", "[autodiff][eigen][spectrum]") {
  const auto of_values = []<class S>(std::span<const S> x) {
    const AnySize<S> a = matrix_of(x, 3, 3);
    const auto values = Eigen::EigenSolver<AnySize<S>>(a).eigenvalues().eval();
    S sum(0);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const S real = values(k).real(), imaginary = values(k).imag();
      sum += real * real * real + (1.0 + real) * imaginary * imaginary;
    }
    return sum;
  };
  check_slopes(of_values, turning);
  check_second_slopes(of_values, turning);
  check_slopes(of_values, {0, 0, 2, 1, 0, -1, 0, 1, 0.5});  // a companion matrix
  check_slopes(of_values, {1, 0, 0, 0, -2, 0, 0, 0, 3});    // diagonal
  check_slopes(of_values, {0, -1, 0, 1, 0, 0, 0, 0, 2});    // a quarter turn
}

TEST_CASE("the eigenvalues of a quarter turn have the slopes of their quadratic",
          "[autodiff][eigen][spectrum]") {
  // λ² − t λ + d = 0: λ̇ = (λ ṫ − ḋ) / (2 λ − t), of ±i at [0 −1; 1 0]
  const Point x = {0, -1, 1, 0}, trace = {1, 0, 0, 1}, determinant = {0, -1, 1, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    std::vector<Dual<double>> duals(x.begin(), x.end());
    duals[i] = Dual<double>::input(x[i]);
    const Eigen::Matrix<Dual<double>, 2, 2> a = matrix_of(std::span<const Dual<double>>(duals), 2, 2);
    const auto values = a.eigenvalues().eval();
    for (Eigen::Index k = 0; k < 2; ++k) {
      const std::complex<double> value(values(k).real().value(), values(k).imag().value());
      const std::complex<double> slope = (value * trace[i] - determinant[i]) / (2.0 * value);
      CHECK(std::abs(values(k).real().tangent() - slope.real()) <= 1e-15);
      CHECK(std::abs(values(k).imag().tangent() - slope.imag()) <= 1e-15);
    }
  }
}

TEST_CASE("eigenvectors of any matrix of variables are differentiated but for their phase",
          "[autodiff][eigen][spectrum]") {
  for (Eigen::Index k = 0; k < 3; ++k) {
    const auto of_vectors = [k]<class S>(std::span<const S> x) {
      const AnySize<S> a = matrix_of(x, 3, 3);
      const auto vectors = Eigen::EigenSolver<AnySize<S>>(a).eigenvectors().eval();
      const auto ratio = vectors(0, k) / vectors(1, k);
      return S(ratio.real() + 2.0 * ratio.imag() + norm(vectors(2, k)));
    };
    check_slopes(of_vectors, turning);
    if (k == 0) check_second_slopes(of_vectors, turning);
    check_slopes(of_vectors, {0, 0, 2, 1, 0, -1, 0, 1, 0.5});
  }
  const auto of_real_vectors = []<class S>(std::span<const S> x) {  // (1, 1) / √2, and (1, −a) / √(1 + a²)
    const AnySize<S> a = matrix_of(x, 2, 2);
    const auto vectors = Eigen::EigenSolver<AnySize<S>>(a).eigenvectors().eval();
    const auto product = [&](Eigen::Index i, Eigen::Index j, Eigen::Index k) {
      return S(vectors(i, k).real() * vectors(j, k).real());
    };
    return S(product(0, 0, 0) * 3.0 + product(0, 1, 0) + 2.0 * product(0, 1, 1) - product(1, 1, 1));
  };
  check_slopes(of_real_vectors, {1, 2, 0, 3});
}

TEST_CASE("roots of polynomials of variables have their slopes", "[autodiff][eigen][spectrum]") {
  // of Σ cᵢ rⁱ = 0: ∂r / ∂cᵢ = −rⁱ / p′(r)
  for (const Point& c : {Point{-1, 0, 0, 1}, Point{6, -5, 1}, Point{-6, 11, -6, 1}, Point{2, 0, -3, 0, 1},
                         Point{4, 1, 0, 2}}) {
    const auto n = static_cast<Eigen::Index>(c.size());
    ActiveTape<double> tape;
    Eigen::Matrix<Variable<double>, Eigen::Dynamic, 1> coefficients(n);
    for (Eigen::Index i = 0; i < n; ++i) coefficients(i) = tape.input(c[static_cast<std::size_t>(i)]);
    const Eigen::PolynomialSolver<Variable<double>, Eigen::Dynamic> solver(coefficients);
    for (Eigen::Index k = 0; k < n - 1; ++k) {
      const std::complex<double> r(solver.roots()(k).real().value(), solver.roots()(k).imag().value());
      std::complex<double> p = 0, slope = 0;
      for (std::size_t i = c.size(); i-- > 0;) {
        slope = slope * r + p;
        p = p * r + c[i];
      }
      CHECK(std::abs(p) <= 1e-13 * std::abs(slope) * 10.0);
      for (Eigen::Index i = 0; i < n; ++i) {
        const std::complex<double> expected = -std::pow(r, static_cast<int>(i)) / slope;
        tape.reverse(solver.roots()(k).real());
        CHECK(std::abs(coefficients(i).adjoint() - expected.real()) <= 1e-12 * (1 + std::abs(expected)));
        if (!solver.roots()(k).imag().is_active()) continue;
        tape.reverse(solver.roots()(k).imag());
        CHECK(std::abs(coefficients(i).adjoint() - expected.imag()) <= 1e-12 * (1 + std::abs(expected)));
      }
    }
  }
}

TEST_CASE("singular values and vectors by Eigen's name are differentiated", "[autodiff][eigen][spectrum]") {
  for (const unsigned options :
       {0U | Eigen::ComputeThinU | Eigen::ComputeThinV, 0U | Eigen::ComputeFullU | Eigen::ComputeFullV})
    for (const Eigen::Index rows : {2, 3, 1}) {
      if (rows == 1 && (options & Eigen::ComputeFullV) != 0) continue;  // two vectors of a plane, in any turn
      const Eigen::Index columns = rows == 1 ? 3 : 6 / rows;
      const auto of_svd = [=]<class S>(std::span<const S> x) {
        const Eigen::JacobiSVD<AnySize<S>> svd(matrix_of(x, rows, columns), options);
        const AnySize<S> u = svd.matrixU(), v = svd.matrixV();
        S sum = svd.singularValues()(0) * svd.singularValues()(0) * svd.singularValues()(0);
        for (Eigen::Index i = 0; i < u.size(); ++i)
          sum += u(i) * (0.3 * static_cast<double>(i) - 1) + u(i) * u(i);
        for (Eigen::Index i = 0; i < v.size(); ++i) sum += v(i) * (0.7 - 0.2 * static_cast<double>(i)) * v(0);
        return sum;
      };
      const Point some = {1, -2, 0.5, 3, 0.25, -1}, axes = {2, 0, 0, 1, 0, 0}, row = {1, 2, -0.5};
      INFO(rows << " rows, options " << options);
      check_slopes(of_svd, rows == 1 ? row : some);
      if (rows == 2) check_second_slopes(of_svd, some);
      if (rows == 3 && (options & Eigen::ComputeThinU) != 0) check_slopes(of_svd, axes);
    }
}

TEST_CASE("singular values of duals have second derivatives where an entry is 0",
          "[autodiff][eigen][spectrum]") {
  // 2 ± √(1 + r²) of [1 r; r 3], of second derivative ±1 at r = 0, as the eigenvalues
  using D = Dual<double>;
  const Dual<D> r(D::input(0.0), {D(1.0)});
  AnySize<Dual<D>> a(2, 2);
  a << Dual<D>(1.0), r, r, Dual<D>(3.0);
  const auto singular = a.jacobiSvd().singularValues().eval();
  const auto values = Eigen::EigenSolver<AnySize<Dual<D>>>(a).eigenvalues().eval();
  for (Eigen::Index k = 0; k < 2; ++k) {
    const double sign = singular(k).value().value() > 2 ? 1 : -1;
    CHECK(std::abs(singular(k).tangent().tangent() - sign) <= 1e-15);
    const double of_value = values(k).real().value().value() > 2 ? 1 : -1;
    CHECK(std::abs(values(k).real().tangent().tangent() - of_value) <= 1e-15);
  }
}

TEST_CASE("Eigen's geometry that takes singular vectors is differentiated", "[autodiff][eigen][spectrum]") {
  const auto of_umeyama = []<class S>(std::span<const S> x) {
    AnySize<S> from(3, 4), to(3, 4);
    from << S(0.0), S(1.0), S(0.0), S(0.5), S(0.0), S(0.0), S(2.0), S(1.0), S(0.0), S(1.0), S(-1.0), S(3.0);
    for (Eigen::Index i = 0; i < 12; ++i) to(i / 4, i % 4) = x[static_cast<std::size_t>(i)];
    const AnySize<S> found = Eigen::umeyama(from, to, true);
    S sum(0);
    for (Eigen::Index i = 0; i < 12; ++i) sum += found(i / 4, i % 4) * (0.3 * static_cast<double>(i) - 1);
    return sum;
  };
  check_slopes(of_umeyama, {0, 1.5, 0.1, 0, 0.2, 0, 2, 1, 0, 0.7, -1, 3});
  const auto of_rotation = []<class S>(std::span<const S> x) {
    Eigen::Transform<S, 3, Eigen::Affine> transform;
    transform.matrix().setIdentity();
    transform.linear() = matrix_of(x, 3, 3);
    const Eigen::Matrix<S, 3, 3> rotation = transform.rotation();
    return S(rotation(0, 1) + 2.0 * rotation(2, 0) - rotation(1, 1) * rotation(0, 2));
  };
  check_slopes(of_rotation, {2, 0, 0, 0, 1, 0, 0, 0, 3});
  check_slopes(of_rotation, turning);
  const auto of_quaternion = []<class S>(std::span<const S> x) {
    const Eigen::Matrix<S, 3, 1> from(x[0], x[1], x[2]), to(x[3], x[4], x[5]);
    const auto turn = Eigen::Quaternion<S>::FromTwoVectors(from, to);
    return S(turn.w() + 2.0 * turn.x() - turn.y() * turn.z());
  };
  check_slopes(of_quaternion, {1, 0, 0, 0, 1, 0});
  check_slopes(of_quaternion, {1, 2, -0.5, -1, 0.5, 2});
}

TEST_CASE("a half turn of two vectors has no derivatives that pass for known ones",
          "[autodiff][eigen][spectrum]") {
  // of (1, y, z) onto (−1, 0, 0) the axis is (0, −z, y) / √(y² + z²)
  int unknown = 0;
  for (const std::size_t direction : {1U, 2U}) {
    std::vector<Dual<double>> x = {1.0, 0.0, 0.0};
    x[direction] = Dual<double>::input(0.0);
    const Eigen::Matrix<Dual<double>, 3, 1> from(x[0], x[1], x[2]), to(-1.0, 0.0, 0.0);
    const auto turn = Eigen::Quaternion<Dual<double>>::FromTwoVectors(from, to);
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += turn.coeffs()(i).tangent();
    unknown += std::isfinite(sum) ? 0 : 1;
  }
  CHECK(unknown > 0);
}

TEST_CASE("generalised eigenvalues of variables are differentiated", "[autodiff][eigen][spectrum]") {
  const auto of_pair = []<class S>(std::span<const S> x) {
    AnySize<S> a(2, 2), b(2, 2);
    a << x[0], x[1], x[1], x[2];
    b << x[3], x[4], x[4], x[5];
    Eigen::GeneralizedSelfAdjointEigenSolver<AnySize<S>> solver(2);
    solver.compute(a, b);
    return S(solver.eigenvalues()(0) * 2.0 + solver.eigenvectors()(0, 1) * solver.eigenvectors()(1, 1));
  };
  check_slopes(of_pair, {1, 0, 3, 2, 0.5, 4});
  check_slopes(of_pair, {1, -2, 3, 2, 0, 4});
}

TEST_CASE("a tridiagonal form of three rows has the derivatives of zeros", "[autodiff][eigen][spectrum]") {
  const auto of_form = []<class S>(std::span<const S> x) {
    Eigen::Matrix<S, 3, 3> a;
    a << x[0], x[1], x[2], x[1], x[3], x[4], x[2], x[4], x[5];
    const Eigen::Tridiagonalization<Eigen::Matrix<S, 3, 3>> form(a);
    return S(form.diagonal()(1) + 2.0 * form.subDiagonal()(0) * form.subDiagonal()(0) +
             3.0 * form.diagonal()(2));
  };
  check_slopes(of_form, {1, 2, 0, 3, -1, 5});
  check_slopes(of_form, {1, 2, 1, 3, -1, 5});
}
