#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>

#include <random>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double epsilon = std::numeric_limits<double>::epsilon();
using Values = std::vector<double>;

/// The gradient of f, of a vector of variables, at x.
template <class Function>
Values gradient_of(const Function& f, const Values& x) {
  ActiveTape<double> tape;
  std::vector<Variable<double>> inputs;
  for (const double entry : x) inputs.push_back(tape.input(entry));
  tape.reverse(Variable<double>(f(inputs)));
  Values gradient;
  for (const auto& input : inputs) gradient.push_back(input.adjoint());
  return gradient;
}
}  // namespace

TEST_CASE("fmod and remainder have the slopes between their jumps", "[autodiff][hard]") {
  const auto mod = [](const auto& x) { return fmod(x[0], x[1]); };
  const auto rest = [](const auto& x) { return remainder(x[0], x[1]); };
  CHECK(gradient_of(mod, {7, 2}) == Values{1, -3});
  CHECK(gradient_of(mod, {-7, 2}) == Values{1, 3});
  CHECK(gradient_of(mod, {6, 2}) == Values{1, -3});  // on the jump: the side above
  CHECK(gradient_of(mod, {1, infinity}) == Values{1, 0});
  // 1 − 2⁻⁵³ is below 10 · 0.1 as doubles are, though their quotient rounds to 10.
  CHECK(gradient_of(mod, {std::nextafter(10 * 0.1, 0.0), 0.1}) == Values{1, -9});
  CHECK(gradient_of(rest, {7, 2}) == Values{1, -4});  // a tie goes to the even integer
  CHECK(gradient_of(rest, {5.5, 2}) == Values{1, -3});
}

TEST_CASE("softmax of equal and of hugely different logits", "[autodiff][hard]") {
  const auto entry = [](std::size_t i) { return [i](const auto& x) { return softmax(x)[i]; }; };
  CHECK(gradient_of(entry(0), {5, 5}) == Values{0.25, -0.25});
  CHECK(gradient_of(entry(0), {1e308, -1e308}) == Values{0, 0});
  CHECK(gradient_of(entry(1), {1000, -1000}) == Values{0, 0});
  const Values far = gradient_of(entry(0), {40, 0, 0});  // 1 − y₀ = 2·exp(−40) would be lost beside y₀
  CHECK(std::abs(far[0] / (2 * std::exp(-40.0)) - 1) <= 4 * epsilon);
  CHECK(std::abs(far[1] / -std::exp(-40.0) - 1) <= 4 * epsilon);
  CHECK(softmax(std::vector<Variable<double>>{}).empty());
  CHECK(softmax(std::vector<Variable<double>>{3.0})[0].value() == 1);
  CHECK(gradient_of(entry(0), {-infinity, -infinity}) == Values{0.25, -0.25});
}

TEST_CASE("norm of the origin, of tiny, huge and infinite vectors", "[autodiff][hard]") {
  const auto length = [](const auto& x) { return norm(x); };
  CHECK(gradient_of(length, {0, 0, 0}) == Values{0, 0, 0});
  CHECK(gradient_of(length, {3, 4}) == Values{0.6, 0.8});
  CHECK(gradient_of(length, {3e-320, 4e-320}) == gradient_of(length, {3e-320 * 0x1p1000, 4e-320 * 0x1p1000}));
  CHECK(gradient_of(length, {0x3p1000, -0x4p1000}) == Values{0.6, -0.8});
  CHECK(gradient_of(length, {infinity, 1, -infinity}) == Values{1, 0, -1});
  CHECK(norm(std::vector<Variable<double>>{}).value() == 0);
}

