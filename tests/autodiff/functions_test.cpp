#include <tapestry/autodiff/functions.hpp>

#include <fstream>
#include <set>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/paths.hpp"
#include "function_rows.hpp"

using tapestry::Variable, tapestry::test::ActiveTape;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
using Pair = std::array<double, 2>;
using Triple = std::array<double, 3>;

/// f(x) and f'(x) by the tape.
template <class T, class Function>
std::array<T, 2> on_tape(Function f, T x) {
  ActiveTape<T> tape;
  const Variable<T> input = tape.input(x);
  const Variable<T> result = f(input);
  tape.reverse(result);
  return {result.value(), input.adjoint()};
}

/// f(x, y), ∂f/∂x and ∂f/∂y by the tape.
template <class T, class Function>
std::array<T, 3> on_tape(Function f, T x, T y) {
  ActiveTape<T> tape;
  const Variable<T> first = tape.input(x), second = tape.input(y);
  const Variable<T> result = f(first, second);
  tape.reverse(result);
  return {result.value(), first.adjoint(), second.adjoint()};
}

/// Compares the tape with central differences of the value in long double: their error, about
/// h²·f'''/6 + ε·f/h with h = 1e-5, stays below 1e-9 at these arguments.
template <class T, class Function>
void check_slope(const char* name, Function f, std::initializer_list<double> arguments) {
  for (const double argument : arguments) {
    const T x = static_cast<T>(argument);
    const auto value = [&](long double at) {
      const Variable<long double> result = f(Variable<long double>(at));
      return result.value();
    };
    const long double h = 1e-5L;
    const auto at = static_cast<long double>(x);
    const long double expected = (value(at + h) - value(at - h)) / (2 * h);
    const auto [result, slope] = on_tape<T>(f, x);
    INFO(name << " at " << argument);
    const auto tolerance = 8 * static_cast<long double>(std::numeric_limits<T>::epsilon()) + 1e-9L;
    CHECK(static_cast<double>(std::abs(static_cast<long double>(result) - value(at))) <=
          static_cast<double>(tolerance * (1 + std::abs(value(at)))));
    CHECK(static_cast<double>(std::abs(static_cast<long double>(slope) - expected)) <=
          static_cast<double>(tolerance * (1 + std::abs(expected))));
  }
}
}  // namespace

TEMPLATE_TEST_CASE("functions of one variable agree with central differences",
                   "[autodiff][functions][gradient]", float, double) {
  using T = TestType;
  tapestry::test::for_each_function([](const tapestry::test::FunctionRow& row, const auto& f) {
    const double low = std::max(row.low, -2.0), high = std::min(row.high, 3.0);
    check_slope<T>(row.name, f, {0.7 * low + 0.3 * high, 0.4 * low + 0.6 * high, 0.1 * low + 0.9 * high});
  });
  check_slope<T>("abs", [](auto x) { return abs(x); }, {-2, 3});
  check_slope<T>("clamp", [](auto x) { return clamp(x, -1, 1); }, {-2, 0.5, 3});
}

TEST_CASE("every function of one number has a row in function_rows.hpp", "[autodiff][functions]") {
  std::set<std::string> rows = {"abs", "fabs", "operator-", "polygamma"};  // tested by name
  tapestry::test::for_each_function(
      [&](const tapestry::test::FunctionRow& row, const auto&) { rows.insert(row.name); });
  std::size_t count = 0;
  const std::string folder = tapestry::test::in_sources("include/tapestry/autodiff/detail/functions");
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    std::ifstream stream(file.path());
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::string made = "detail::make_unary<detail::", before = " auto ";
    for (auto at = text.find(made); at != std::string::npos; at = text.find(made, at + 1), ++count) {
      const auto begin = text.rfind(before, text.rfind("(const ", at)) + before.size();
      const std::string name = text.substr(begin, text.find('(', begin) - begin);
      INFO(name);
      CHECK(rows.contains(name));
    }
  }
  CHECK(count > 30);
}

TEMPLATE_TEST_CASE("functions of two variables agree with central differences",
                   "[autodiff][functions][gradient]", float, double) {
  using T = TestType;
  const auto check = [](const char* name, auto f, std::initializer_list<double> arguments) {
    const auto along = [=](auto path) { check_slope<T>(name, path, arguments); };
    along([=](auto x) { return f(x, 2 * x); });
    along([=](auto x) { return f(0.75 - x, x); });
    along([=](auto x) { return f(x, 1.25); });
    along([=](auto x) { return f(1.25, x); });
  };
  check("pow", [](auto x, auto y) { return pow(x, y); }, {0.5, 0.625});
  check("hypot", [](auto x, auto y) { return hypot(x, y); }, {0.5, 2.0, -1.0});
  check("atan2", [](auto x, auto y) { return atan2(x, y); }, {0.5, 2.0, -1.0});
  check("fmod", [](auto x, auto y) { return fmod(x, y); }, {0.5, 2.0, -1.0});
  check("max", [](auto x, auto y) { return max(x, y); }, {0.5, 2.0, -1.0});
  check("min", [](auto x, auto y) { return min(x, y); }, {0.5, 2.0, -1.0});
  check("logsumexp", [](auto x, auto y) { return logsumexp(x, y); }, {0.5, 2.0, -1.0});
}

