#include <tapestry/autodiff/array_functions.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/finite_difference.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::DomainError, tapestry::ShapeError, tapestry::Tape,
    tapestry::Variable, tapestry::test::ActiveTape, tapestry::test::random_array;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
using Row = ArrayVariable<double, 1>;
using Matrix = ArrayVariable<double, 2>;

/// The gradient of a scalar function of an array by the tape against central differences, element by element.
template <std::size_t Rank, class Function>
void check_gradient(const char* name, const Array<double, Rank>& x0, Function f) {
  ActiveTape<double> tape;
  const auto x = tape.input(x0);
  const Variable<double> root = f(x);
  tape.reverse(root);
  const double h = tapestry::test::central_difference_step<double>();
  INFO(name);
  auto at = x0;
  const auto value = [&] { return Variable<double>(f(ArrayVariable<double, Rank>(at))).value(); };
  for (std::size_t i = 0; i < x0.size(); ++i)
    CHECK(std::abs(x.adjoint().data()[i] - tapestry::test::slope_by(at.data()[i], h, value)) <=
          8 * h * h * std::max(1.0, std::abs(root.value())));
}

/// Σ wᵢ·yᵢ with weights that differ.
template <tapestry::DifferentiableArray Y>
Variable<double> weighted(const Y& y) {
  Array<double, Y::rank> weights(y.shape());
  for (std::size_t i = 0; i < weights.size(); ++i) weights.data()[i] = 1 + 0.25 * static_cast<double>(i % 5);
  return dot(y, weights);
}
}  // namespace

TEST_CASE("a formula of arrays is one record, and what it is summed into no other",
          "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  const Row x = tape.input(Array<double, 1>{1, 2, 3});
  const auto before = tape.statement_count();
  const Row y = exp(x) * x + sin(x) / 2 - 1;
  CHECK(tape.statement_count() == before + 1);
  CHECK(sum(square(y) + y * x).is_active());
  CHECK(tape.statement_count() == before + 2);
  const auto kept = x * x;
  CHECK(tape.statement_count() == before + 2);
  CHECK(sum(kept).value() == 14);
}

TEST_CASE("every element-wise function is differentiated", "[autodiff][array_expression][gradient]") {
  const auto x0 = random_array<double>({2, 3}, 1, 0.25, 0.75);
  using X = const Matrix&;
  const auto check = [&](const char* name, auto f) {
    check_gradient(name, x0, [&](X x) { return weighted(f(x)); });
  };
  check("exp2", [](X x) { return exp2(x) + expm1(x) * log1p(x) - log2(x) / log10(x); });
  check("trigonometric", [](X x) { return sin(x) * cos(x) + tan(x) - asin(x) * acos(x) + atan(x); });
  check("hyperbolic", [](X x) { return sinh(x) * cosh(x) + asinh(x) - acosh(x + 1) * atanh(x); });
  check("special", [](X x) { return erf(x) * erfc(x) + cbrt(x) + lgamma(x + 1) - tgamma(x + 1); });
  check("two arguments",
        [](X x) { return hypot(x, 2 * x) + atan2(x, 1 - x) * logsumexp(x, 3 * x) + pow(2, x); });
  check("costly within costly", [](X x) { return exp(sin(x) * log(x + exp(x * x))) * tanh(x); });
  check("where",
        [](X x) { return where(x < 0.5, sin(x), x * x) + where(x >= 0.4, x, 0) + where(x > 2, exp(x), 1); });
  check("a masked formula", [](X x) { return where(sin(x) <= x * 0.95, x, cos(x)); });
}

TEST_CASE("the functions of arrays give the values of those of scalars", "[autodiff][array_expression]") {
  const auto x0 = random_array<double>({600}, 1, 0.25, 0.75);  // several blocks, and a part of one
  const Row x = x0;
  const Row y = exp(x) * max(x, 0.5) - min(x, 0.3) / hypot(x, 2) + where(x < 0.5, x, 2);
  for (std::size_t i = 0; i < x0.size(); ++i) {
    const double e = x0(i);
    const double expected =
        std::exp(e) * std::max(e, 0.5) - std::min(e, 0.3) / std::hypot(e, 2.0) + (e < 0.5 ? e : 2);
    CHECK(std::abs(y.value()(i) - expected) <= 1e-15 * 4);
  }
}

