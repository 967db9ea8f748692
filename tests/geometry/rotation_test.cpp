#include <tapestry/geometry/detail/rotation.hpp>

#include <tapestry/autodiff/dual.hpp>
#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Matrix3, geometry::Vector3, std::numbers::pi;

namespace {
/// Rotation vectors of many lengths: none, tiny, around the seam between the two formulas, π and beyond.
std::vector<Vector3> some_rotations() {
  tapestry::Random random(3);
  std::vector<Vector3> rotations{{0, 0, 0}, {0, 0, pi}, {pi, 0, 0}};
  for (const double angle :
       {1e-300, 1e-160, 1e-9, 1e-3, 0.3, 0.4999, 0.5001, 1.5, pi - 1e-9, pi, 4.0, 2 * pi}) {
    const Vector3 axis =
        geometry::normalised({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
    rotations.push_back(geometry::scale(axis, angle));
  }
  return rotations;
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 result{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) result[i] = geometry::add(result[i], geometry::scale(b[k], a[i][k]));
  return result;
}

double distance(const Matrix3& a, const Matrix3& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += geometry::length(geometry::subtract(a[i], b[i]));
  return sum;
}
}  // namespace

TEST_CASE("the exponential map turns about its axis by its length", "[geometry][rotation]") {
  const double c = std::cos(0.7), s = std::sin(0.7);
  constexpr double rounding = 2e-15;  // nine entries, each off by an ε
  CHECK(distance(geometry::exponential_map(Vector3{0, 0, 0.7}), {{{c, -s, 0}, {s, c, 0}, {0, 0, 1}}}) <=
        rounding);
  CHECK(distance(geometry::exponential_map(Vector3{0, pi, 0}), {{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}}) <=
        rounding);
  CHECK(distance(geometry::exponential_map(Vector3{0, 0, 0}), {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}) == 0);
  CHECK(geometry::exponential_map(Vector3{1e-200, 0, 0})[2][1] == 1e-200);
}

TEST_CASE("the exponential map is a rotation, and twice the vector turns twice", "[geometry][rotation]") {
  const Matrix3 identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (const Vector3& w : some_rotations()) {
    const Matrix3 r = geometry::exponential_map(w);
    const Matrix3 inverse = geometry::exponential_map(geometry::scale(w, -1));
    CHECK(distance(product(r, inverse), identity) <= 1e-14);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) CHECK(std::abs(inverse[i][j] - r[j][i]) <= 1e-15);
    CHECK(distance(product(r, r), geometry::exponential_map(geometry::scale(w, 2))) <= 1e-14);
  }
}

TEST_CASE("the derivative of the exponential map agrees with dual numbers",
          "[geometry][rotation][gradient]") {
  using Number = tapestry::Dual<double, 3>;
  tapestry::Random random(4);
  for (const Vector3& w : some_rotations()) {
    Matrix3 weights;
    for (auto& row : weights)
      for (double& value : row) value = random.uniform(-1, 1);
    std::array<Number, 3> input;
    for (std::size_t i = 0; i < 3; ++i) input[i] = Number::input(w[i], i);
    const auto turned = geometry::exponential_map(input);
    Number loss = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) loss = loss + weights[i][j] * turned[i][j];
    Vector3 gradient{1, 1, 1};  // the adjoint adds
    geometry::exponential_map_adjoint(w, weights, gradient);
    for (std::size_t i = 0; i < 3; ++i) CHECK(std::abs(gradient[i] - 1 - loss.tangent(i)) <= 1e-13);
  }
}

TEST_CASE("the right Jacobian agrees with central differences of the map", "[geometry][rotation][gradient]") {
  const double h = 1e-5;
  for (const Vector3& w : some_rotations()) {
    const Matrix3 jacobian = geometry::right_jacobian(w);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Vector3 ahead = w, behind = w;
      ahead[axis] += h;
      behind[axis] -= h;
      Matrix3 slope;  // ∂R/∂w
      const Matrix3 r_ahead = geometry::exponential_map(ahead), r_behind = geometry::exponential_map(behind);
      for (std::size_t i = 0; i < 3; ++i)
        slope[i] = geometry::scale(geometry::subtract(r_ahead[i], r_behind[i]), 1 / (2 * h));
      const Vector3 j{jacobian[0][axis], jacobian[1][axis], jacobian[2][axis]};
      const Matrix3 turn{{{0, -j[2], j[1]}, {j[2], 0, -j[0]}, {-j[1], j[0], 0}}};
      CHECK(distance(slope, product(geometry::exponential_map(w), turn)) <= 1e-9);
    }
  }
}
