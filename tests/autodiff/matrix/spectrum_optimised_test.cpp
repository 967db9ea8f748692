#include <tapestry/autodiff/detail/matrix/product.hpp>
#include <tapestry/autodiff/detail/matrix/singular_values.hpp>

#include "matrix_gradient.hpp"

namespace matrix = tapestry::matrix;
using Eigen::MatrixXd, tapestry::Array, tapestry::ArrayVariable, tapestry::NumericError, tapestry::ShapeError,
    tapestry::Variable, tapestry::test::ActiveTape, tapestry::test::array_of_matrix,
    tapestry::test::check_gradient_of, tapestry::test::LongMatrix, tapestry::test::MatrixOf,
    tapestry::test::random_matrix, tapestry::test::random_positive_definite;

namespace {
constexpr double bound = 1e-12;
using LongSvd = Eigen::JacobiSVD<LongMatrix>;
constexpr unsigned thin = Eigen::ComputeThinU | Eigen::ComputeThinV;

/// Q diag(values) Qᵀ for some orthogonal Q.
MatrixXd with_eigenvalues(const Eigen::VectorXd& values) {
  const MatrixXd q = random_matrix(values.size(), values.size(), 3).householderQr().householderQ();
  return q * values.asDiagonal() * q.transpose();
}
/// Signs of vectors are free; squares of entries are not.
template <class S>
MatrixOf<S> squared(const MatrixOf<S>& x) {
  return x.unaryExpr([](const S& entry) { return S(entry * entry); });
}
ArrayVariable<double, 2> squared(const ArrayVariable<double, 2>& x) { return x * x; }
}  // namespace

TEST_CASE("least_squares has the gradient of differences in long double", "[autodiff][matrix]") {
  const auto f = [](const auto& a, const auto& b) { return matrix::least_squares(a, b); };
  const auto reference = [](const LongMatrix& a, const LongMatrix& b) {
    return LongMatrix(a.householderQr().solve(b));
  };
  const auto tall = [](Eigen::Index rows, Eigen::Index columns) {
    return MatrixXd(random_matrix(rows, columns, 1) + 2 * MatrixXd::Identity(rows, columns));
  };
  check_gradient_of(f, reference, bound, tall(1, 1), random_matrix(1, 1, 2));
  check_gradient_of(f, reference, bound, tall(9, 4), random_matrix(9, 2, 2));
  check_gradient_of(f, reference, bound, MatrixXd(tall(5, 5).rowwise().reverse()), random_matrix(5, 1, 2));
}

TEST_CASE("least_squares refuses wide and dependent columns, and takes none", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto wide = tape.input(tapestry::zeros<double, 2>({2, 3}));
  const auto dependent = tape.input(Array<double, 2>{{1, 2}, {2, 4}, {3, 6}});
  const auto none = tape.input(tapestry::zeros<double, 2>({3, 0}));
  const auto side = tape.input(tapestry::zeros<double, 1>({3}));
  CHECK_THROWS_WITH(matrix::least_squares(wide, wide),
                    "least_squares: a is [2, 3], expected no more columns than rows");
  CHECK_THROWS_WITH(matrix::least_squares(dependent, side), "least_squares: the columns of a are dependent");
  CHECK_THROWS_AS(matrix::least_squares(dependent, wide), ShapeError);
  const ArrayVariable<double, 1> x = matrix::least_squares(none, side);
  CHECK(x.size() == 0);
  tape.reverse(x, x.value());
  CHECK(side.adjoint() == tapestry::zeros<double, 1>({3}));
}

TEST_CASE("eigenvalues and eigenvectors have the gradients of differences in long double",
          "[autodiff][matrix]") {
  const auto values = [](const auto& a) { return matrix::symmetric_eigen(a).values; };
  const auto vectors = [](const auto& a) { return squared(matrix::symmetric_eigen(a).vectors); };
  using Solver = Eigen::SelfAdjointEigenSolver<LongMatrix>;
  for (const Eigen::Index n : {1, 2, 6}) {
    const MatrixXd a = with_eigenvalues(Eigen::VectorXd::LinSpaced(n, -2, 3));
    check_gradient_of(
        values, [](const LongMatrix& x) { return LongMatrix(Solver(x).eigenvalues()); }, bound, a);
    check_gradient_of(
        vectors, [](const LongMatrix& x) { return squared(LongMatrix(Solver(x).eigenvectors())); }, bound, a);
  }
}

