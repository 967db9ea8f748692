#include <tapestry/autodiff/eigen.hpp>
#include <tapestry/autodiff/eigen_derivatives.hpp>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
template <class S>
using Matrix3 = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;  // of 3 × 3, without unrolled loops
template <class S>
using Vector3 = Eigen::Matrix<S, Eigen::Dynamic, 1>;

/// A well-conditioned matrix and a right side out of twelve numbers.
template <class S>
Matrix3<S> matrix_of(const std::vector<S>& x) {
  Matrix3<S> a(3, 3);
  for (Eigen::Index i = 0; i < 9; ++i) a(i / 3, i % 3) = x[static_cast<std::size_t>(i)];
  for (Eigen::Index i = 0; i < 3; ++i) a(i, i) += 4.0;
  return a;
}
template <class S>
Vector3<S> side_of(const std::vector<S>& x) {
  Vector3<S> b(3);
  b << x[9], x[10], x[11];
  return b;
}

std::vector<double> some_entries() {
  std::vector<double> x;
  for (int i = 0; i < 12; ++i) x.push_back(0.3 * static_cast<double>((i * 7) % 11) - 1.1);
  return x;
}

/// The gradient of f on the tape against Richardson-extrapolated central differences in double.
template <class Function>
void check_on_tape(const Function& f, const std::vector<double>& x0 = some_entries()) {
  ActiveTape<double> tape;
  std::vector<Variable<double>> x;
  for (const double entry : x0) x.push_back(tape.input(entry));
  const Variable<double> root = f(x);
  tape.reverse(root);
  CHECK(std::abs(root.value() - f(x0)) <= 1e-13 * std::abs(f(x0)));
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto quotient = [&](double h) {
      auto ahead = x0, behind = x0;
      ahead[i] += h;
      behind[i] -= h;
      return (f(ahead) - f(behind)) / (2 * h);
    };
    CHECK(std::abs(x[i].adjoint() - (4 * quotient(0x1p-11) - quotient(0x1p-10)) / 3) <= 1e-9);
  }
}
}  // namespace

TEST_CASE("products of matrices of variables are differentiated", "[autodiff][eigen]") {
  check_on_tape([]<class S>(const std::vector<S>& x) {
    const Matrix3<S> a = matrix_of(x);
    const Vector3<S> b = side_of(x);
    const Matrix3<S> c = a * a.transpose() - 2.0 * a + Matrix3<S>::Identity(3, 3);
    return S((c * b).squaredNorm() + c.trace() + a.determinant() + b.norm() + b.normalized().dot(a.col(1)) +
             a.cwiseAbs().maxCoeff() + (a.array() / 4.0).exp().sum());
  });
}

TEST_CASE("an LU decomposition of variables is differentiated", "[autodiff][eigen]") {
  check_on_tape([]<class S>(const std::vector<S>& x) {
    const Matrix3<S> a = matrix_of(x);
    return S(a.partialPivLu().solve(side_of(x)).squaredNorm() + a.inverse().sum());
  });
}

TEST_CASE("a QR decomposition of variables is differentiated", "[autodiff][eigen]") {
  check_on_tape([]<class S>(const std::vector<S>& x) {
    return S(matrix_of(x).householderQr().solve(side_of(x)).squaredNorm());
  });
}

TEST_CASE("Cholesky decompositions of variables are differentiated", "[autodiff][eigen]") {
  check_on_tape([]<class S>(const std::vector<S>& x) {
    const Matrix3<S> a = matrix_of(x);
    const Matrix3<S> positive = a * a.transpose();
    return S(positive.llt().solve(side_of(x)).squaredNorm() + positive.ldlt().solve(side_of(x)).sum());
  });
}

TEST_CASE("eigenvalues and vectors of variables are differentiated", "[autodiff][eigen]") {
  check_on_tape([]<class S>(const std::vector<S>& x) {
    const Matrix3<S> a = matrix_of(x);
    const Matrix3<S> symmetric = a + a.transpose();
    const Eigen::SelfAdjointEigenSolver<Matrix3<S>> solver(symmetric);
    const Vector3<S> turned = solver.eigenvectors().transpose() * side_of(x);
    return S(exp(solver.eigenvalues()(0) / 8) + solver.eigenvalues()(2) * turned(1) * turned(1));
  });
}