TEST_CASE("pow at its special points", "[autodiff][functions]") {
  const auto power = [](const auto& x, const auto& y) { return pow(x, y); };
  CHECK(on_tape<double>(power, 0, 0) == Triple{1, 0, 0});
  CHECK(on_tape<double>(power, 0, 1) == Triple{0, 1, 0});
  CHECK(on_tape<double>(power, 0, 2) == Triple{0, 0, 0});
  CHECK(on_tape<double>(power, 0, 0.5) == Triple{0, infinity, 0});
  CHECK(on_tape<double>(power, 0, -1) == Triple{infinity, -infinity, -infinity});
  const auto negative = on_tape<double>(power, -2, 3);
  CHECK(negative[0] == -8);
  CHECK(std::abs(negative[1] - 12) <= 4e-15);
  CHECK(std::isnan(negative[2]));
  const auto cube = [](const auto& x) { return pow(x, 3); };
  CHECK(std::abs(on_tape<double>(cube, -2)[1] - 12) <= 4e-15);
  CHECK(on_tape<double>(cube, 0) == std::array<double, 2>{0, 0});
  const auto underflowing = on_tape<double>([](const auto& x) { return pow(x, 2); }, 1e-200);
  CHECK(underflowing[0] == 0);
  CHECK(underflowing[1] == 2e-200);
}

TEST_CASE("division by zero has infinite slopes, and NaN only of 0 / 0", "[autodiff][functions]") {
  const auto quotient = [](const auto& x, const auto& y) { return x / y; };
  CHECK(on_tape<double>(quotient, 1, 0) == Triple{infinity, infinity, -infinity});
  CHECK(on_tape<double>(quotient, -1, 0) == Triple{-infinity, infinity, infinity});
  CHECK(on_tape<double>(quotient, 1, -0.0) == Triple{-infinity, -infinity, -infinity});
  CHECK(on_tape<double>(quotient, 1, infinity) == Triple{0, 0, 0});
  const auto undefined = on_tape<double>(quotient, 0, 0);
  CHECK(std::isnan(undefined[0]));
  CHECK(undefined[1] == infinity);
  CHECK(std::isnan(undefined[2]));
  CHECK(on_tape<double>([](const auto& x) { return x / 0.0; }, 3) == Pair{infinity, infinity});
  CHECK(on_tape<double>([](const auto& x) { return 1 / x; }, 0) == Pair{infinity, -infinity});
  const auto masked = [](const auto& x) { return 0 * (1 / x) + 2 * x; };
  CHECK(std::isnan(on_tape<double>(masked, 0)[0]));
  CHECK(on_tape<double>(masked, 0)[1] == 2);  // a factor 0 passes no infinite slope
}

TEST_CASE("kinks have the subgradients of the documentation", "[autodiff][functions]") {
  CHECK(on_tape<double>([](const auto& x) { return abs(x); }, 0) == Pair{0, 0});
  CHECK(on_tape<double>([](const auto& x) { return sqrt(x); }, 0) == Pair{0, infinity});
  CHECK(on_tape<double>([](const auto& x) { return log(x); }, 0) == Pair{-infinity, infinity});
  CHECK(on_tape<double>([](const auto& x) { return clamp(x, 0, 1); }, 0) == Pair{0, 1});
  CHECK(on_tape<double>([](const auto& x) { return clamp(x, 0, 1); }, 1) == Pair{1, 1});
  CHECK(on_tape<double>([](const auto& x) { return 1 / x; }, 0) == Pair{infinity, -infinity});
  const auto maximum = [](const auto& x, const auto& y) { return max(x, y); };
  const auto minimum = [](const auto& x, const auto& y) { return min(x, y); };
  CHECK(on_tape<double>(maximum, 2, 2) == Triple{2, 0.5, 0.5});
  CHECK(on_tape<double>(minimum, 2, 2) == Triple{2, 0.5, 0.5});
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(on_tape<double>(maximum, nan, 1)[0]));
  CHECK(std::isnan(on_tape<double>(maximum, 1, nan)[0]));
  CHECK(std::isnan(on_tape<double>(minimum, nan, 1)[0]));
  CHECK(std::isnan(on_tape<double>(minimum, 1, nan)[0]));
  CHECK(on_tape<double>([](const auto& y, const auto& x) { return atan2(y, x); }, 0, 0) == Triple{0, 0, 0});
  CHECK(on_tape<double>([](const auto& x, const auto& y) { return hypot(x, y); }, 0, 0) == Triple{0, 0, 0});
  CHECK(on_tape<double>([](const auto& x, const auto& y) { return hypot(x, y); }, 0x3p600, 0x4p600) ==
        Triple{0x5p600, 0.6, 0.8});
}