TEST_CASE("equal eigenvalues have a sum and a projector, but no vectors of their own", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto a = tape.input(array_of_matrix(with_eigenvalues(Eigen::Vector4d(1, 1, 1, 5))));
  const auto eigen = matrix::symmetric_eigen(a);
  tape.reverse(sum(eigen.values));  // the trace
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j) CHECK(std::abs(a.adjoint()(i, j) - (i == j ? 1 : 0)) <= 1e-14);
  const auto projector = matmul(eigen.vectors, transpose(eigen.vectors));  // of all: constant
  tape.reverse(tapestry::test::weighted(projector));
  for (std::size_t i = 0; i < 16; ++i) CHECK(std::abs(a.adjoint().data()[i]) <= 1e-14);
  CHECK_THROWS_WITH(tape.reverse(tapestry::test::weighted(eigen.vectors)),
                    "symmetric_eigen: two values are equal, so that their vectors have no derivative");
}

TEST_CASE("singular values and vectors have the gradients of differences, of any rectangle",
          "[autodiff][matrix]") {
  const auto values = [](const auto& a) { return matrix::singular_values(a).values; };
  const auto u = [](const auto& a) { return squared(matrix::singular_values(a).u); };
  const auto v = [](const auto& a) { return squared(matrix::singular_values(a).v); };
  const std::array<MatrixXd, 4> examples = {MatrixXd::Constant(1, 1, -2.0), random_matrix(6, 3, 1),
                                            random_matrix(3, 6, 2),
                                            MatrixXd(random_matrix(4, 4, 3) + 3 * MatrixXd::Identity(4, 4))};
  for (const MatrixXd& a : examples) {
    check_gradient_of(
        values, [](const LongMatrix& x) { return LongMatrix(LongSvd(x).singularValues()); }, bound, a);
    check_gradient_of(
        u, [](const LongMatrix& x) { return squared(LongMatrix(LongSvd(x, thin).matrixU())); }, bound, a);
    check_gradient_of(
        v, [](const LongMatrix& x) { return squared(LongMatrix(LongSvd(x, thin).matrixV())); }, bound, a);
    check_gradient_of([](const auto& x) { return matrix::spectral_norm(x); },
                      [](const LongMatrix& x) { return LongSvd(x).singularValues()(0); }, bound, a);
    check_gradient_of([](const auto& x) { return matrix::nuclear_norm(x); },
                      [](const LongMatrix& x) { return LongSvd(x).singularValues().sum(); }, bound, a);
    check_gradient_of([](const auto& x) { return matrix::frobenius_norm(x); },
                      [](const LongMatrix& x) { return x.norm(); }, bound, a);
  }
}

TEST_CASE("equal and zero singular values have norms, but no vectors", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto identity = tape.input(Array<double, 2>{{1, 0}, {0, 1}, {0, 0}});
  const auto svd = matrix::singular_values(identity);
  tape.reverse(sum(svd.values * svd.values));  // the squared Frobenius norm
  CHECK(identity.adjoint() == Array<double, 2>{{2, 0}, {0, 2}, {0, 0}});
  CHECK_THROWS_AS(tape.reverse(tapestry::test::weighted(svd.v)), NumericError);
  const auto rank_one = tape.input(Array<double, 2>{{1, 0}, {0, 0}, {0, 0}});
  const auto lost = matrix::singular_values(rank_one);
  CHECK_THROWS_WITH(tape.reverse(tapestry::test::weighted(lost.u)),
                    "singular_values: one is 0, so that its vectors have no derivative");
  const auto zero = tape.input(tapestry::zeros<double, 2>({2, 2}));
  const Variable<double> norm = matrix::frobenius_norm(zero);
  tape.reverse(norm);
  CHECK(zero.adjoint() == tapestry::zeros<double, 2>({2, 2}));
  const Variable<double> spectral = matrix::spectral_norm(zero), nuclear = matrix::nuclear_norm(zero);
  CHECK(spectral.value() == 0);
  CHECK(nuclear.value() == 0);
}

