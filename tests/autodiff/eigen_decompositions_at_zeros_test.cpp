#include <Eigen/Dense>

#include "zero_patterns.hpp"

using namespace tapestry::test;
using tapestry::Dual;

namespace {
/// The symmetric matrix of a lower triangle.
template <class A>
auto symmetric(const A& a) {
  auto result = a.eval();
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < i; ++j) result(j, i) = a(i, j);
  return result;
}
}  // namespace

TEST_CASE("LU decompositions have all derivatives at every pattern of zeros", "[autodiff][eigen][zeros]") {
  const auto systems = general_systems();
  check_solves("partialPivLu", systems,
               [](const auto& a, const auto& b) { return a.partialPivLu().solve(b).eval(); });
  check_solves("fullPivLu", systems,
               [](const auto& a, const auto& b) { return a.fullPivLu().solve(b).eval(); });
  check_solves("inverse", systems, [](const auto& a, const auto& b) { return (a.inverse() * b).eval(); });
}

TEST_CASE("QR decompositions have all derivatives at every pattern of zeros", "[autodiff][eigen][zeros]") {
  const auto systems = general_systems();
  check_solves("householderQr", systems,
               [](const auto& a, const auto& b) { return a.householderQr().solve(b).eval(); });
  check_solves("colPivHouseholderQr", systems,
               [](const auto& a, const auto& b) { return a.colPivHouseholderQr().solve(b).eval(); });
  check_solves("fullPivHouseholderQr", systems,
               [](const auto& a, const auto& b) { return a.fullPivHouseholderQr().solve(b).eval(); });
  check_solves("completeOrthogonalDecomposition", systems, [](const auto& a, const auto& b) {
    return a.completeOrthogonalDecomposition().solve(b).eval();
  });
}

TEST_CASE("Cholesky decompositions have all derivatives at every pattern of zeros",
          "[autodiff][eigen][zeros]") {
  const auto systems = diagonal_systems({4, 1, -2, 0.5, 8, 1, -1, 2, 16});
  const auto equation = [](const AnySize<Slopes>& a) { return symmetric(a); };
  check_solves("llt", systems, equation,
               [](const auto& a, const auto& b) { return symmetric(a).llt().solve(b).eval(); });
  check_solves("ldlt", systems, equation,
               [](const auto& a, const auto& b) { return symmetric(a).ldlt().solve(b).eval(); });
}

TEST_CASE("a QR decomposition has the derivatives of a solution that rounds to 0",
          "[autodiff][eigen][zeros]") {
  const System system{3, {-.119254, 2, 0, 0, 0, .5, 1.43013, 1.14789, 2, -.216883, 0, .582933}, false};
  const Sides<Slopes, Eigen::Dynamic, 1> sides(system, duals_of(system));
  const auto x = sides.a.householderQr().solve(sides.b).eval();
  CHECK(std::abs(x(0).tangent(4) + 0.2143) < 1e-3);
  CHECK(std::abs(x(0).tangent(4) - eliminate(sides.a, sides.b)(0, 0).tangent(4)) < 1e-12);
}

namespace {
template <class S>
S determinant_by_rows(const AnySize<S>& a) {
  return S(a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) -
           a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
           a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0)));
}
}  // namespace

TEST_CASE("determinants have all derivatives at every pattern of zeros, of singular matrices, too",
          "[autodiff][eigen][zeros]") {
  using D = Dual<double, 9>;
  using Second = Dual<D, 9>;
  const std::array<double, 9> numbers = {4, 1, -2, 0.5, 8, 1, -16, 2, 4};
  int wrong = 0;
  for (unsigned pattern = 0; pattern < 512; ++pattern) {
    AnySize<Second> a(3, 3);
    for (unsigned k = 0; k < 9; ++k) {
      a(k / 3, k % 3) = Second::input(D::input((pattern >> k & 1U) != 0 ? numbers[k] : 0.0, k), k);
    }
    const Second found = a.determinant(), expected = determinant_by_rows(a);
    const auto compare = [&](double x, double y) {
      wrong += std::abs(x - y) <= 1e-11 * (1 + std::abs(y)) ? 0 : 1;
    };
    compare(found.value().value(), expected.value().value());
    for (unsigned i = 0; i < 9; ++i) {
      compare(found.tangent(i).value(), expected.tangent(i).value());
      for (unsigned j = 0; j < 9; ++j) compare(found.tangent(i).tangent(j), expected.tangent(i).tangent(j));
    }
  }
  CHECK(wrong == 0);
}