TEST_CASE("a larger and a smaller one add up to the slopes of the sum at a tie, too",
          "[autodiff][functions]") {
  for (const double at : {0.0, -0.0, 2.0, infinity}) {
    const Triple expected{at + at, 1, 1};
    CHECK(on_tape<double>([](const auto& x, const auto& y) { return max(x, y) + min(x, y); }, at, at) ==
          expected);
    CHECK(on_tape<double>([](const auto& x, const auto& y) { return max(x, y) + min(y, x); }, at, at) ==
          expected);
    CHECK(on_tape<double>([](const auto& x, const auto& y) { return fmax(x, y) + fmin(x, y); }, at, at) ==
          expected);
    CHECK(on_tape<double>([=](const auto& x, const auto&) { return max(x, at) + min(at, x); }, at, 0) ==
          Triple{at + at, 1, 0});
  }
  CHECK(on_tape<double>([](const auto& x, const auto&) { return max(x, x); }, 3, 0) == Triple{3, 1, 0});
}

TEST_CASE("the side not taken passes nothing, not even under an infinite adjoint", "[autodiff][functions]") {
  const auto f = [](const auto& x, const auto& y) { return sqrt(max(x, y)); };
  CHECK(on_tape<double>(f, 0, -1) == std::array<double, 3>{0, infinity, 0});
}

TEST_CASE("functions built for extremes do not overflow or cancel", "[autodiff][functions]") {
  const auto sigmoid_of = [](const auto& x) { return sigmoid(x); };
  const auto softplus_of = [](const auto& x) { return softplus(x); };
  const auto tanh_of = [](const auto& x) { return tanh(x); };
  const auto logsumexp_of = [](const auto& x, const auto& y) { return logsumexp(x, y); };
  CHECK(on_tape<double>(sigmoid_of, 1e3) == Pair{1, 0});
  CHECK(on_tape<double>(sigmoid_of, -1e3) == Pair{0, 0});
  CHECK(on_tape<double>(softplus_of, 1e3) == Pair{1e3, 1});
  CHECK(on_tape<double>(softplus_of, -1e3) == Pair{0, 0});
  CHECK(std::abs(on_tape<double>(sigmoid_of, 40)[1] / std::exp(-40.0) - 1) <= 1e-15);
  CHECK(std::abs(on_tape<double>(tanh_of, 25)[1] / (4 * std::exp(-50.0)) - 1) <= 1e-15);
  CHECK(std::abs(on_tape<float>(tanh_of, 12)[1] / (4 * std::exp(-24.0F)) - 1) <= 1e-6F);
  CHECK(on_tape<double>([](const auto& x) { return expm1(x); }, 1e-20) == Pair{1e-20, 1});
  CHECK(on_tape<double>([](const auto& x) { return log1p(x); }, 1e-20) == Pair{1e-20, 1});
  CHECK(on_tape<double>(logsumexp_of, 1e308, -1e308) == Triple{1e308, 1, 0});
  CHECK(on_tape<double>(logsumexp_of, -infinity, -infinity) == Triple{-infinity, 0.5, 0.5});
  CHECK(on_tape<double>(logsumexp_of, infinity, 0) == Triple{infinity, 1, 0});
}

TEST_CASE("tanh is within 2 ulp where its two formulas meet, and an odd function", "[autodiff][functions]") {
  for (double x = 0.001; x < 5; x += 0.001) {
    const auto expected = static_cast<double>(std::tanh(static_cast<long double>(x)));
    const double found = Variable<double>(tanh(Variable<double>(x))).value();
    REQUIRE(std::abs(found - expected) <= 2 * (std::nextafter(expected, 2) - expected));
    REQUIRE(tanh(Variable<double>(-x)).value() == -found);
  }
  CHECK(std::signbit(Variable<double>(tanh(Variable<double>(-0.0))).value()));
  CHECK(tanh(Variable<double>(-1e300)).value() == -1);
}

TEST_CASE("reductions of many variables are single statements", "[autodiff][functions]") {
  ActiveTape<double> tape;
  const auto entries = [&](std::initializer_list<double> values) {
    std::vector<Variable<double>> variables;
    for (const double value : values) variables.push_back(tape.input(value));
    return variables;
  };
  const auto x = entries({1, 2, 3});
  const auto before = tape.statement_count();
  const Variable<double> total = sum(x);
  const Variable<double> soft = logsumexp(x);
  CHECK(tape.statement_count() == before + 2);
  CHECK(total.value() == 6);
  tape.reverse(total);
  for (const auto& entry : x) CHECK(entry.adjoint() == 1);
  const double expected = std::log(std::exp(1.0) + std::exp(2.0) + std::exp(3.0));
  CHECK(std::abs(soft.value() - expected) <= 1e-15 * 8);
  tape.reverse(soft);
  for (const auto& entry : x)
    CHECK(std::abs(entry.adjoint() - std::exp(entry.value() - expected)) <= 1e-15 * 4);
  CHECK(logsumexp(entries({})).value() == -infinity);
  CHECK(sum(entries({})).value() == 0);
  CHECK(logsumexp(entries({7})).value() == 7);
  CHECK(logsumexp(entries({1e308, 1e308, -1e308})).value() == 1e308);
  const auto unbounded = entries({infinity, 0, infinity});
  tape.reverse(logsumexp(unbounded));
  CHECK(unbounded[0].adjoint() == 0.5);
  CHECK(unbounded[1].adjoint() == 0);
}
