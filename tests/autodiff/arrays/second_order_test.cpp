#include <tapestry/autodiff/array_derivatives.hpp>

#include "../../support/catch.hpp"
#include "../../support/hessian_product_error.hpp"

using namespace tapestry;
using test::hessian_product_error, test::number, test::random_array;

namespace {
/// One operation of a random program on a square matrix; each stays near 1.
template <class V>
V operation(std::size_t kind, const V& x, const V& y) {
  switch (kind) {
    case 0:
      return x * y;
    case 1:
      return sin(x) + y;
    case 2:
      return exp(x * 0.3) - y;
    case 3:
      return x / (2.0 + y * y);
    case 4:
      return tanh(x) * sigmoid(y);
    case 5:
      return sqrt(1.5 + x * x) * y;
    case 6:
      return V(matmul(x, y)) * 0.3;
    case 7:
      return softmax_along(x, 1) * y;
    case 8:
      return V(repeat(logsumexp_along(x, 0), 0, x.shape()[0])) - y;
    case 9:
      return transpose(x) * y;
    case 10:
      return log(2.0 + x * x) + y * norm(x);
    case 11:
      return reshape(gather(x, {3, 1, 0, 3}), x.shape()) * y;
    case 12:
      return where(y > 0.1, x, y * y);
    case 13:
      return V(repeat(sum_along(x * y, 1), 1, x.shape()[1])) * 0.4;
    case 14:
      return atan(x) * softplus(y);
    default:
      return x * mean(y) + V(repeat(largest_along(y, 0), 0, y.shape()[0]));
  }
}
}  // namespace

TEST_CASE("functions of arrays have the Hessians that differences of their gradients give",
          "[autodiff][second_order]") {
  const auto x = random_array<double>({3, 4}, 1, -1, 1), w = random_array<double>({4, 2}, 2, -1, 1);
  const auto check = [&](const auto& f) { CHECK(hessian_product_error(f, x) < 1e-8); };
  check([](const auto& a) { return number(a, sum(exp(a) * a + sin(a * 2.0) / (1.0 + a * a))); });
  check([](const auto& a) { return number(a, sum(sum_along(a * a, 0) * sum_along(sin(a), 0))); });
  check([](const auto& a) { return number(a, sum(exp(mean_along(a, 1)))); });
  check([](const auto& a) { return number(a, sum(sin(softmax_along(a, 1)))); });
  check([](const auto& a) { return number(a, sum(sin(logsumexp_along(a, 0)))); });
  check([](const auto& a) { return number(a, exp(logsumexp(a * 2.0))); });
  check([](const auto& a) { return number(a, norm(a) * norm(sin(a))); });
  check([](const auto& a) { return number(a, largest(a) * smallest(a) * sum(a)); });
  check([](const auto& a) { return number(a, element(a, {1, 2}) * element(a, {0, 1})); });
  check([](const auto& a) { return number(a, sum(slice(a, {Range{1}, Range{0, 4, 2}}) * exp(mean(a)))); });
  check([](const auto& a) { return number(a, prod(a) * sum(cumsum(exp(a), 0) * cumsum(a, 1))); });
  check([](const auto& a) {
    auto total = a;
    total += lerp(a, a * a, 0.25);
    total *= fma(a, floor(a * 3.0), 2.0);
    return number(a, sum(total - copysign(a, ceil(a))));
  });
  const auto vector = [](const auto& a, const auto& b) { return number(a, sum(tanh(matvec(a, b)))); };
  CHECK(hessian_product_error(vector, x, random_array<double>({4}, 6, -1, 1)) < 1e-8);
  const auto product = [](const auto& a, const auto& b) { return number(a, sum(tanh(matmul(a, b)))); };
  CHECK(hessian_product_error(product, x, w) < 1e-8);
  const auto layer = [](const auto& a, const auto& b, const auto& c) {
    return number(a, sum(tanh(affine(a, b, c))));
  };
  CHECK(hessian_product_error(layer, x, random_array<double>({2, 4}, 3, -1, 1),
                              random_array<double>({2}, 4, -1, 1)) < 1e-8);
}

