#include <complex>
#include <tapestry/autodiff.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
/// Re and Im of a holomorphic function of std::complex<S>.
template <class S>
[[nodiscard]] std::complex<S> f(const std::complex<S>& z) {
  const std::complex<S> two(S(2.0), S(-1.0));
  return z * z * two / (z + two) - z * exp(z) + conj(conj(z));
}

/// f′, by hand, in numbers.
[[nodiscard]] std::complex<double> slope(std::complex<double> z) {
  const std::complex<double> two(2, -1), sum = z + two;
  return two * (2.0 * z * sum - z * z) / (sum * sum) - (1.0 + z) * std::exp(z) + 1.0;
}
}  // namespace

// The standard promises std::complex for its three scalars only. That of GCC's and clang's libraries
// takes others, too, at no cost.
TEST_CASE("complex numbers of variables have the derivatives of Cauchy and Riemann", "[autodiff][complex]") {
  const std::complex<double> at(0.7, -0.4), expected = slope(at);
  ActiveTape<double> tape;
  const std::complex<Variable<double>> z(tape.input(at.real()), tape.input(at.imag()));
  const auto w = f(z);
  CHECK(std::abs(w.real().value() - f(at).real()) <= 1e-14);
  tape.reverse(w.real());
  CHECK(std::abs(z.real().adjoint() - expected.real()) <= 1e-14);
  CHECK(std::abs(z.imag().adjoint() + expected.imag()) <= 1e-14);
  tape.reverse(w.imag());
  CHECK(std::abs(z.real().adjoint() - expected.imag()) <= 1e-14);
  CHECK(std::abs(z.imag().adjoint() - expected.real()) <= 1e-14);
}

TEST_CASE("length and square of a complex number of variables", "[autodiff][complex]") {
  ActiveTape<double> tape;
  const std::complex<Variable<double>> z(tape.input(3.0), tape.input(-4.0));
  const Variable<double> length = abs(z), square = norm(z);
  CHECK(length.value() == 5);
  tape.reverse(length);
  CHECK(std::abs(z.real().adjoint() - 0.6) <= 1e-15);
  CHECK(std::abs(z.imag().adjoint() + 0.8) <= 1e-15);
  tape.reverse(square);
  CHECK(z.real().adjoint() == 6);
  CHECK(z.imag().adjoint() == -8);
}

TEST_CASE("complex numbers of duals carry derivatives", "[autodiff][complex]") {
  using D = Dual<double, 2>;
  const std::complex<double> at(0.7, -0.4), expected = slope(at);
  const auto w = f(std::complex<D>(D::input(at.real(), 0), D::input(at.imag(), 1)));
  CHECK(std::abs(w.real().tangent(0) - expected.real()) <= 1e-14);
  CHECK(std::abs(w.imag().tangent(0) - expected.imag()) <= 1e-14);
  CHECK(std::abs(w.real().tangent(1) + expected.imag()) <= 1e-14);
}

TEST_CASE("complex variables and duals go with plain numbers", "[autodiff][complex]") {
  const auto rational = []<class S>(const S& x) {  // (2 (x + i) − 1) / 4 + 8 / (3 − (1 + (x + i)))
    const std::complex<S> z(x, S(1));
    const std::complex<S> sum = (2.0 * z * 1 - 1.0) / 4 + 8 / (3 - (1.0 + (z + 0)));
    return S(sum.real() + 10 * sum.imag());
  };
  // 8 / (2 − x − i) = 8 (2 − x + i) / ((2 − x)² + 1); at x = 1: real ½ − ¼ + 4, imaginary ½ + 4. With n = 2:
  // d real = ½ + 8 (−n + 2) / n² = ½, d imaginary = 8 · 2 / n² = 4.
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(1.0);
  const Variable<double> y = rational(x);
  CHECK(y.value() == 4.25 + 45);
  tape.reverse(y);
  CHECK(x.adjoint() == 0.5 + 40);
  CHECK(rational(tapestry::Dual<double>::input(1.0)).tangent() == 40.5);
}
