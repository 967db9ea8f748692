#include <Eigen/Sparse>

#include "zero_patterns.hpp"

using namespace tapestry::test;

namespace {
/// The triangle of a matrix, or of its transpose, with zeros beside it.
template <unsigned Mode>
auto triangle(const AnySize<Slopes>& a) {
  return AnySize<Slopes>(a.template triangularView<Mode>());
}
template <int Order, class A>
auto sparse(const A& a) {
  using S = typename A::Scalar;
  std::vector<Eigen::Triplet<S>> entries;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j)
      entries.emplace_back(static_cast<int>(i), static_cast<int>(j), a(i, j));
  Eigen::SparseMatrix<S, Order> result(a.rows(), a.cols());
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}
template <unsigned Mode>
constexpr unsigned transposed = Mode ^ (Eigen::Lower | Eigen::Upper);
template <unsigned Mode>
void check_triangle(const std::string& name, const std::vector<System>& systems) {
  check_solves(name, systems, triangle<Mode>, [](const auto& a, const auto& b) {
    return a.template triangularView<Mode>().solve(b).eval();
  });
  check_solves(name + " by rows", systems, triangle<Mode>, []<class A>(const A& a, auto b) {
    const Eigen::Matrix<typename A::Scalar, A::RowsAtCompileTime, A::ColsAtCompileTime, Eigen::RowMajor>
        rows = a;
    rows.template triangularView<Mode>().solveInPlace(b);
    return b;
  });
  check_solves(name + " transposed", systems, triangle<Mode>, [](const auto& a, const auto& b) {
    return a.transpose().eval().template triangularView<transposed<Mode>>().transpose().solve(b).eval();
  });
  check_solves(name + " on the right", systems, triangle<Mode>, [](const auto& a, const auto& b) {
    return a.transpose()
        .template triangularView<transposed<Mode>>()
        .template solve<Eigen::OnTheRight>(b.transpose())
        .eval()
        .transpose()
        .eval();
  });
  check_solves(name + ", sparse", systems, triangle<Mode>, [](const auto& a, const auto& b) {
    return sparse<Eigen::ColMajor>(a).template triangularView<Mode>().solve(b).eval();
  });
  check_solves(name + ", sparse by rows", systems, triangle<Mode>, [](const auto& a, auto b) {
    sparse<Eigen::RowMajor>(a).template triangularView<Mode>().solveInPlace(b);
    return b;
  });
}
std::vector<System> triangular_systems() { return diagonal_systems({4, 1, -2, 0.5, 8, 1, -1, 2, 4}); }
}  // namespace

TEST_CASE("triangular solves have all derivatives at every pattern of zeros", "[autodiff][eigen][zeros]") {
  check_triangle<Eigen::Lower>("lower", triangular_systems());
  check_triangle<Eigen::Upper>("upper", triangular_systems());
}

TEST_CASE("triangular solves of a unit diagonal have all derivatives at every pattern of zeros",
          "[autodiff][eigen][zeros]") {
  check_triangle<Eigen::UnitLower>("unit lower", triangular_systems());
  check_triangle<Eigen::UnitUpper>("unit upper", triangular_systems());
}

TEST_CASE("sparse decompositions have all derivatives at every pattern of zeros",
          "[autodiff][eigen][zeros]") {
  const auto check_sparse = [](const std::string& name, const std::vector<System>& systems,
                               const auto& equation, auto decompose) {
    check_solves(name, systems, equation, [&](const auto& a, const auto& b) {
      const auto matrix = sparse<Eigen::ColMajor>(a);
      return decompose(matrix)->solve(b).eval();
    });
  };
  check_sparse(
      "SparseLU", general_systems(), [](const auto& a) { return a; },
      []<class M>(const M& matrix) { return std::make_unique<Eigen::SparseLU<M>>(matrix); });
  const auto symmetric = [](const AnySize<Slopes>& a) {
    return AnySize<Slopes>(a.selfadjointView<Eigen::Lower>());
  };
  const auto positive = diagonal_systems({4, 1, -2, 0.5, 8, 1, -1, 2, 16});
  check_sparse("SimplicialLLT", positive, symmetric,
               []<class M>(const M& matrix) { return std::make_unique<Eigen::SimplicialLLT<M>>(matrix); });
  check_sparse("SimplicialLDLT", positive, symmetric,
               []<class M>(const M& matrix) { return std::make_unique<Eigen::SimplicialLDLT<M>>(matrix); });
}

TEST_CASE("a sparse view keeps zeros that have derivatives", "[autodiff][eigen][zeros]") {
  using D = tapestry::Dual<double>;
  AnySize<D> a = AnySize<D>::Zero(3, 3);
  a(0, 0) = 2.0;
  a(1, 2) = D::input(0.0);
  const Eigen::SparseMatrix<D> view = a.sparseView(), pruned = (view * 3.0).pruned();
  CHECK(view.nonZeros() == 2);
  CHECK(view.coeff(1, 2).tangent() == 1);
  CHECK(pruned.nonZeros() == 2);
  CHECK(pruned.coeff(1, 2).tangent() == 3);
  const Eigen::SparseMatrix<D, Eigen::RowMajor> rows = a.sparseView();
  CHECK(rows.coeff(1, 2).tangent() == 1);
}

TEST_CASE("products with a scaled unit triangle have the derivatives by the scale",
          "[autodiff][eigen][zeros]") {
  using D = tapestry::Dual<double>;
  using Vector = Eigen::Matrix<D, Eigen::Dynamic, 1>;
  const D scale = D::input(1.0);
  AnySize<D> a(2, 2);
  a << D(4.0), D(1.0), D(5.0), D(9.0);
  Vector x(2);
  x << D(1.0), D(2.0);
  const Vector of_vector = (scale * a).triangularView<Eigen::UnitUpper>() * x;  // (1 + 2 s, 2)
  CHECK((of_vector(0).tangent() == 2 && of_vector(1).tangent() == 0));
  const Vector of_row =
      (x.transpose() * (scale * a).triangularView<Eigen::UnitUpper>()).transpose();  // (1, s + 2)
  CHECK((of_row(0).tangent() == 0 && of_row(1).tangent() == 1));
  const AnySize<D> left = (scale * a).triangularView<Eigen::UnitLower>() * a;  // [4 1; 20 s + 5, 5 s + 9]
  CHECK((left(0, 0).tangent() == 0 && left(1, 0).tangent() == 20 && left(1, 1).tangent() == 5));
  const AnySize<D> right = a * (scale * a).triangularView<Eigen::UnitLower>();  // [4 + 5 s, 1; 5 + 45 s, 9]
  CHECK((right(0, 0).tangent() == 5 && right(0, 1).tangent() == 0 && right(1, 0).tangent() == 45));
}