TEST_CASE("decompositions of complex variables have the derivatives of zeros", "[autodiff][eigen][zeros]") {
  // ẋ = A⁻¹ (ḃ − Ȧ x), in numbers
  using D = Dual<double>;
  using Complex = std::complex<D>;
  Eigen::Matrix2cd a, a_slope;
  a << 4.0, 0.0, 1.0, std::complex<double>(0, 3);
  a_slope << 0.0, std::complex<double>(0, 2), 0.5, 1.0;
  const Eigen::Vector2cd b(0, 1), b_slope(std::complex<double>(1, -1), 0),
      x = a.inverse() * b, expected = a.inverse() * (b_slope - a_slope * x);
  const auto entry = [](std::complex<double> value, std::complex<double> slope) {
    return Complex(D(value.real(), {slope.real()}), D(value.imag(), {slope.imag()}));
  };
  AnySize<Complex> left(2, 2);
  Eigen::Matrix<Complex, Eigen::Dynamic, 1> right(2);
  for (Eigen::Index i = 0; i < 2; ++i) {
    right(i) = entry(b(i), b_slope(i));
    for (Eigen::Index j = 0; j < 2; ++j) left(i, j) = entry(a(i, j), a_slope(i, j));
  }
  const auto check = [&](const Eigen::Matrix<Complex, Eigen::Dynamic, 1>& found) {
    for (Eigen::Index i = 0; i < 2; ++i) {
      CHECK(std::abs(found(i).real().tangent() - expected(i).real()) <= 1e-14);
      CHECK(std::abs(found(i).imag().tangent() - expected(i).imag()) <= 1e-14);
    }
  };
  check(left.partialPivLu().solve(right));
  check(left.householderQr().solve(right));
}

TEST_CASE("rotations and rank updates have the derivatives of zeros", "[autodiff][eigen][zeros]") {
  using D = Dual<double, 2>;
  for (const auto& [p, q] :
       {std::pair(3.0, 0.0), {-3.0, 0.0}, {0.0, 2.0}, {0.0, -2.0}, {3.0, -4.0}, {1.0, 2.0}}) {
    const D x = D::input(p, 0), y = D::input(q, 1), length = sqrt(x * x + y * y);
    Eigen::JacobiRotation<D> rotation;
    D r;
    rotation.makeGivens(x, y, &r);
    AnySize<D> turned = AnySize<D>::Identity(2, 2);
    turned.applyOnTheLeft(0, 1, rotation.adjoint());  // its first row (p, q) / r
    for (std::size_t k = 0; k < 2; ++k) {
      CHECK(std::abs(r.tangent(k) - length.tangent(k)) <= 1e-15);
      CHECK(std::abs(turned(0, 0).tangent(k) - D(x / length).tangent(k)) <= 1e-15);
      CHECK(std::abs(turned(0, 1).tangent(k) - D(y / length).tangent(k)) <= 1e-15);
    }
  }
  for (const auto& [p, q] : {std::pair(1.0, 0.0), {0.0, 1.0}, {0.0, 0.0}}) {
    AnySize<D> a(2, 2);
    a << D(4.0), D(0.0), D(0.0), D(9.0);
    Eigen::Matrix<D, Eigen::Dynamic, 1> v(2);
    v << D::input(p, 0), D::input(q, 1);
    Eigen::LLT<AnySize<D>> updated(a);
    updated.rankUpdate(v);
    const AnySize<D> found = updated.matrixL(), expected = AnySize<D>(a + v * v.transpose()).llt().matrixL();
    for (Eigen::Index i = 0; i < 4; ++i)
      for (std::size_t k = 0; k < 2; ++k)
        CHECK(std::abs(found(i).tangent(k) - expected(i).tangent(k)) <= 1e-15);
  }
  // The rotation that makes [x y; y z] diagonal turns by y / (x − z), to first order.
  Eigen::JacobiRotation<D> turn;
  turn.makeJacobi(D(3.0), D::input(0.0), D(1.0));
  CHECK(std::abs(std::abs(turn.s().tangent()) - 0.5) <= 1e-15);
  AnySize<D> symmetric_one(2, 2);
  symmetric_one << D(3.0), D::input(0.0), D::input(0.0), D(1.0);
  symmetric_one.applyOnTheLeft(0, 1, turn.adjoint());
  symmetric_one.applyOnTheRight(0, 1, turn);
  CHECK(std::abs(symmetric_one(0, 1).tangent()) <= 1e-15);
  CHECK(std::abs(symmetric_one(1, 0).tangent()) <= 1e-15);
}