TEST_CASE("an eigenvalue's slope is that of its vectors, by the lower triangle", "[autodiff][eigen]") {
  using Matrix5 = Eigen::MatrixXd;
  Matrix5 a(5, 5);
  for (Eigen::Index i = 0; i < 25; ++i) a(i / 5, i % 5) = 0.1 * static_cast<double>((i * 7) % 19) - 0.9;
  const Matrix5 symmetric = (a * a.transpose()).array() + 2;
  const Eigen::SelfAdjointEigenSolver<Matrix5> solver_of_numbers(symmetric);
  ActiveTape<double> tape;
  Matrix3<Variable<double>> x(5, 5);
  for (Eigen::Index i = 0; i < 25; ++i) x(i / 5, i % 5) = tape.input(symmetric(i / 5, i % 5));
  const Eigen::SelfAdjointEigenSolver<Matrix3<Variable<double>>> solver(x);
  tape.reverse(solver.eigenvalues()(4));
  const Eigen::VectorXd v = solver_of_numbers.eigenvectors().col(4);
  for (Eigen::Index i = 0; i < 5; ++i)
    for (Eigen::Index j = 0; j < 5; ++j)
      CHECK(std::abs(x(i, j).adjoint() - (i < j ? 0 : i == j ? 1 : 2) * v(i) * v(j)) <= 1e-12);
}

namespace {
/// Entries of exact zeros on a matrix of 2.5, 3.5 and 5.5, and a right side.
std::vector<double> diagonal_entries() { return {-1.5, 0, 0, 0, -0.5, 0, 0, 0, 1.5, 0.25, -0.5, 1}; }
}  // namespace

TEST_CASE("decompositions of variables are differentiated at entries that are exactly 0",
          "[autodiff][eigen]") {
  std::vector<double> upper = diagonal_entries(), equal = diagonal_entries();
  upper[1] = 2;
  upper[5] = -3;
  equal[4] = equal[0];
  for (const auto& point : {diagonal_entries(), upper, equal}) {
    const auto check = [&](const auto& solve) {
      check_on_tape(
          [&]<class S>(const std::vector<S>& x) {
            return S(Vector3<S>(solve(matrix_of(x)).solve(side_of(x))).squaredNorm());
          },
          point);
    };
    check([](const auto& a) { return a.partialPivLu(); });
    check([](const auto& a) { return a.fullPivLu(); });
    check([](const auto& a) { return a.householderQr(); });
    check([](const auto& a) { return a.colPivHouseholderQr(); });
    check([](const auto& a) { return a.fullPivHouseholderQr(); });
    check([](const auto& a) { return a.completeOrthogonalDecomposition(); });
  }
  for (const auto& point : {diagonal_entries(), equal})
    check_on_tape(
        []<class S>(const std::vector<S>& x) {
          const Matrix3<S> a = matrix_of(x), symmetric = a + a.transpose();
          const Vector3<S> b = side_of(x);
          return S(Vector3<S>(symmetric.llt().solve(b)).squaredNorm() + symmetric.ldlt().solve(b).sum());
        },
        point);
  check_on_tape(
      []<class S>(const std::vector<S>& x) {  // bᵀ exp(A + Aᵀ) b
        const Matrix3<S> a = matrix_of(x), symmetric = (a + a.transpose()) / 8.0;
        const Eigen::SelfAdjointEigenSolver<Matrix3<S>> solver(symmetric);
        const Vector3<S> turned = solver.eigenvectors().transpose() * side_of(x);
        return S((solver.eigenvalues().array().exp() * turned.array().square()).sum());
      },
      diagonal_entries());
}

