#include <tapestry/autodiff/matrix/solve.hpp>

#include <tapestry/autodiff/detail/matrix/product.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>

#include "matrix_gradient.hpp"

namespace matrix = tapestry::matrix;
using Eigen::Lower, Eigen::MatrixXd, Eigen::Upper, tapestry::Array, tapestry::ArrayVariable,
    tapestry::NumericError, tapestry::ShapeError, tapestry::Variable, tapestry::test::ActiveTape,
    tapestry::test::check_gradient_of, tapestry::test::LongMatrix, tapestry::test::MatrixOf,
    tapestry::test::random_matrix, tapestry::test::random_positive_definite;

namespace {
/// Every gradient here is of order one to ten and comes from at most 100 sums of 100 terms.
constexpr double bound = 1e-12;

MatrixXd well_conditioned(Eigen::Index n, std::uint64_t seed) {
  return random_matrix(n, n, seed) + 2 * std::sqrt(static_cast<double>(n)) * MatrixXd::Identity(n, n);
}
LongMatrix symmetric(const LongMatrix& a) { return a.selfadjointView<Lower>(); }
}  // namespace

TEST_CASE("solve has the gradient of differences in long double, whatever the extents",
          "[autodiff][matrix]") {
  const auto f = [](const auto& a, const auto& b) { return matrix::solve(a, b); };
  const auto reference = [](const LongMatrix& a, const LongMatrix& b) {
    return LongMatrix(a.partialPivLu().solve(b));
  };
  check_gradient_of(f, reference, bound, well_conditioned(1, 1), random_matrix(1, 1, 2));
  check_gradient_of(f, reference, bound, well_conditioned(7, 3), random_matrix(7, 3, 4));
  check_gradient_of(f, reference, bound, well_conditioned(5, 5).colwise().reverse().eval(),
                    random_matrix(5, 1, 6));  // needs every exchange of rows
}

TEST_CASE("solve_positive_definite reads the lower triangle, which has all of the gradient",
          "[autodiff][matrix]") {
  const auto f = [](const auto& a, const auto& b) { return matrix::solve_positive_definite(a, b); };
  const auto reference = [](const LongMatrix& a, const LongMatrix& b) {
    return LongMatrix(symmetric(a).llt().solve(b));
  };
  check_gradient_of(f, reference, bound, random_positive_definite(1, 1), random_matrix(1, 2, 2));
  check_gradient_of(f, reference, bound, random_positive_definite(7, 3), random_matrix(7, 3, 4));
}

TEST_CASE("solve_triangular reads one triangle, which has all of the gradient", "[autodiff][matrix]") {
  check_gradient_of(
      [](const auto& a, const auto& b) { return matrix::solve_triangular(a, b, matrix::Triangle::lower); },
      [](const LongMatrix& a, const LongMatrix& b) { return LongMatrix(a.triangularView<Lower>().solve(b)); },
      bound, well_conditioned(6, 1), random_matrix(6, 2, 2));
  check_gradient_of(
      [](const auto& a, const auto& b) { return matrix::solve_triangular(a, b, matrix::Triangle::upper); },
      [](const LongMatrix& a, const LongMatrix& b) { return LongMatrix(a.triangularView<Upper>().solve(b)); },
      bound, well_conditioned(6, 3), random_matrix(6, 2, 4));
}

TEST_CASE("inverse and log-determinants have the gradients of differences in long double",
          "[autodiff][matrix]") {
  for (const Eigen::Index n : {1, 2, 7}) {
    check_gradient_of([](const auto& a) { return matrix::inverse(a); },
                      [](const LongMatrix& a) { return LongMatrix(a.partialPivLu().inverse()); }, bound,
                      well_conditioned(n, 1));
    check_gradient_of([](const auto& a) { return matrix::log_determinant(a); },
                      [](const LongMatrix& a) { return std::log(std::abs(a.determinant())); }, bound,
                      MatrixXd(-well_conditioned(n, 2)));  // the determinant is negative for odd extents
    check_gradient_of([](const auto& a) { return matrix::log_determinant_positive_definite(a); },
                      [](const LongMatrix& a) { return std::log(symmetric(a).determinant()); }, bound,
                      random_positive_definite(n, 3));
  }
}

TEST_CASE("cholesky has the gradient of differences in long double, in one block and in several",
          "[autodiff][matrix][long]") {
  for (const Eigen::Index n : {1, 2, 16, 17, 40})
    check_gradient_of([](const auto& a) { return matrix::cholesky(a); },
                      [](const LongMatrix& a) { return LongMatrix(symmetric(a).llt().matrixL()); }, bound,
                      random_positive_definite(n, 5));
}

