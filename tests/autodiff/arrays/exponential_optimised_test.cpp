#include <tapestry/autodiff/arrays/unary.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <random>
#include <tapestry/autodiff/arrays/reduction.hpp>
#include <tapestry/core/vector_functions.hpp>
#include <vector>

#include "../../support/catch.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::Exponential;
using tapestry::Tape;
using tapestry::test::random_array;

namespace {
/// The largest relative error of the values, and of the derivatives, against long double.
template <Exponential Policy, class T>
long double worst_error(double low, double high) {
  Tape<T> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(random_array<T>({20000}, 1, low, high));
  const ArrayVariable<T, 1> y = tapestry::exp<Policy>(x);
  tape.reverse(sum(y));
  long double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const long double expected = std::exp(static_cast<long double>(x.value()(i)));
    for (const T found : {y.value()(i), x.adjoint()(i)})
      worst = std::max(worst, std::abs(static_cast<long double>(found) / expected - 1));
  }
  return worst;
}

/// How many units of the last place are between them; ∞ if one is not finite and the other not the same.
[[nodiscard]] double ulps_between(double found, long double expected) {
  const auto rounded = static_cast<double>(expected);
  if (!std::isfinite(rounded) || !std::isfinite(found)) {
    const bool is_same = std::isnan(rounded) ? std::isnan(found) : found == rounded;
    return is_same ? 0 : std::numeric_limits<double>::infinity();
  }
  int exponent = 0;
  static_cast<void>(std::frexp(rounded, &exponent));
  const long double ulp = std::max(std::ldexp(1.0L, exponent - 53), 0x1p-1074L);
  return static_cast<double>(std::abs((static_cast<long double>(found) - expected) / ulp));
}

/// Errors of a function of double, at 10⁵ numbers of any size, as many between −2 and 2, and range ends.
template <class Function, class Reference>
[[nodiscard]] double worst_ulps(Function function, Reference reference) {
  using Limits = std::numeric_limits<double>;
  std::vector<double> at = {0.0,
                            -0.0,
                            1.0,
                            -1.0,
                            709.782712893384,
                            709.7827128933841,
                            -708.5,
                            -745.0,
                            -745.2,
                            -746.0,
                            Limits::infinity(),
                            -Limits::infinity(),
                            Limits::quiet_NaN(),
                            Limits::max(),
                            -Limits::max(),
                            Limits::min(),
                            -Limits::min(),
                            Limits::denorm_min(),
                            -Limits::denorm_min(),
                            std::nextafter(1.0, 0.0),
                            std::nextafter(1.0, 2.0),
                            std::nextafter(-1.0, 0.0),
                            0x1p53,
                            0x1.6a09ep-1,
                            0x1.6a09fp-1};
  std::mt19937_64 generator(7);
  std::uniform_real_distribution<double> logarithm(-1074, 1024), near(-2, 2);
  for (int i = 0; i < 100000; ++i) {
    const double x = std::exp2(logarithm(generator));
    at.insert(at.end(), {x, -x, near(generator), 400 * near(generator)});
  }
  double worst = 0;
  for (const double x : at) {
    const double ulps = ulps_between(function(x), reference(static_cast<long double>(x)));
    if (!(ulps <= worst)) worst = ulps;
    if (x == 0 && reference(0.0L) == 0) CHECK(std::signbit(function(x)) == std::signbit(x));
  }
  return worst;
}
}  // namespace

TEST_CASE("functions without a branch keep their documented errors, at extreme numbers, too",
          "[autodiff][exponential]") {
  using namespace tapestry::detail;
  CHECK(worst_ulps(branchless_exp, [](long double x) { return std::exp(x); }) <= 1);
  CHECK(worst_ulps(branchless_log, [](long double x) { return std::log(x); }) <= 0.9);
  CHECK(worst_ulps(branchless_log1p, [](long double x) { return std::log1p(x); }) <= 0.9);
  CHECK(worst_ulps(branchless_tanh, [](long double x) { return std::tanh(x); }) <= 2.5);
}

TEST_CASE("the policies of exp keep the errors that they document", "[autodiff][exponential]") {
  const long double ulp = 0x1p-52L, ulpf = 0x1p-23L;
  CHECK(worst_error<Exponential::library, double>(-707, 709) <= ulp);
  CHECK(worst_error<Exponential::vector, double>(-707, 709.7) <= 2 * ulp);
  CHECK(worst_error<Exponential::vector, double>(-1, 1) <= 2 * ulp);
  CHECK(worst_error<Exponential::vector, float>(-86, 88.7) <= 2 * ulpf);
}

TEST_CASE("exp by vectors ends where it says", "[autodiff][exponential]") {
  using tapestry::detail::vector_exp;
  CHECK(vector_exp(-707.5) == Approx(std::exp(-707.5)).epsilon(1e-15));
  CHECK(vector_exp(-707.6) == 0);
  CHECK(vector_exp(-86.8F) == Approx(std::exp(-86.8F)).epsilon(1e-6));
  CHECK(vector_exp(-86.9F) == 0);
}

TEMPLATE_TEST_CASE("exp by vectors at its special points", "[autodiff][exponential]", float, double) {
  using T = TestType;
  const T infinity = std::numeric_limits<T>::infinity(), nan = std::numeric_limits<T>::quiet_NaN();
  const T edge = std::nextafter(std::log(std::numeric_limits<T>::max()), T(0));
  const ArrayVariable<T, 1> x =
      Array<T, 1>{0, -T(0), infinity, -infinity, nan, edge, T(1e30), T(-1e30), T(-800)};
  const ArrayVariable<T, 1> y = tapestry::exp<Exponential::vector>(x);
  const auto& result = y.value();
  CHECK(result(0) == 1);
  CHECK(result(1) == 1);
  CHECK(result(2) == infinity);
  CHECK(result(3) == 0);
  CHECK(std::isnan(result(4)));
  CHECK(result(5) <= std::numeric_limits<T>::max());
  CHECK(result(5) > std::numeric_limits<T>::max() / 2);
  CHECK(result(6) == infinity);
  CHECK(result(7) == 0);
  CHECK(result(8) == 0);
}

TEST_CASE("softmax and logsumexp by vectors stay beside those of the library", "[autodiff][exponential]") {
  for (const std::size_t axis : {0U, 1U}) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const auto start = random_array<double>({7, 300}, 3, -40, 40);
    const auto seed = random_array<double>({7, 300}, 4, -1, 1);
    const auto x = tape.input(start), z = tape.input(start);
    const ArrayVariable<double, 2> fast = softmax_along(x, axis);
    const ArrayVariable<double, 2> slow = tapestry::softmax_along<Exponential::library>(z, axis);
    tape.reverse(sum(fast * seed) + sum(slow * seed));
    double worst = 0, worst_adjoint = 0;
    for (std::size_t i = 0; i < start.size(); ++i) {
      worst = std::max(worst, std::abs(fast.value().data()[i] - slow.value().data()[i]));
      worst_adjoint = std::max(worst_adjoint, std::abs(x.adjoint().data()[i] - z.adjoint().data()[i]));
    }
    CHECK(worst <= 1e-15);
    CHECK(worst_adjoint <= 4e-15);
    CHECK(std::abs(logsumexp(x).value() - tapestry::logsumexp<Exponential::library>(z).value()) <= 1e-13);
  }
}