TEST_CASE("random programs of arrays have the Hessians of differences",
          "[autodiff][second_order][repeated]") {
  std::size_t wrong = 0;
  for (std::uint64_t seed = 1; seed <= 2000; ++seed) {
    const auto program = [seed](const auto& input) {
      using V = std::remove_cvref_t<decltype(input)>;
      Random random(seed);
      std::vector<V> values{input, V(sin(input * 1.7))};
      for (std::size_t i = 0; i < 6; ++i) {
        const V x = values[random.index(values.size())], y = values[random.index(values.size())];
        values.push_back(operation(random.index(16), x, y));
      }
      return number(input, sum(values[values.size() - 1] * values[values.size() - 2]));
    };
    const auto x = random_array<double>({2, 2}, seed + 9000, -1, 1);
    if (!(hessian_product_error(program, x) < 1e-6)) ++wrong;
  }
  CHECK(wrong == 0);
}

TEST_CASE("a Hessian, a gradient penalty and the checker of a function of an array",
          "[autodiff][second_order]") {
  const auto cubic = [](const auto& a) { return number(a, sum(a * a * a)); };
  const Array<double, 1> x{1, -2, 0};
  const auto h = hessian(cubic, x);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) CHECK(h(i, j) == (i == j ? 6 * x(i) : 0));
  const auto [penalty, gradients] = gradient_penalty(cubic, x);
  CHECK(penalty == (9 + 9 * 16) / 2.0);
  CHECK((std::get<0>(gradients) == Array<double, 1>{18, -144, 0}));
  const auto weighted = [](const auto& a, const auto& w) { return number(a, sum(a * a * w)); };
  const auto by_weights = gradient_penalty(weighted, x, Array<double, 1>{3, 1, 2});
  CHECK((std::get<1>(by_weights.second) == Array<double, 1>{12, 16, 0}));  // d (2·x·w)²/2 / dw
  CHECK(check_hessian_product(cubic, x, Array<double, 1>{1, 1, 1}).passed());
  const auto loses_tangents = [](const auto& a) { return number(a, sum(a * a * passive(a))); };
  CHECK_FALSE(check_hessian_product(loses_tangents, x, Array<double, 1>{1, 1, 1}).passed());
}

TEST_CASE("second order at the ends: empty arrays, duals of duals, infinite and NaN elements",
          "[autodiff][second_order]") {
  const auto f = [](const auto& a) { return number(a, sum(exp(a)) + logsumexp(a)); };
  CHECK(std::get<0>(hessian_product(f, Array<double, 1>(), Array<double, 1>()).product).size() == 0);
  const Array<double, 1> zero{0, 0};
  const auto length = [](const auto& a) { return number(a, norm(a)); };
  const auto at_kink = hessian_product(length, zero, Array<double, 1>{1, 1});
  for (const double entry : std::get<0>(at_kink.product)) CHECK(std::isnan(entry));
  const auto squares = [](const auto& a) { return number(a, sum(a * a)); };
  const Array<double, 1> extreme{1e300, -0.0};
  CHECK((std::get<0>(hessian_product(squares, extreme, Array<double, 1>{1, 3}).product) ==
         Array<double, 1>{2, 6}));
  CHECK_THROWS_AS(hessian_product(squares, extreme, Array<double, 1>{1}), ShapeError);
  using Inner = Dual<double, 1, struct First>;
  using Outer = Dual<Inner, 1, struct Second>;  // third order: d³ Σ σ(x) by one direction
  Tape<Outer> tape;
  const auto scope = tape.activate();
  const Inner at(0.3, {1.0});
  const auto input = tape.input(Array<Outer, 2>{{Outer(at, {Inner(1.0)})}});
  const ArrayVariable<Outer, 2> both = concatenate(std::span<const ArrayVariable<Outer, 2>>(std::array{
                                                       input, ArrayVariable<Outer, 2>(Array<Outer, 2>{{0}})}),
                                                   1);
  tape.reverse(element(softmax_along(both, 1), {0, 0}));  // σ(x)
  const double s = 1 / (1 + std::exp(-0.3));
  CHECK(std::abs(input.adjoint().data()[0].tangent().tangent() - s * (1 - s) * (1 - 6 * s + 6 * s * s)) <
        1e-14);
}
