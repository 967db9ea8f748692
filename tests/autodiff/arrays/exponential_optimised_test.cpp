#include <tapestry/autodiff/detail/arrays/exponential.hpp>

#include <tapestry/autodiff/detail/arrays/reduction.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/random_array.hpp"
#include "../../support/relative_distance.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Exponential, tapestry::test::ActiveTape,
    tapestry::test::random_array;

namespace {
/// The largest relative error of the values, and of the derivatives, against long double.
template <Exponential Policy, class T>
long double worst_error(double low, double high) {
  ActiveTape<T> tape;
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
}  // namespace

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
    ActiveTape<double> tape;
    const auto start = random_array<double>({7, 300}, 3, -40, 40);
    const auto seed = random_array<double>({7, 300}, 4, -1, 1);
    const auto x = tape.input(start), z = tape.input(start);
    const ArrayVariable<double, 2> fast = softmax_along(x, axis);
    const ArrayVariable<double, 2> slow = tapestry::softmax_along<Exponential::library>(z, axis);
    tape.reverse(sum(fast * seed) + sum(slow * seed));
    CHECK(tapestry::test::largest_difference(fast.value(), slow.value()) <= 1e-15);
    CHECK(tapestry::test::largest_difference(x.adjoint(), z.adjoint()) <= 4e-15);
    CHECK(std::abs(logsumexp(x).value() - tapestry::logsumexp<Exponential::library>(z).value()) <= 1e-13);
  }
}