TEST_CASE("least squares by QR of variables are differentiated at a column of the axis",
          "[autodiff][eigen]") {
  // |A⁺ b|² of A = [1 0; 0 2; p q; 0 0]: at p = q = 0, x = (b₀, b₁ / 2), r = b₂, and by the normal equations
  // dx = (AᵀA)⁻¹ (dAᵀ r): 2 x₀ r by p, 2 x₁ r / 4 by q.
  ActiveTape<double> tape;
  const Variable<double> p = tape.input(0.0), q = tape.input(0.0);
  const auto check = [&](const auto& decompose) {
    Matrix3<Variable<double>> a = Matrix3<double>::Zero(4, 2).cast<Variable<double>>();
    a(0, 0) = 1.0;
    a(1, 1) = 2.0;
    a(2, 0) = p;
    a(2, 1) = q;
    Vector3<Variable<double>> b(4);
    b << 3.0, 8.0, 0.5, 7.0;
    const Variable<double> root = Vector3<Variable<double>>(decompose(a).solve(b)).squaredNorm();
    CHECK(std::abs(root.value() - 25) <= 1e-13);
    tape.reverse(root);
    CHECK(std::abs(p.adjoint() - 3) <= 1e-14);
    CHECK(std::abs(q.adjoint() - 1) <= 1e-14);
  };
  check([](const auto& a) { return a.householderQr(); });
  check([](const auto& a) { return a.colPivHouseholderQr(); });
  check([](const auto& a) { return a.fullPivHouseholderQr(); });
  check([](const auto& a) { return a.completeOrthogonalDecomposition(); });
}

TEST_CASE("eigenvalues of duals have second derivatives where an entry is 0", "[autodiff][eigen]") {
  // λ of [1 r; r 3]: 2 ± √(1 + r²), of second derivative ±1 at r = 0. The vector of 3 turns by r / 2.
  using D = Dual<double>;
  using Second = Dual<D>;
  const Second r(D::input(0.0), {D(1.0)});
  Matrix3<Second> a(2, 2);
  a << Second(1.0), r, r, Second(3.0);
  const Eigen::SelfAdjointEigenSolver<Matrix3<Second>> solver(a);
  CHECK(solver.eigenvalues()(0).value().value() == 1);
  CHECK(solver.eigenvalues()(0).tangent().value() == 0);
  CHECK(std::abs(solver.eigenvalues()(0).tangent().tangent() + 1) <= 1e-15);
  CHECK(std::abs(solver.eigenvalues()(1).tangent().tangent() - 1) <= 1e-15);
  const Second slope = solver.eigenvectors()(0, 1) / solver.eigenvectors()(1, 1);
  CHECK(std::abs(slope.tangent().value() - 0.5) <= 1e-15);
}

TEST_CASE("matrices of duals carry derivatives through a decomposition", "[autodiff][eigen]") {
  using D = Dual<double>;
  // d/dt (tI)⁻¹ b = −b / t².
  Matrix3<D> a = Matrix3<D>::Identity(3, 3) * D::input(2.0);
  Vector3<D> b(3);
  b << D(1.0), D(2.0), D(4.0);
  const Vector3<D> x = a.partialPivLu().solve(b);
  CHECK(x(2).value() == 2);
  CHECK(x(2).tangent() == -1);
}

TEST_CASE("matrices of numbers and of variables are multiplied, of any size", "[autodiff][eigen]") {
  using Numbers = Eigen::MatrixXd;
  using Variables = Eigen::Matrix<Variable<double>, Eigen::Dynamic, Eigen::Dynamic>;
  for (const Eigen::Index n : {0, 1, 3, 40}) {
    const Numbers a = Numbers::Random(n + 1, n), b = Numbers::Random(n, n + 2),
                  c = Numbers::Random(n + 1, n + 2);
    ActiveTape<double> tape;
    const Variables x = a.unaryExpr([&](double value) { return tape.input(value); });
    const Variables y = b.unaryExpr([&](double value) { return tape.input(value); });
    Variables sum = x * b;
    sum.noalias() += a * y;
    sum.col(0) += x * b.col(0) + a * y.col(0);
    Variable<double> loss(0);
    for (Eigen::Index i = 0; i < sum.size(); ++i) loss += c(i) * sum(i);
    tape.reverse(loss);
    Numbers weights = c;  // of a b
    weights.col(0) *= 2;
    CHECK(loss.value() == Approx(2 * (weights.array() * (a * b).array()).sum()).margin(1e-12));
    const auto adjoint_of = [](const Variable<double>& variable) { return variable.adjoint(); };
    const Numbers of_a = weights * b.transpose(), of_b = a.transpose() * weights;
    CHECK((x.unaryExpr(adjoint_of) - of_a).lpNorm<Eigen::Infinity>() <= 1e-12);
    CHECK((y.unaryExpr(adjoint_of) - of_b).lpNorm<Eigen::Infinity>() <= 1e-12);
  }
}