TEST_CASE("hypot of three, fma, dot, fdim, copysign and sign", "[autodiff][hard]") {
  CHECK(gradient_of([](const auto& x) { return hypot(x[0], x[1], x[2]); }, {0, 0, 0}) == Values{0, 0, 0});
  const Values third =
      gradient_of([](const auto& x) { return hypot(x[0], x[1], x[2]); }, {0x2p1000, 0x3p1000, 0x6p1000});
  CHECK(std::abs(third[0] - 2.0 / 7) <= epsilon);
  CHECK(std::abs(third[2] - 6.0 / 7) <= epsilon);
  const auto fused = [](const auto& x) { return fma(x[0], x[1], -1.0); };
  CHECK(gradient_of(fused, {1 + epsilon, 1 - epsilon}) == Values{1 - epsilon, 1 + epsilon});
  CHECK(fma(Variable<double>(1 + epsilon), 1 - epsilon, -1.0).value() == -epsilon * epsilon);
  CHECK(gradient_of([](const auto& x) { return dot(x, x); }, {1, 2, 3}) == Values{2, 4, 6});
  const auto positive_difference = [](const auto& x) { return fdim(x[0], x[1]); };
  CHECK(gradient_of(positive_difference, {3, 1}) == Values{1, -1});
  CHECK(gradient_of(positive_difference, {1, 3}) == Values{0, 0});
  CHECK(gradient_of(positive_difference, {2, 2}) == Values{1, -1});
  const auto signed_like = [](const auto& x) { return copysign(x[0], x[1]); };
  CHECK(gradient_of(signed_like, {3, -0.0}) == Values{-1, 0});
  CHECK(gradient_of(signed_like, {-3, -1}) == Values{1, 0});
  CHECK(sign(Variable<double>(-2.0)) == -1);
  CHECK(sign(Variable<double>(-0.0)) == 0);
  CHECK(std::isnan(sign(Variable<double>(std::numeric_limits<double>::quiet_NaN()))));
}

TEST_CASE("catastrophic cancellation: the forms that avoid it, with their relative error",
          "[autodiff][hard]") {
  for (const double x : {1e-3, 1e-8, 1e-12}) {
    // 1 − cos x as 2·sin²(x/2): slope sin x, within 2 ε; written out, the value would be off by ε/x².
    const auto versine = [](const auto& v) { return 2 * square(sin(v[0] / 2)); };
    CHECK(std::abs(gradient_of(versine, {x})[0] / std::sin(x) - 1) <= 2 * epsilon);
    const auto growth = [](const auto& v) { return expm1(v[0]) / v[0]; };  // slope 1/2 + x/3 + x²/8 …
    CHECK(std::abs(gradient_of(growth, {x})[0] - (0.5 + x / 3 + x * x / 8)) <= 4 * epsilon / x + x * x * x);
  }
}

TEST_CASE("the variance of a shifted constant is exactly zero, and of a shifted spread exact to 4 ulp",
          "[autodiff][hard]") {
  // From the mean: Σ(x − mean)²/n. As mean of squares less square of mean, a shift of 10⁹ would leave
  // nothing.
  const auto variance = [](const auto& x) {
    const Variable<double> mean = sum(x) / static_cast<double>(x.size());
    Variable<double> total = 0;
    for (const auto& entry : x) total += square(entry - mean);
    return Variable<double>(total / static_cast<double>(x.size()));
  };
  for (const double slope : gradient_of(variance, {1e9, 1e9, 1e9, 1e9})) CHECK(slope == 0);
  const Values spread = gradient_of(variance, {1e9, 1e9 + 1, 1e9 + 2, 1e9 + 3});
  const Values expected = {-0.75, -0.25, 0.25, 0.75};  // 2(xᵢ − mean)/n
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(spread[i] - expected[i]) <= 4 * epsilon);
}

TEST_CASE("denormal adjoints are not flushed", "[autodiff][hard]") {
  const double tiny = std::numeric_limits<double>::denorm_min();
  CHECK(gradient_of([=](const auto& x) { return tiny * x[0] * 3.0; }, {1})[0] == 3 * tiny);
  const auto there_and_back = [](const auto& x) {
    const Variable<double> small = x[0] * 0x1p-1060;
    return Variable<double>(small * 0x1p1000);
  };
  CHECK(gradient_of(there_and_back, {1})[0] == 0x1p-60);
}

TEST_CASE("an infinite slope upstream of what has no adjoint does no harm", "[autodiff][hard]") {
  // max() takes the constant: the adjoint of √0 is 0, and 0·∞ must not become NaN.
  CHECK(gradient_of([](const auto& x) { return max(sqrt(x[0]), 1.0); }, {0})[0] == 0);
  CHECK(gradient_of([](const auto& x) { return 0.0 * log(x[0]) + x[0]; }, {0})[0] == 1);
  CHECK(gradient_of(
            [](const auto& x) {
              return x[0] < 1 ? Variable<double>(2 * x[0]) : Variable<double>(sqrt(x[0] - 1));
            },
            {0})[0] == 2);
}