TEST_CASE("views read and add where they look", "[autodiff][array_expression][view]") {
  const auto x0 = random_array<double>({4, 6}, 1, 0.5, 1.5);
  using X = const Matrix&;
  check_gradient("slices", x0, [](X x) {
    const auto left = slice(x, {{{0, 3}, {0, 5}}}), right = slice(x, {{{1}, {1}}});
    return weighted(left * right + square(right - left));
  });
  check_gradient("steps", x0, [](X x) { return weighted(exp(slice(x, {{{0, 4, 2}, {1, 6, 2}}}))); });
  check_gradient("columns", x0,
                 [](X x) { return weighted(column(x, 1) * column(x, 4) - sin(column(x, 1))); });
  check_gradient("rows", x0, [](X x) { return weighted(select(x, 0, 3) / select(x, 0, 0)); });
  check_gradient("transposed", x0, [](X x) {
    return weighted(matmul(x * x, transpose(x)) +
                    matmul(slice(x, {{{}, {0, 4}}}), transpose(slice(x, {{{}, {2}}}))));
  });
  check_gradient("views of views", x0, [](X x) {
    return weighted(select(transpose(slice(x, {{{1}, {0, 6, 2}}})), 1, 2) * select(x, 0, 1).shape()[0]);
  });
  check_gradient("a view by itself", x0, [](X x) { return weighted(tapestry::evaluated(transpose(x))); });
  check_gradient("scalars beside views", x0, [](X x) {
    const Variable<double> s = sum(column(x, 0));
    return weighted(column(x, 2) * s - s / column(x, 3));
  });
}

TEST_CASE("axes of extent one repeat, and their adjoints sum", "[autodiff][array_expression][view]") {
  const auto x0 = random_array<double>({3, 4}, 1, 0.5, 1.5);
  const auto other = random_array<double>({1, 4}, 2, 0.5, 1.5);
  using X = const Matrix&;
  check_gradient("rows", x0, [](X x) {
    return weighted(x * slice(x, {{{0, 1}, {}}}) / slice(x, {{{}, {1, 2}}}));
  });
  check_gradient("a repeated row", other, [&](X row) { return weighted(exp(row) * Matrix(x0) - row); });
  check_gradient("both ways", other, [&](X row) { return weighted(row * transpose(row)); });
  check_gradient("repeat", x0,
                 [](X x) { return weighted(repeat(select(x, 0, 1), 0) * x + repeat(column(x, 2), 1, 4)); });
  check_gradient("broadcast", other, [](X row) { return weighted(broadcast(row, {5, 4}) * 2); });
  const Matrix row = other;
  CHECK(tapestry::evaluated(row + Matrix(x0)).shape() == tapestry::Extents<2>{3, 4});
}

TEST_CASE("reductions along an axis", "[autodiff][array_expression][reduction]") {
  const auto x0 = random_array<double>({3, 4, 2}, 1, -1, 1);
  using X = const ArrayVariable<double, 3>&;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    check_gradient("sum", x0, [&](X x) { return weighted(sum_along(x * x, axis)); });
    check_gradient("logsumexp", x0, [&](X x) { return weighted(logsumexp_along(3 * x, axis)); });
    check_gradient("softmax", x0, [&](X x) { return weighted(softmax_along(3 * x, axis)); });
  }
  check_gradient("norm", x0, [](X x) { return norm(x + 1); });
  check_gradient("largest", x0, [](X x) { return Variable<double>(largest(x) * smallest(x)); });
  CHECK_THROWS_AS(sum_along(ArrayVariable<double, 3>(x0), 3), ShapeError);
}