TEST_CASE("spectra of nothing are empty, of NaN an error", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto none = tape.input(tapestry::zeros<double, 2>({0, 0}));
  const auto flat = tape.input(tapestry::zeros<double, 2>({0, 3}));
  const auto eigen = matrix::symmetric_eigen(none);
  const auto svd = matrix::singular_values(flat);
  CHECK(eigen.values.size() == 0);
  CHECK(svd.values.size() == 0);
  tape.reverse(eigen.vectors, eigen.vectors.value());
  tape.reverse(eigen.values, eigen.values.value());
  tape.reverse(svd.v, svd.v.value());
  tape.reverse(Variable<double>(matrix::spectral_norm(flat) + matrix::nuclear_norm(flat) +
                                matrix::frobenius_norm(none)));
  const auto bad = tape.input(Array<double, 2>{{1, 0}, {std::numeric_limits<double>::quiet_NaN(), 1}});
  CHECK_THROWS_WITH(matrix::symmetric_eigen(bad), "symmetric_eigen: a has a number that is not finite");
  CHECK_THROWS_AS(matrix::singular_values(bad), NumericError);
  const Variable<double> norm = matrix::frobenius_norm(bad);
  CHECK(std::isnan(norm.value()));
  CHECK_THROWS_AS(matrix::symmetric_eigen(flat), ShapeError);
}

TEST_CASE("norms of huge and tiny numbers neither overflow nor vanish", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  for (const double scale : {0x1p-1000, 0x1p+1000}) {
    const auto a = tape.input(Array<double, 2>{{3 * scale, 0}, {0, 4 * scale}});
    const Variable<double> norm = matrix::frobenius_norm(a);
    tape.reverse(norm);
    CHECK(norm.value() == 5 * scale);
    CHECK(std::abs(a.adjoint()(0, 0) - 0.6) <= 1e-15);
    CHECK(std::abs(matrix::spectral_norm(a).value() / scale - 4) <= 1e-14);
  }
}

TEST_CASE("singular vectors of tiny and huge matrices have the slopes of ordinary ones, by the scale",
          "[autodiff][matrix]") {
  const auto slopes = [](double scale) {
    ActiveTape<double> tape;
    const auto a =
        tape.input(Array<double, 2>{{3 * scale, scale}, {scale / 2, 4 * scale}, {2 * scale, scale}});
    const auto svd = matrix::singular_values(a);
    tape.reverse(Variable<double>(sum(svd.u * svd.u * svd.u) + sum(svd.v * svd.v * svd.v)));
    std::vector<double> result;
    for (const double slope : a.adjoint().storage()) result.push_back(slope * scale);
    return result;
  };
  const auto expected = slopes(1);
  for (const double scale : {0x1p-530, 0x1p+530}) {
    const auto found = slopes(scale);
    for (std::size_t i = 0; i < 6; ++i) CHECK(std::abs(found[i] - expected[i]) <= 1e-13);
  }
}

TEST_CASE("vectors of values that are not 0 have a derivative beside values that are", "[autodiff][matrix]") {
  const auto square_of_first = [](const auto& a) {
    const auto u = matrix::singular_values(a).u;
    return MatrixOf<typename std::decay_t<decltype(a)>::Scalar>::Constant(1, 1, u(0, 0) * u(0, 0));
  };
  const MatrixXd rank_one = (MatrixXd(3, 2) << 1, 2, 2, 4, 3, 6).finished();
  ActiveTape<double> tape;
  const MatrixOf<Variable<double>> x = rank_one.unaryExpr([&](double value) { return tape.input(value); });
  tape.reverse(square_of_first(x)(0, 0));
  // u0 is the eigenvector of A Aᵀ: by differences of the nonzero value's vectors.
  const double h = 1e-5;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (Eigen::Index j = 0; j < 2; ++j) {
      const auto at = [&](double step) {
        MatrixXd moved = rank_one;
        moved(i, j) += step;
        const double u = Eigen::JacobiSVD<MatrixXd>(moved, thin).matrixU()(0, 0);
        return u * u;
      };
      CHECK(x(i, j).adjoint() == Approx((at(h) - at(-h)) / (2 * h)).margin(1e-8));
    }
}

TEST_CASE("an adjoint that is NaN passes through vectors of equal values as NaN", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 2>{{1, 0}, {0, 1}});
  tape.reverse(tapestry::sum(matrix::symmetric_eigen(x).vectors * std::numeric_limits<double>::quiet_NaN()));
  CHECK(std::isnan(x.adjoint()(1, 0)));
  const auto tall =
      tape.input(Array<double, 2>{{1, 2}, {std::numeric_limits<double>::quiet_NaN(), 4}, {3, 6}});
  CHECK_THROWS_WITH(matrix::least_squares(tall, tape.input(Array<double, 2>{{1}, {2}, {3}})),
                    "least_squares: a has a number that is not finite");
}