TEST_CASE("derivatives of functions of Eigen vectors have their shapes", "[autodiff][eigen]") {
  // ½ xᵀ A x + Σ sin xᵢ: gradient A x + cos x, Hessian A − diag(sin x), for a symmetric A
  const Eigen::Matrix3d a = (Eigen::Matrix3d() << 4, 1, -2, 1, 3, .5, -2, .5, 5).finished();
  const auto f = [&]<class X>(const X& x) {
    typename X::Scalar total = .5 * x.dot(a * x);
    for (Eigen::Index i = 0; i < x.size(); ++i) total += sin(x[i]);
    return total;
  };
  const Eigen::Vector3d x(.3, -1.2, 2);
  const Eigen::Vector3d slope = a * x + x.array().cos().matrix();
  const Eigen::Matrix3d curvature = a - Eigen::Matrix3d(x.array().sin().matrix().asDiagonal());
  const auto found = tapestry::gradient(f, x);
  CHECK(found.value == Approx(.5 * x.dot(a * x) + x.array().sin().sum()));
  CHECK((found.gradient - slope).norm() < 1e-14);
  const Eigen::Matrix3d second = tapestry::hessian(f, x);
  CHECK((second - curvature).norm() < 1e-14);
  const Eigen::VectorXd any_size = x;
  CHECK(tapestry::gradient(f, any_size).gradient == found.gradient);
  CHECK(tapestry::hessian(f, 2 * (any_size / 2)) == second);               // an expression
  const auto form = [&](const auto& y) { return y.transpose() * a * y; };  // one entry
  CHECK((tapestry::gradient(form, x).gradient - 2 * a * x).norm() < 1e-14);
  CHECK((tapestry::hessian(form, x) - 2 * a).norm() < 1e-14);

  const auto wide = [](const auto& y) { return (y.head(2) * y[2]).eval(); };  // 2 × 3
  const auto tall = []<class Y>(const Y& y) {                                 // 6 × 3
    Eigen::Matrix<typename Y::Scalar, Eigen::Dynamic, 1> twice(2 * y.size());
    twice << y * y.sum(), y * y.sum();
    return twice;
  };
  Eigen::MatrixXd expected_wide(2, 3);
  expected_wide << x[2], 0, x[0], 0, x[2], x[1];
  CHECK(tapestry::jacobian(wide, x) == expected_wide);
  const Eigen::MatrixXd of_tall = tapestry::jacobian(tall, any_size);
  REQUIRE((of_tall.rows() == 6 && of_tall.cols() == 3));
  const Eigen::Matrix3d half = x * Eigen::RowVector3d::Ones() + x.sum() * Eigen::Matrix3d::Identity();
  CHECK((of_tall.topRows(3) - half).norm() < 1e-15);
  CHECK(of_tall.topRows(3) == of_tall.bottomRows(3));
  CHECK(tapestry::gradient([](const auto& y) { return y.sum(); }, Eigen::VectorXd(0)).gradient.size() == 0);
}

TEST_CASE("the Jacobian of recorded Eigen vectors is an Eigen matrix", "[autodiff][eigen]") {
  ActiveTape<double> tape;
  Eigen::Matrix<tapestry::Variable<double>, 2, 1> x;
  x << tape.input(2), tape.input(3);
  const Eigen::Matrix<tapestry::Variable<double>, Eigen::Dynamic, 1> y = x * x[1];
  const Eigen::MatrixXd found = tapestry::jacobian(tape, y, x);
  CHECK(found == (Eigen::Matrix2d() << 3, 2, 0, 6).finished());
}