TEST_CASE("gather and scatter are each other's transpose", "[autodiff][array_expression][gather]") {
  const auto x0 = random_array<double>({2, 3}, 1);
  const auto y0 = random_array<double>({4}, 2);
  const std::vector<std::size_t> places = {5, 0, 5, 3};
  const Row gathered = gather(Matrix(x0), places);
  const Matrix scattered = scatter<2>(Row(y0), places, {2, 3});
  CHECK(gathered.value() == Array<double, 1>{x0(1, 2), x0(0, 0), x0(1, 2), x0(1, 0)});
  CHECK(std::abs(dot(gathered, y0).value() - dot(scattered, x0).value()) <= 1e-15);
  check_gradient("gather", x0, [&](const Matrix& x) { return weighted(square(gather(x, places))); });
  check_gradient("scatter", y0, [&](const Row& y) {
    return weighted(square(scatter<2>(y, places, {2, 3})));
  });
  CHECK_THROWS_WITH(gather(Matrix(x0), {6}), "gather: index 6 lies outside [6]");
  CHECK_THROWS_AS(scatter<1>(Row(y0), {1, 2}, {9}), ShapeError);
}

TEST_CASE("the side that where() does not take cannot poison the gradient", "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  const Row x = tape.input(Array<double, 1>{-1, 0, 4});
  tape.reverse(sum(where(x > 0, sqrt(x) + log(x), x * 0.5)));
  CHECK(x.adjoint() == Array<double, 1>{0.5, 0.5, 0.5});
  tape.reverse(sum(where(x > 0, x / 0 - x / 0, 3 * x)));
  CHECK(x.adjoint()(0) == 3);
  tape.reverse(sum(max(sqrt(x), 1)));
  CHECK(x.adjoint()(1) == 0);
}

TEST_CASE("what is constant is not pulled back", "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  const Row x = tape.input(Array<double, 1>{1, 2}), y = tape.input(Array<double, 1>{3, 4});
  tape.reverse(sum(constant(x) * y));
  CHECK(x.adjoint() == Array<double, 1>{0, 0});
  CHECK(y.adjoint() == Array<double, 1>{1, 2});
  CHECK_FALSE(tapestry::evaluated(constant(x) + constant(y)).is_active());
  const Row frozen = passive(x);
  tape.reverse(sum(frozen * y + frozen));
  CHECK(x.adjoint() == Array<double, 1>{0, 0});
}

TEST_CASE("the same array may stand anywhere in a formula", "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  Row x = tape.input(Array<double, 1>{2, 3});
  const Row first = x;
  x = x * x + x;
  tape.reverse(sum(x * x));
  CHECK(first.adjoint() == Array<double, 1>{60, 168});  // 2(x² + x)(2x + 1)
}

TEST_CASE("scalar and array statements interleave", "[autodiff][array_expression]") {
  check_gradient("interleaved", random_array<double>({300}, 1, 0.5, 1.5), [](const Row& x) {
    Variable<double> s = mean(x);
    for (int i = 0; i < 3; ++i) {
      const Row scaled = x * s + exp(-s);
      s = s * sum(scaled) / 300 + element(scaled, {7});
    }
    return Variable<double>(s * 1.0);
  });
}

TEST_CASE("a second reverse repeats the first, whatever was released on the way",
          "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  const Row x = tape.input(random_array<double>({5000}, 1, 0.5, 1.5));
  const auto root = [&] {
    const Row y = exp(x) * x;
    const Row z = log(y) + y;
    return sum(z * y);
  }();
  tape.reverse(root);
  const Array<double, 1> first = x.adjoint();
  tape.reverse(root);
  CHECK(x.adjoint() == first);
  tape.reverse(sum(x));
  CHECK(x.adjoint()(17) == 1);
  tape.reverse(root, 2.0);
  for (std::size_t i = 0; i < first.size(); ++i) CHECK(x.adjoint()(i) == 2 * first(i));
}