TEST_CASE("gradients of 100 x 100 have twelve digits along a direction", "[autodiff][matrix]") {
  constexpr Eigen::Index n = 100;
  const MatrixXd a = random_positive_definite(n, 1), side = random_matrix(n, 1, 2);
  const MatrixXd half = random_matrix(n, n, 3) / n, direction = half + half.transpose();
  const auto check = [&](const auto& f, const auto& reference) {
    const auto at = tapestry::test::Matrices<1>{a};
    const auto along = [&](long double t) {
      return tapestry::test::weighted(
          reference(LongMatrix(a.cast<long double>() + t * direction.cast<long double>())));
    };
    const auto quotient = [&](long double h) { return (along(h) - along(-h)) / (2 * h); };
    const long double h = 0x1p-9L, whole = quotient(h), halved = quotient(h / 2), quarter = quotient(h / 4);
    const long double first = (4 * halved - whole) / 3, second = (4 * quarter - halved) / 3;
    const auto expected = static_cast<double>((16 * second - first) / 15);
    const double found = tapestry::test::gradient_by_arrays(f, at)[0].cwiseProduct(direction).sum();
    CHECK(std::abs(found - expected) <= bound * std::abs(expected));
  };
  const LongMatrix long_side = side.cast<long double>();
  check([&](const auto& x) { return matrix::solve(x, side); },
        [&](const LongMatrix& x) { return LongMatrix(x.partialPivLu().solve(long_side)); });
  check([](const auto& x) { return matrix::cholesky(x); },
        [](const LongMatrix& x) { return LongMatrix(x.llt().matrixL()); });
  check([](const auto& x) { return matrix::log_determinant(x); },
        [](const LongMatrix& x) { return LongMatrix(x.llt().matrixL()).diagonal().array().log().sum() * 2; });
}

TEST_CASE("product takes rectangles, and has the gradient of both sides", "[autodiff][matrix]") {
  const MatrixXd a0 = random_matrix(3, 5, 1), b0 = random_matrix(5, 2, 2);
  const tapestry::test::Matrices<2> at{a0, b0};
  const auto gradient = tapestry::test::gradient_by_entries(
      [](const auto& a, const auto& b) { return matrix::product(a, b); }, at);
  MatrixXd weights(3, 2);
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 2; ++j)
      weights(i, j) = tapestry::test::weight_of(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  CHECK((gradient[0] - weights * b0.transpose()).cwiseAbs().maxCoeff() <= 1e-15);
  CHECK((gradient[1] - a0.transpose() * weights).cwiseAbs().maxCoeff() <= 1e-15);
  const MatrixOf<Variable<double>> passive = b0.cast<Variable<double>>();
  CHECK_THROWS_WITH(matrix::product(b0, passive), "product: b is [5, 2], expected 2 rows for a [5, 2]");
  const MatrixOf<Variable<double>> none = matrix::product(MatrixXd(2, 0), MatrixOf<Variable<double>>(0, 3));
  CHECK(none.rows() == 2);
  CHECK(none(1, 2).value() == 0);
}

TEST_CASE("one record serves a whole matrix, and none a passive one", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto a = tape.input(tapestry::test::array_of_matrix(well_conditioned(9, 1)));
  const auto before = tape.record_count();
  const ArrayVariable<double, 1> x = matrix::solve(a, tapestry::zeros<double, 1>({9}));
  CHECK(tape.record_count() == before + 1);
  CHECK(x.is_active());
  const MatrixOf<Variable<double>> passive = well_conditioned(9, 1).cast<Variable<double>>();
  CHECK_FALSE(matrix::inverse(passive)(0, 0).is_active());
  CHECK_FALSE(matrix::log_determinant(passive).is_active());
  CHECK(tape.record_count() == before + 1);
}

