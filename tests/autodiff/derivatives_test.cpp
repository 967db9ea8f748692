#include <tapestry/autodiff/derivatives.hpp>

#include <numeric>

#include "../support/catch.hpp"

using tapestry::DomainError;

namespace {
/// Rosenbrock's valley in n dimensions, whose Hessian is known.
const auto rosenbrock = []<class S>(std::span<S> x) {
  std::remove_const_t<S> total = 0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i)
    total += 100 * square(x[i + 1] - x[i] * x[i]) + square(1 - x[i]);
  return total;
};

std::vector<double> rosenbrock_hessian(const std::vector<double>& x) {
  const std::size_t n = x.size();
  std::vector<double> h(n * n);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i * n + i] += 1200 * x[i] * x[i] - 400 * x[i + 1] + 2;
    h[(i + 1) * n + i + 1] += 200;
    h[i * n + i + 1] -= 400 * x[i];
    h[(i + 1) * n + i] -= 400 * x[i];
  }
  return h;
}

std::vector<double> some_point(std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = std::sin(static_cast<double>(3 * i + 1));
  return x;
}
}  // namespace

TEST_CASE("derivative() of one number, and inside itself", "[autodiff][derivatives]") {
  const auto cube = [](auto x) { return x * x * x; };
  CHECK(tapestry::derivative(cube, 2.0).value == 8);
  CHECK(tapestry::derivative(cube, 2.0).derivative == 12);
  const auto slope = [&](auto x) { return tapestry::derivative(cube, x).derivative; };
  CHECK(tapestry::derivative(slope, 2.0).derivative == 12);  // 6x
  // d/dx (x · d/dy (x · y)) at y = 5: 2x, whatever y.
  const auto outer = [](auto x) {
    const auto inner = [&](auto y) { return x * y; };
    return x * tapestry::derivative(inner, decltype(x)(5.0)).derivative;
  };
  CHECK(tapestry::derivative(outer, 3.0).derivative == 6);
}

TEST_CASE("exact Hessians equal the closed form", "[autodiff][derivatives]") {
  for (const std::size_t n : std::initializer_list<std::size_t>{2, 8, 11}) {
    const auto x = some_point(n);
    const auto expected = rosenbrock_hessian(x);
    const auto found = tapestry::hessian(rosenbrock, x);
    REQUIRE(found.size() == n * n);
    for (std::size_t i = 0; i < found.size(); ++i) CHECK(std::abs(found[i] - expected[i]) <= 1e-12);
  }
}

TEST_CASE("a Hessian-vector product equals the closed form, and its gradient the tape's",
          "[autodiff][derivatives]") {
  const std::size_t n = 11;
  const auto x = some_point(n);
  std::vector<double> v(n);
  std::iota(v.begin(), v.end(), -4.0);
  const auto expected = rosenbrock_hessian(x);
  const auto gradient = tapestry::gradient(rosenbrock, x);
  const auto found = tapestry::hessian_product(rosenbrock, x, v);
  CHECK(found.value == gradient.value);
  for (std::size_t i = 0; i < n; ++i) {
    double product = 0;
    for (std::size_t k = 0; k < n; ++k) product += expected[i * n + k] * v[k];
    CHECK(std::abs(found.product[i] - product) <= 1e-11);
    CHECK(found.gradient[i] == gradient.gradient[i]);
  }
  CHECK_THROWS_WITH(tapestry::hessian_product(rosenbrock, x, std::vector<double>{1}),
                    "hessian_product: 1 entries of the direction, expected 11");
}

TEST_CASE("second derivatives of range functions on a tape of duals", "[autodiff][derivatives]") {
  const auto f = []<class S>(std::span<S> x) {
    using V = std::remove_const_t<S>;
    const std::vector<V> y = {x[0] * x[1], sin(x[1]), x[2] + x[0]};
    return V(logsumexp(y) * norm(y) + dot(y, softmax(y)) + sum(y));
  };
  const std::vector<double> x = {0.5, -1.25, 2.0};
  const auto found = tapestry::hessian(f, x);
  const double h = 0x1p-12;  // extrapolated: error about h⁴·f⁽⁵⁾ + ε·f′/h
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto quotient = [&](double s) {
        auto ahead = x, behind = x;
        ahead[k] += s;
        behind[k] -= s;
        return (tapestry::gradient(f, ahead).gradient[i] - tapestry::gradient(f, behind).gradient[i]) /
               (2 * s);
      };
      CHECK(std::abs(found[3 * i + k] - (4 * quotient(h / 2) - quotient(h)) / 3) <= 1e-10);
    }
}

TEST_CASE("a zero adjoint with a tangent still flows back", "[autodiff][derivatives]") {
  // f = x·y at x = 0: the adjoint of y is 0, and its derivative along x is 1.
  const auto f = []<class S>(std::span<S> x) { return std::remove_const_t<S>(x[0] * (x[1] * x[1])); };
  CHECK(tapestry::hessian(f, std::vector<double>{0.0, 3.0}) == std::vector<double>{0, 6, 6, 0});
}

TEST_CASE("a Jacobian by forward mode", "[autodiff][derivatives]") {
  const auto f = []<class S>(std::span<S> x) {
    std::vector<std::remove_const_t<S>> y;
    for (std::size_t i = 0; i < x.size(); ++i) y.push_back(x[i] * x[(i + 1) % x.size()]);
    y.push_back(x[0] + 7);
    return y;
  };
  const auto x = some_point(10);
  const auto found = tapestry::forward_jacobian(f, x);
  REQUIRE(found.size() == 110);
  for (std::size_t i = 0; i < 10; ++i)
    for (std::size_t k = 0; k < 10; ++k)
      CHECK(found[10 * i + k] == (k == i ? x[(i + 1) % 10] : k == (i + 1) % 10 ? x[i] : 0));
  CHECK(found[100] == 1);
}

TEST_CASE("gradients of sizes in turn, and one within another, are each of their own point",
          "[autodiff][derivatives]") {
  const auto squares = []<class S>(std::span<S> x) {
    std::remove_const_t<S> total = 0;
    for (const auto& entry : x) total += entry * entry;
    return total;
  };
  const auto doubled = [](std::vector<double> x) {
    for (double& entry : x) entry *= 2;
    return x;
  };
  for (const std::size_t n : std::initializer_list<std::size_t>{1000, 3, 0, 2000, 1}) {
    const auto x = some_point(n);
    CHECK(tapestry::gradient(squares, x).gradient == doubled(x));
  }
  const auto of_many_inside = [&]<class S>(std::span<S> x) {
    const auto inner = tapestry::gradient(squares, some_point(100)).gradient;
    return std::remove_const_t<S>(inner[1] * x[0] + x[1] * x[1]);
  };
  const auto outer = tapestry::gradient(of_many_inside, std::vector<double>{1, 3});
  CHECK(outer.gradient == std::vector<double>{2 * some_point(100)[1], 6});
  const auto fails = []<class S>(std::span<S> x) -> std::remove_const_t<S> {
    if (x.size() == 2) throw DomainError("two");
    return x[0];
  };
  CHECK_THROWS_AS(tapestry::gradient(fails, std::vector<double>{1, 2}), DomainError);
  CHECK(tapestry::gradient(fails, std::vector<double>{1, 2, 3}).gradient == std::vector<double>{1, 0, 0});
}