TEST_CASE("memory of a cleared tape is used again, also after its values outlived it",
          "[autodiff][array_expression][memory]") {
  const auto x0 = random_array<double>({5000}, 1, 0.5, 1.5);
  Row survivor;
  {
    Tape<double> tape;
    Array<double, 1> first;
    for (int round = 0; round < 3; ++round) {
      tape.clear();
      const auto scope = tape.activate();
      const Row x = tape.input(ArrayVariable<double, 1>(x0));
      const Row y = exp(x);
      tape.reverse(sum(y * x));
      if (round == 0) first = x.adjoint();
      CHECK(x.adjoint() == first);
      survivor = y;
    }
  }
  CHECK(survivor.value()(3) == std::exp(x0(3)));
  CHECK_THROWS_AS(survivor.adjoint(), DomainError);
}

TEST_CASE("empty arrays and arrays of one element", "[autodiff][array_expression]") {
  ActiveTape<double> tape;
  const Row none = tape.input(tapestry::zeros<double, 1>({0}));
  const Row also_none = exp(none) * 2 + none;
  CHECK(also_none.size() == 0);
  CHECK(sum(also_none).value() == 0);
  tape.reverse(sum(also_none));
  CHECK(none.adjoint().size() == 0);
  CHECK(logsumexp(none).value() == -infinity);
  CHECK(norm(none).value() == 0);
  CHECK_THROWS_AS(largest(none), ShapeError);
  const Row one = tape.input(Array<double, 1>{0.5});
  tape.reverse(Variable<double>(norm(one) + logsumexp(one)));
  CHECK(one.adjoint()(0) == 2);
}

TEST_CASE("special values of softmax and logsumexp along an axis",
          "[autodiff][array_expression][reduction]") {
  const Matrix x =
      Array<double, 2>{{1e308, -1e308}, {7, 7}, {infinity, 0}, {-infinity, -infinity}, {1000, -1000}};
  CHECK(logsumexp_along(x, 1).value()(0) == 1e308);
  CHECK(std::abs(logsumexp_along(x, 1).value()(1) - (7 + std::log(2.0))) <= 1e-15 * 8);
  CHECK(logsumexp_along(x, 1).value()(2) == infinity);
  CHECK(logsumexp_along(x, 1).value()(3) == -infinity);
  CHECK(softmax_along(x, 1).value() == Array<double, 2>{{1, 0}, {0.5, 0.5}, {1, 0}, {0.5, 0.5}, {1, 0}});
  CHECK(norm(Matrix(Array<double, 2>{{3e-200, 4e-200}})).value() == 5e-200);
  CHECK(std::abs(norm(Matrix(Array<double, 2>{{3e200, -4e200}})).value() / 5e200 - 1) <= 4e-16);
}

TEST_CASE("views that would leave the array are refused", "[autodiff][array_expression][view]") {
  const Matrix x = random_array<double>({2, 3}, 1);
  CHECK_THROWS_WITH(slice(x, {{{3}, {}}}), "slice: 3 along axis 0, expected at most 2");
  CHECK_THROWS_WITH(select(x, 1, 3), "select: 3 along axis 1, expected at most 2");
  CHECK_THROWS_WITH(slice(x, {{{0, 1, 0}, {}}}), "slice: step 0 along axis 0");
  CHECK_THROWS_AS(transpose(x, {1, 1}), ShapeError);
  CHECK_THROWS_AS(broadcast(x, {4, 3}), ShapeError);
  CHECK_THROWS_WITH(x + slice(x, {{{}, {0, 2}}}), "operator+: right operand is [2, 2], expected [2, 3]");
}

TEST_CASE("a formula of active arrays needs an active tape", "[autodiff][array_expression]") {
  Tape<double> tape;
  const Row x = tape.input(Array<double, 1>{1, 2});
  CHECK_THROWS_AS(tapestry::evaluated(x * x), DomainError);
  CHECK_THROWS_AS(sum(x * x), DomainError);
  const auto scope = tape.activate();
  CHECK(sum(x * x).value() == 5);
}