TEST_CASE("vectors, fixed extents, formulas and plain matrices mix", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const Variable<double> t = tape.input(2.0);
  Eigen::Matrix<Variable<double>, 2, 2> a;
  a << t, 0.0, 1.0, 4.0;
  const Eigen::Vector2d b(6, 5);
  const Eigen::Matrix<Variable<double>, 2, 1> x = matrix::solve(2 * a - a, b);  // (6/t, (5 − 6/t) / 4)
  tape.reverse(x(1));
  CHECK(x(1).value() == 0.5);
  CHECK(t.adjoint() == 6.0 / 4 / 4);
  const auto c = tape.input(Array<double, 2>{{2.0, 0.0}, {0.0, 4.0}});
  const ArrayVariable<double, 2> half = matrix::inverse(2.0 * c);
  tape.reverse(sum(half));
  CHECK(half.value()(0, 0) == 0.25);
  CHECK(c.adjoint()(1, 1) == -2.0 / 64);
  CHECK(c.adjoint()(0, 1) == -2.0 / 32);
  const auto same = tape.input(Array<double, 2>{{2.0, 1.0}, {0.0, 4.0}});  // A⁻¹ A is constant
  tape.reverse(sum(matrix::solve(same, same)));
  CHECK(same.adjoint() == tapestry::zeros<double, 2>({2, 2}));
}

TEST_CASE("one entry of a result may be the root, whatever was swept before", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  Eigen::Matrix<Variable<double>, 2, 1> b(tape.input(2.0), tape.input(3.0));
  const auto x = matrix::solve(Eigen::Matrix2d::Identity(), b);
  tape.reverse(Variable<double>(5 * x(1)));
  tape.reverse(x(0));
  CHECK(b(0).adjoint() == 1);
  CHECK(b(1).adjoint() == 0);
}

TEST_CASE("matrices of no extent have results of none, and the determinant 1", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto a = tape.input(tapestry::zeros<double, 2>({0, 0}));
  const auto b = tape.input(tapestry::zeros<double, 2>({0, 3}));
  const auto results = {matrix::solve(a, b), matrix::solve_positive_definite(a, b),
                        matrix::solve_triangular(a, b, matrix::Triangle::lower), matrix::inverse(a),
                        matrix::cholesky(a)};
  for (const auto& result : results) {
    CHECK(result.size() == 0);
    tape.reverse(result, result.value());
  }
  const Variable<double> logarithm = matrix::log_determinant(a),
                         other = matrix::log_determinant_positive_definite(a);
  CHECK(logarithm.value() == 0);
  tape.reverse(Variable<double>(logarithm + other));
  CHECK(a.adjoint().size() == 0);
}

TEST_CASE("singular, indefinite and ill-fitting matrices are errors that say so", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto singular = tape.input(Array<double, 2>{{1, 2}, {2, 4}});
  const auto wide = tape.input(tapestry::zeros<double, 2>({2, 3}));
  const auto before = tape.record_count();
  CHECK_THROWS_WITH(matrix::solve(singular, singular), "solve: a is singular");
  CHECK_THROWS_WITH(matrix::inverse(singular), "inverse: a is singular");
  CHECK_THROWS_WITH(matrix::log_determinant(singular), "log_determinant: a is singular");
  CHECK_THROWS_WITH(matrix::cholesky(-singular), "cholesky: a is not positive definite");
  CHECK_THROWS_AS(matrix::solve_positive_definite(-singular, singular), NumericError);
  CHECK_THROWS_AS(matrix::log_determinant_positive_definite(-singular), NumericError);
  CHECK_THROWS_AS(matrix::solve_triangular(singular - 1.0, singular, matrix::Triangle::lower), NumericError);
  CHECK_THROWS_WITH(matrix::inverse(wide), "inverse: a is [2, 3], expected a square matrix");
  CHECK_THROWS_WITH(matrix::solve(singular + 1.0, tapestry::zeros<double, 1>({3})), contains("solve: "));
  CHECK_THROWS_AS(matrix::cholesky(wide), ShapeError);
  CHECK(tape.record_count() >= before);
}

TEST_CASE("NaN passes through decompositions as NaN", "[autodiff][matrix]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const MatrixOf<Variable<double>> a = MatrixXd::Constant(3, 3, nan).cast<Variable<double>>();
  CHECK(std::isnan(matrix::inverse(a)(0, 0).value()));
  CHECK(std::isnan(matrix::log_determinant(a).value()));
  CHECK(std::isnan(matrix::cholesky(a)(0, 0).value()));
}

TEST_CASE("huge and tiny matrices keep their digits", "[autodiff][matrix]") {
  for (const double scale : {0x1p-500, 0x1p+500}) {
    ActiveTape<double> tape;
    const auto x = tape.input(tapestry::test::array_of_matrix(scale * random_positive_definite(5, 1)));
    const auto unscaled = tape.input(tapestry::test::array_of_matrix(random_positive_definite(5, 1)));
    const Variable<double> value = matrix::log_determinant(x);
    tape.reverse(value);
    const Array<double, 2> gradient = x.adjoint();
    tape.reverse(matrix::log_determinant(unscaled));
    CHECK(std::abs(value.value() - matrix::log_determinant(unscaled).value() - 5 * std::log(scale)) <= 1e-11);
    for (std::size_t i = 0; i < gradient.size(); ++i)
      CHECK(gradient.data()[i] * scale == unscaled.adjoint().data()[i]);
  }
}

