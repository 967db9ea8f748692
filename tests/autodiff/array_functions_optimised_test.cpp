#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"
#include "function_rows.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable, tapestry::test::ActiveTape,
    tapestry::test::random_array;

namespace {
/// Σ weights · f(x), to turn an array result into a scalar whose gradient sees every element.
template <tapestry::DifferentiableArray Y>
auto weighted(const Y& y) {
  using T = tapestry::detail::ArrayScalarType<Y>;
  Array<T, Y::rank> weights(y.shape());
  for (std::size_t i = 0; i < weights.size(); ++i) weights.data()[i] = T(1) + T(0.25) * static_cast<T>(i % 5);
  return dot(y, weights);
}

/// The gradient of f by x on the tape against central differences along a random direction.
template <class T, std::size_t Rank, class Function>
void check_gradient(const char* name, const Array<T, Rank>& x0, Function f) {
  Array<T, Rank> direction = x0;
  tapestry::Random random(9);
  for (T& element : direction.storage())
    element = static_cast<T>(random.uniform(-1, 1) / std::sqrt(static_cast<double>(x0.size())));
  ActiveTape<T> tape;
  const auto x = tape.input(x0);
  const Variable<T> root = f(x);
  tape.reverse(root);
  const auto value = [&](const Array<T, Rank>& at) {
    return Variable<T>(f(ArrayVariable<T, Rank>(at))).value();
  };
  INFO(name);
  CHECK(std::abs(tapestry::test::dot(x.adjoint(), direction) -
                 tapestry::test::central_difference(value, x0, direction)) <=
        tapestry::test::central_difference_tolerance(root.value()));
}
}  // namespace

TEMPLATE_TEST_CASE("elementwise functions agree with central differences",
                   "[autodiff][array_functions][gradient]", float, double) {
  using T = TestType;
  const auto x0 = random_array<T>({3, 5}, 1, 0.5, 1.5);
  const auto other = random_array<T>({3, 5}, 2, 0.5, 1.5);
  const Array<T, 2> larger = 4 * other;
  using X = const ArrayVariable<T, 2>&;
  check_gradient("arithmetic", x0, [&](X x) { return weighted(-(x * x + other - x / other) * (other / x)); });
  check_gradient("numbers", x0, [](X x) { return weighted((2 * x + 1) / 4 - 3 / (x - 0.25)); });
  check_gradient("scalars", x0, [](X x) {
    const Variable<T> s = sum(x) / 15;
    return weighted(s * x + x / s - (s - x) * (x + s * s) + s / x);
  });
  tapestry::test::for_each_function([&](const tapestry::test::FunctionRow& row, const auto& f) {
    const double low = std::max(row.low, 0.0), width = std::min(row.high - low, 1.4);
    const Array<T, 2> inside = static_cast<T>(low) + static_cast<T>(width / 2) * x0;
    check_gradient(row.name, inside, [&](X x) { return weighted(f(x)); });
  });
  check_gradient("abs", x0, [](X x) { return weighted(abs(x - 3)); });
  check_gradient("pow", x0, [&](X x) { return weighted(pow(x, 3) + pow(x, x) + pow(2, x)); });
  check_gradient("max, min", x0, [&](X x) { return weighted(max(x, 0.1) * min(x, larger) + max(3, x)); });
  check_gradient("clamp", x0, [](X x) { return weighted(clamp(x, T(0), T(2)) * clamp(x, T(3), T(4))); });
}

TEMPLATE_TEST_CASE("reductions and products agree with central differences",
                   "[autodiff][array_functions][gradient]", float, double) {
  using T = TestType;
  const auto x0 = random_array<T>({3, 5}, 1, -1, 1);
  const auto matrix = random_array<T>({5, 4}, 2, -1, 1);
  const auto weight = random_array<T>({4, 5}, 3, -1, 1);
  const auto bias = random_array<T>({4}, 4, -1, 1);
  using X = const ArrayVariable<T, 2>&;
  check_gradient("sum", x0, [](X x) { return Variable<T>(sum(x) * mean(x)); });
  check_gradient("dot", x0, [](X x) { return Variable<T>(dot(x, x) * dot(x, exp(x))); });
  check_gradient("logsumexp", x0, [](X x) { return logsumexp(x); });
  check_gradient("element", x0, [](X x) { return Variable<T>(element(x, {2, 1}) * element(x, {0, 4})); });
  check_gradient("reshape", x0, [](X x) { return weighted(reshape<3>(x, {5, 1, 3})); });
  check_gradient("matmul left", x0, [&](X x) { return weighted(matmul(x, matrix)); });
  check_gradient("matmul right", matrix, [&](X x) { return weighted(matmul(x0, x)); });
  check_gradient("affine x", x0, [&](X x) { return weighted(affine(x, weight, bias)); });
  check_gradient("affine weight", weight, [&](X w) { return weighted(affine(x0, w, bias)); });
  check_gradient("affine bias", bias,
                 [&](const ArrayVariable<T, 1>& b) { return weighted(square(affine(x0, weight, b))); });
}