namespace {
/// (3, −4, 0) · scale has the norm 5 · scale, with the slopes 3/5, −4/5 and 0.
template <class Norm>
void check_norm(double scale, double digits, const Norm& norm) {
  CAPTURE(scale);
  const Eigen::Vector3d x(3 * scale, -4 * scale, 0);
  const auto found = tapestry::gradient(norm, x);
  CHECK(std::abs(found.value / scale - 5) <= 5 * digits);
  CHECK((found.gradient - Eigen::Vector3d(0.6, -0.8, 0)).norm() <= digits);
}
}  // namespace

TEST_CASE("Eigen's stable norms of variables are the norm, also where squares leave the range",
          "[autodiff][eigen]") {
  const auto stable = [](const auto& x) { return x.stableNorm(); };
  for (const double scale :
       {1.0, 0.1, 1e-200, 1e200, 1e-300, 3e307}) {  // 3e307: the largest double is 1.8e308
    check_norm(scale, 1e-15, stable);
    check_norm(scale, 1e-15, [](const auto& x) { return x.blueNorm(); });
    check_norm(scale, 1e-15, [](const auto& x) { return x.hypotNorm(); });
    check_norm(scale, 1e-15, [](const auto& x) { return (x / 2 + x / 2).stableNorm(); });
    check_norm(scale, 1e-15, [](const auto& x) { return x.transpose().stableNorm(); });
  }
  check_norm(1e-310, 1e-13, stable);  // of 4.9e-324, the step between such numbers
  CHECK(tapestry::gradient(stable, Eigen::Matrix<double, 1, 1>(-2.0)).gradient[0] == -1);
}

TEST_CASE("Eigen's stable norm of variables has slopes of 0 at zero, as the norm has", "[autodiff][eigen]") {
  for (const Eigen::Index size : {0, 1, 3}) {
    const auto found =
        tapestry::gradient([](const auto& x) { return x.stableNorm(); }, Eigen::VectorXd::Zero(size).eval());
    CHECK(found.value == 0);
    CHECK(found.gradient == Eigen::VectorXd::Zero(size));
  }
}

TEST_CASE("Eigen's stable norm of a matrix of variables joins columns of any size", "[autodiff][eigen]") {
  const auto norm = [](const auto& x) {  // of 3 × 2
    return x.reshaped(3, 2).eval().stableNorm();
  };
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Vector6 plain(1, 2, 0, -4, 6, 8), slopes = plain / 11;  // 1 + 4 + 16 + 36 + 64 = 121
  CHECK((tapestry::gradient(norm, plain).gradient - slopes).norm() < 1e-15);
  const Vector6 rising = (Vector6() << 3e-200, 0, 0, 0, -2e200, 0).finished();
  CHECK(tapestry::gradient(norm, rising).value == 2e200);
  CHECK((tapestry::gradient(norm, rising).gradient - Vector6::Unit(4) * -1).norm() == 0);
  const Vector6 falling = rising.reverse();
  CHECK((tapestry::gradient(norm, falling).gradient - Vector6::Unit(1) * -1).norm() == 0);
}

TEST_CASE("the curvature of Eigen's stable norm is that of a sphere, also in duals", "[autodiff][eigen]") {
  for (const double scale : {1.0, 1e100, 1e-100}) {  // (1 − n nᵀ) / |x|
    const Eigen::Vector3d x(3 * scale, -4 * scale, 0), n = x / (5 * scale);
    const Eigen::Matrix3d expected = (Eigen::Matrix3d::Identity() - n * n.transpose()) / 5;
    const Eigen::Matrix3d found = tapestry::hessian([](const auto& y) { return y.stableNorm(); }, x);
    CHECK((found * scale - expected).norm() < 1e-15);
  }
}

TEST_CASE("Eigen's stable norm of variables takes infinities and NaN along", "[autodiff][eigen]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto value = [](double first, double second) {
    ActiveTape<double> tape;
    Vector3<Variable<double>> x(2);
    x << tape.input(first), tape.input(second);
    return x.stableNorm().value();
  };
  CHECK(value(1, -infinity) == infinity);
  CHECK(std::isnan(value(1, std::nan(""))));
  CHECK(std::isnan(value(std::nan(""), 1)));
}