TEST_CASE("a denormal matrix has an inverse without NaN, and so a log-determinant's gradient",
          "[autodiff][matrix]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto gradient_of = [](const MatrixXd& a) {
    ActiveTape<double> tape;
    const auto x = tape.input(tapestry::test::array_of_matrix(a));
    const Variable<double> value = matrix::log_determinant(x);
    tape.reverse(value);
    return std::pair(value.value(), x.adjoint());
  };
  // Worked out by hand: A is diagonal or triangular, and so is A⁻ᵀ; 1 / 10⁻³²⁰ is beyond doubles.
  const auto [value, both] = gradient_of(1e-320 * MatrixXd::Identity(2, 2));
  CHECK(std::abs(value - 2 * std::log(1e-320)) <= 1e-12);
  CHECK(both == Array<double, 2>{{infinity, 0}, {0, infinity}});
  const auto graded = gradient_of((MatrixXd(2, 2) << 1e-320, 0, 0, 4).finished()).second;
  CHECK(graded == Array<double, 2>{{infinity, 0}, {0, 0.25}});
  // A⁻ᵀ = [[1/a, 0], [−b/(a d), 1/d]] of [[a, b], [0, d]] with a = 2⁻¹⁰²³, b = 2⁻¹⁰²², d = 1/2.
  const auto triangular = gradient_of((MatrixXd(2, 2) << 0x1p-1023, 0x1p-1022, 0, 0.5).finished()).second;
  CHECK(triangular == Array<double, 2>{{0x1p1023, 0}, {-4, 2}});
  ActiveTape<double> tape;
  const MatrixOf<Variable<double>> tiny = (1e-320 * MatrixXd::Identity(2, 2)).cast<Variable<double>>();
  CHECK(matrix::inverse(tiny)(0, 1).value() == 0);
  CHECK(matrix::inverse(tiny)(1, 1).value() == infinity);
}

TEST_CASE("a tape of duals has second derivatives of solve, log-determinant and cholesky",
          "[autodiff][matrix]") {
  const auto f =
      []<class S>(std::span<const S> x) {  // log det A + Σ A⁻¹ b + the last of L, A = [[x, y], [y, 3]]
        Eigen::Matrix<S, 2, 2> a;
        a << x[0], x[1], x[1], S(3);
        const Eigen::Matrix<S, 2, 1> b(x[1], x[0]);
        return S(matrix::log_determinant(a) + matrix::solve(a, b).sum() + matrix::cholesky(a)(1, 1));
      };
  const auto closed = []<class S>(std::span<const S> x) {
    const S determinant = 3 * x[0] - x[1] * x[1];
    const S first = (3 * x[1] - x[1] * x[0]) / determinant,
            second = (x[0] * x[0] - x[1] * x[1]) / determinant;
    return S(log(determinant) + first + second + sqrt(3 - x[1] * x[1] / x[0]));
  };
  const std::vector<double> at = {2.0, 0.5};
  const auto found = tapestry::hessian(f, at), expected = tapestry::hessian(closed, at);
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(found[i] - expected[i]) <= 1e-13);
}

TEST_CASE("solutions have the Jacobian of the inverse, several rows a sweep",
          "[autodiff][matrix][jacobian]") {
  const MatrixXd a = well_conditioned(11, 41), b = random_matrix(11, 1, 42), inverse = a.inverse();
  ActiveTape<double> tape;
  Eigen::Matrix<Variable<double>, Eigen::Dynamic, 1> side(11);
  for (Eigen::Index i = 0; i < 11; ++i) side(i) = tape.input(b(i, 0));
  const auto x = matrix::solve(a, side);
  const std::vector<Variable<double>> roots(x.data(), x.data() + 11), sides(side.data(), side.data() + 11);
  const auto rows = tapestry::jacobian(tape, roots, sides);
  for (Eigen::Index i = 0; i < 11; ++i)
    for (Eigen::Index j = 0; j < 11; ++j)
      CHECK(std::abs(rows[static_cast<std::size_t>(11 * i + j)] - inverse(i, j)) <= bound);
}