TEST_CASE("where a zero meets an infinite slope, the tape, many roots and duals say 0 alike",
          "[autodiff][hard]") {
  const auto at_zero = [](const auto& f, double expected) {
    const auto recorded = [&](std::span<const Variable<double>> x) { return Variable<double>(f(x[0])); };
    CHECK(tapestry::gradient(recorded, {0.0}).gradient == Values{expected});
    CHECK(tapestry::derivative([&](const auto& x) { return f(x); }, 0.0).derivative == expected);
    ActiveTape<double> tape;
    const std::vector<Variable<double>> x = {tape.input(0.0)};
    const std::vector<Variable<double>> roots = {f(x[0]), Variable<double>(2 * x[0]), f(x[0])};
    CHECK(tapestry::jacobian(tape, roots, x) == Values{expected, 2, expected});
  };
  at_zero(
      [](const auto& x) {
        using S = std::remove_cvref_t<decltype(x)>;
        const S root = sqrt(x);
        return S(root * root);
      },
      0);
  at_zero([](const auto& x) { return std::remove_cvref_t<decltype(x)>(sqrt(x) * sqrt(x)); }, 0);
  at_zero([](const auto& x) { return std::remove_cvref_t<decltype(x)>(x * log(x)); }, -infinity);
  at_zero([](const auto& x) { return std::remove_cvref_t<decltype(x)>(exp(log(x))); }, 0);
  at_zero([](const auto& x) { return std::remove_cvref_t<decltype(x)>(sqrt(x * x)); }, 0);  // ∞ · 0
  at_zero([](const auto& x) { return std::remove_cvref_t<decltype(x)>(max(sqrt(x), 1.0) + x); }, 1);
  using Second = Dual<Dual<double>>;
  const Second x(Dual<double>::input(0.0), {Dual<double>(1.0)});
  const Second f = x * (1 - pow(x, 1.1));  // its second derivative is −2.31 x^0.1
  CHECK(f.tangent().tangent() == 0);
}

TEST_CASE("a product of slopes is 0 with a zero among infinite ones, in every sweep", "[autodiff][hard]") {
  std::mt19937_64 random(1);
  const std::array<double, 6> slopes = {0, infinity, -2, 0.5, -infinity, 3};
  for (int again = 0; again < 2000; ++again) {
    std::array<double, 5> chain;
    for (double& slope : chain) slope = slopes[random() % slopes.size()];
    ActiveTape<double> tape;
    const Variable<double> input = tape.input(1.0);
    Variable<double> x = input;
    Dual<double> dual = Dual<double>::input(1.0);
    double expected = 1;
    for (const double slope : chain) {
      const std::array<Variable<double>, 1> of = {x};
      const std::array<double, 1> by = {slope};
      x = tapestry::record_partials<double>(1.0, of, by);
      dual = Dual<double>(1.0, {tapestry::detail::chain(dual.tangent(), slope)});
      expected = expected == 0 || slope == 0 ? 0 : expected * slope;
    }
    tape.reverse(x);
    CHECK(dual.tangent() == expected);
    CHECK(input.adjoint() == expected);
    const std::vector<Variable<double>> inputs = {input}, roots = {x, x, x};
    CHECK(tapestry::jacobian(tape, roots, inputs) == Values(3, expected));
    tapestry::AdjointVectors<double, 4> adjoints;
    adjoints.reverse(tape, roots);
    CHECK(adjoints.of(input) == std::array<double, 4>{expected, expected, expected, 0});
  }
}

TEST_CASE("the slope of a quotient has the digits of the quotient", "[autodiff][hard]") {
  constexpr double smallest = std::numeric_limits<double>::denorm_min();
  for (const double x : {7e-10, -3.0, 1e-300, 0x1p-40}) {
    const double slope = gradient_of([](const auto& v) { return 3e-323 / v[0]; }, {x})[0];
    const double exact = -(3e-323 * 0x1p600 / x) / (0x1p600 * x);  // the quotient is not denormal
    CHECK(std::abs(slope - exact) <= smallest / std::abs(x) + 4 * epsilon * std::abs(exact));
  }
}

TEST_CASE("fdim of equal infinities is 0, and keeps the slopes of duals at a tie", "[autodiff][hard]") {
  CHECK(fdim(Variable<double>(infinity), infinity).value() == 0);
  CHECK(fdim(Variable<double>(-infinity), -infinity).value() == 0);
  CHECK(fdim(Variable<double>(infinity), 1.0).value() == infinity);
  CHECK(std::isnan(fdim(Variable<double>(std::nan("")), 1.0).value()));
  using D = Dual<double>;
  CHECK(fdim(D::input(2.0), 2.0).tangent() == 1);
  CHECK(fdim(Dual<D>(D::input(2.0), {D(1)}), 2.0).value().tangent() == 1);
}
