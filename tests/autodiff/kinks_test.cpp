#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/sparse_hessian.hpp>

#include <random>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Tape, tapestry::Variable, tapestry::test::ActiveTape;

// Second derivatives at kinks, ties and infinite slopes: right, or NaN and counted; never another number.

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Functions that are made of parts with a kink or an infinite slope, by number.
struct Composite {
  std::size_t number;

  template <class S>
  std::remove_const_t<S> operator()(std::span<S> given) const {
    using V = std::remove_const_t<S>;
    const std::vector<V> x(given.begin(), given.end());
    return number < 20 ? smooth(x) : number < 40 ? smooth_by_parts(x) : kinked(x);
  }

 private:
  template <class V>
  static V twice(const V& x) {
    return x * x;
  }
  template <class V>
  V smooth(const std::vector<V>& x) const {
    const V size = abs(x[0]), root = sqrt(x[0]), third = cbrt(x[0]);
    switch (number) {
      case 0:
        return 0.5 * twice(norm(x));
      case 1:
        return 0.5 * square(hypot(x[0], x[1]));
      case 2: {
        const V length = sqrt(x[0] * x[0] + x[1] * x[1]);
        return 0.5 * length * length;
      }
      case 3:
        return pow(1 + size * size, -0.5);
      case 4:
        return abs(x[0]) * abs(x[0]);
      case 5:
        return square(size);
      case 6:
        return pow(size, 2);
      case 7:
        return cos(size);
      case 8:
        return cosh(sqrt(x[0] * x[0]));
      case 9:
        return exp(-square(hypot(x[0], x[1])));
      case 10:
        return sqrt(pow(x[0], 4));
      case 11:
        return exp(2 * log(x[0]));
      case 12:
        return pow(third, 6);
      case 13:
        return root * pow(x[0], 1.5);
      case 14:
        return sqrt(x[0]) * pow(x[0], 1.5);
      case 15:
        return 0.5 * square(hypot(x[0], x[1], 0.0));
      case 16:
        return pow(norm(x), 2) + x[1] * x[1] * x[1];
      default:
        return square(norm(std::vector<V>{x[0] - x[1], x[1] - x[0]}));
    }
  }
  template <class V>
  V smooth_by_parts(const std::vector<V>& x) const {
    switch (number) {
      case 20:
        return pow(norm(x), 3);
      case 21:
        return abs(x[0] * x[0]);
      case 22:
        return pow(max(x[0], 0.0), 3);
      case 23: {  // the greater one cancels
        const V top = max(x[0], x[1]);
        return top + log(exp(x[0] - top) + exp(x[1] - top));
      }
      case 24: {
        V top = x[0];
        for (const V& entry : x) top = max(top, entry);  // a tie with itself
        return top * x[1];
      }
      case 25:
        return abs(0.0 * x[0]) + x[1] * x[1];
      case 26:
        return x[1] * x[1] * (1 + V(abs(V(0.0)))) + sqrt(V(0.0)) * x[0];  // constants
      case 27:
        return square(abs(x[0] + 1.0 - 1.0));
      case 28:
        return max(x[0] * x[0], -x[0] * x[0]);
      default:
        return square(hypot(x[0] - 1, x[1] - 2));
    }
  }
  template <class V>
  V kinked(const std::vector<V>& x) const {
    switch (number) {
      case 40:
        return abs(x[0]) + x[1] * x[1];
      case 41:
        return abs(x[0]) * x[1];
      case 42:
        return abs(x[0]) * abs(x[1]);
      case 43:
        return norm(x);
      case 44:
        return hypot(x[0], x[1]);
      case 45:
        return abs(x[0]) * x[0];
      case 46:
        return max(x[0], 0.0) + x[1] * x[1];
      case 47:
        return square(max(x[0], 0.0)) + x[1] * x[1];
      case 48:
        return clamp(x[0] + 1, -1.0, 1.0) + x[1] * x[1];
      case 49:
        return sqrt(x[0]) * sqrt(x[0]) + x[1] * x[1];
      case 50:
        return sqrt(x[0] * x[0]) + x[1] * x[1];
      case 51:
        return square(acosh(x[0] + 1)) + x[1] * x[1];
      case 52:
        return fdim(x[0], 0.0) + x[1] * x[1];
      case 53:
        return x[0] / abs(x[0]) + x[1] * x[1];
      case 54:
        return sqrt(x[0]) + x[1] * x[1];
      default:
        return atan2(x[0], x[1]);
    }
  }
};

/// A function of the first number, for derivative().
struct OfOne {
  Composite f;
  template <class S>
  S operator()(const S& x) const {
    return f(std::span<const S>(std::array<S, 2>{x, S(0)}));
  }
};

struct Case {
  std::size_t number;
  std::array<double, 2> x;
  std::array<double, 3> expected;  // f_xx, f_xy, f_yy
};
const std::array<double, 3> identity = {1, 0, 1}, twice_x = {2, 0, 0};
const std::vector<Case> smooth_cases = {{0, {0, 0}, identity},   {1, {0, 0}, identity},
                                        {2, {0, 0}, identity},   {3, {0, 0}, {-1, 0, 0}},
                                        {4, {0, 0}, twice_x},    {5, {0, 0}, twice_x},
                                        {6, {0, 0}, twice_x},    {7, {0, 0}, {-1, 0, 0}},
                                        {8, {0, 0}, {1, 0, 0}},  {9, {0, 0}, {-2, 0, -2}},
                                        {10, {0, 0}, twice_x},   {11, {0, 0}, twice_x},
                                        {12, {0, 0}, twice_x},   {13, {0, 0}, twice_x},
                                        {14, {0, 0}, twice_x},   {15, {0, 0}, identity},
                                        {16, {0, 0}, {2, 0, 2}}, {17, {3, 3}, {4, -4, 4}},
                                        {20, {0, 0}, {0, 0, 0}}, {21, {0, 0}, twice_x},
                                        {22, {0, 0}, {0, 0, 0}}, {23, {1, 1}, {0.25, -0.25, 0.25}},
                                        {24, {2, 1}, {0, 1, 0}}, {25, {0, 3}, {0, 0, 2}},
                                        {26, {1, 3}, {0, 0, 2}}, {27, {0, 0}, twice_x},
                                        {28, {0, 0}, {2, 0, 0}}, {29, {1, 2}, {2, 0, 2}}};
const std::vector<Case> kinked_cases = {
    {40, {0, 3}, {none, 0, 2}},      {41, {0, 3}, {none, none, 0}},    {41, {0, 0}, {0, none, 0}},
    {42, {0, 0}, {0, none, 0}},      {43, {0, 0}, {none, none, none}}, {44, {0, 0}, {none, none, none}},
    {45, {0, 0}, {none, 0, 0}},      {46, {0, 3}, {none, 0, 2}},       {47, {0, 3}, {none, 0, 2}},
    {48, {0, 3}, {none, 0, 2}},      {49, {0, 3}, {none, 0, 2}},       {50, {0, 3}, {none, 0, 2}},
    {51, {0, 3}, {none, 0, 2}},      {52, {0, 3}, {none, 0, 2}},       {53, {0, 3}, {none, none, none}},
    {54, {0, 3}, {-infinity, 0, 2}}, {55, {0, 0}, {none, none, none}}};

bool agrees(double found, double expected) {
  return (std::isnan(found) && std::isnan(expected)) || found == expected ||
         std::abs(found - expected) <= 4e-15 * std::max(1.0, std::abs(expected));
}

std::size_t nans_in(const std::vector<double>& numbers) {
  std::size_t count = 0;
  for (const double number : numbers) count += static_cast<std::size_t>(std::isnan(number));
  return count;
}

std::vector<double> dense(const Case& c) {
  return {c.expected[0], c.expected[1], c.expected[1], c.expected[2]};
}

void check_hessian(const Case& c) {
  const auto expected = dense(c);
  const auto found = tapestry::hessian(Composite{c.number}, c.x);
  INFO("function " << c.number << ": " << found[0] << ' ' << found[1] << ' ' << found[2] << ' ' << found[3]);
  for (std::size_t i = 0; i < 4; ++i) CHECK(agrees(found[i], expected[i]));
  CHECK(found.unknown == nans_in(expected));
}

/// Rows where the gradient jumps are not known as a whole.
void check_products(const Case& c) {
  const auto h = dense(c);
  tapestry::HessianProducts products(Composite{c.number});
  for (const std::array<double, 2>& v : {std::array{1., 0.}, {0., 1.}, {1., 2.}, {-3., 0.5}}) {
    const auto found = products(c.x, v);
    CHECK(found.gradient == tapestry::gradient(Composite{c.number}, c.x).gradient);
    for (std::size_t i = 0; i < 2; ++i) {
      double expected = 0;
      for (std::size_t j = 0; j < 2; ++j) expected += v[j] == 0 ? 0 : h[2 * i + j] * v[j];
      INFO("function " << c.number << " times " << v[0] << ' ' << v[1] << ", row " << i << ": "
                       << found.product[i] << " for " << expected);
      CHECK((agrees(found.product[i] / 4, expected / 4) ||
             (std::isnan(found.product[i]) && (std::isnan(h[2 * i]) || std::isnan(h[2 * i + 1])))));
    }
    CHECK(found.product.unknown == nans_in(found.product));
  }
}

void check_sparse(const Case& c) {
  const auto h = dense(c);
  const tapestry::HessianPlan plan(tapestry::hessian_pattern(Composite{c.number}, c.x));
  const auto found = tapestry::sparse_hessian(Composite{c.number}, c.x, plan);
  plan.pattern().visit([&](std::size_t row, std::size_t column, std::size_t number) {
    INFO("function " << c.number << " at " << row << ", " << column << ": " << found[number]);
    CHECK(agrees(found[number], h[2 * row + column]));
  });
  CHECK(found.unknown == nans_in(h));  // also counts the diagonal outside the pattern
}

void check_nested(const Case& c) {
  const OfOne f{{c.number}};
  const auto slope = [&](const auto& x) { return tapestry::derivative(f, x).derivative; };
  const double found = tapestry::derivative(slope, c.x[0]).derivative;
  INFO("function " << c.number << ": " << found);
  CHECK(agrees(found, c.expected[0]));
}

/// f_xx, f_xy, f_yy on a tape of duals, or by duals of duals, without hessian().
std::array<double, 3> on_tape(const Case& c) {
  using D = Dual<double, 2>;
  ActiveTape<D> tape;
  const std::array<Variable<D>, 2> x = {tape.input(D::input(c.x[0], 0)), tape.input(D::input(c.x[1], 1))};
  tape.reverse(Composite{c.number}(std::span<const Variable<D>>(x)));
  const D by_x = x[0].adjoint(), by_y = x[1].adjoint();
  const bool row_is_known = !std::isnan(by_x.tangent(1));
  return {by_x.tangent(0), row_is_known ? by_x.tangent(1) : by_y.tangent(0), by_y.tangent(1)};
}
std::array<double, 3> by_duals(const Case& c) {
  using D = Dual<double, 2>;
  using DD = Dual<D, 2>;
  const std::array<DD, 2> x = {DD::input(D::input(c.x[0], 0), 0), DD::input(D::input(c.x[1], 1), 1)};
  const DD f = Composite{c.number}(std::span<const DD>(x));
  const bool is_known = !std::isnan(f.tangent(0).tangent(1));
  return {f.tangent(0).tangent(0), is_known ? f.tangent(0).tangent(1) : f.tangent(1).tangent(0),
          f.tangent(1).tangent(1)};
}
}  // namespace

TEST_CASE("a Hessian at a kink is that of the smooth function that the parts make", "[autodiff][kinks]") {
  for (const Case& c : smooth_cases) {
    check_hessian(c);
    check_products(c);
    check_sparse(c);
  }
}

TEST_CASE("a Hessian that is not known is NaN and counted", "[autodiff][kinks]") {
  for (const Case& c : kinked_cases) {
    check_hessian(c);
    check_products(c);
    if (c.number != 53) check_sparse(c);
  }
  CHECK(tapestry::hessian(Composite{40}, {0., 3.}).description() ==
        "1 second derivatives are not known, of 4: the function has a kink or an infinite slope there");
  CHECK(tapestry::hessian(Composite{0}, {0., 0.}).description() == "all second derivatives are known");
}

TEST_CASE("a derivative of a derivative at a kink is right or NaN", "[autodiff][kinks]") {
  for (const Case& c : smooth_cases)
    if (c.x[1] == 0) check_nested(c);
  for (const std::size_t number : {40U, 43U, 45U, 46U, 47U, 48U, 49U, 50U, 51U, 52U})
    check_nested({number, {0, 0}, {none, 0, 0}});
}

TEST_CASE("second derivatives by hand at a subgradient are right or NaN", "[autodiff][kinks]") {
  const auto is_told = [](double found, double expected) {
    return std::isnan(found) || agrees(found, expected);
  };
  std::size_t known = 0;
  for (const auto* cases : {&smooth_cases, &kinked_cases})
    for (const Case& c : *cases) {
      const bool has_infinite_slope = c.number == 2 || c.number == 8 || (c.number >= 10 && c.number <= 14) ||
                                      (c.number >= 49 && c.number <= 51) || c.number >= 53;
      const bool takes_side = c.number == 28 || (c.number >= 46 && c.number <= 48) || c.number == 52;
      if (has_infinite_slope || takes_side) continue;
      for (const auto& found : {on_tape(c), by_duals(c)})
        for (std::size_t i = 0; i < 3; ++i) {
          INFO("function " << c.number << ", " << i << ": " << found[i]);
          CHECK(is_told(found[i], c.expected[i]));
          known += static_cast<std::size_t>(!std::isnan(found[i]));
        }
    }
  CHECK(known > 60);
  using Third = Dual<Dual<Dual<double>>>;
  const Third x = Third::input(Dual<Dual<double>>::input(Dual<double>::input(0.0)));
  for (const Third& f : {Third(abs(x) * abs(x)), Third(pow(abs(x), 2)), Third(cos(abs(x)))})
    CHECK(std::isnan(f.tangent().tangent().value()));
  ActiveTape<Dual<Dual<double>>> tape;
  const auto input = tape.input(x.value());
  tape.reverse(Variable<Dual<Dual<double>>>(square(abs(input))));
  CHECK(input.adjoint().value().value() == 0);
  CHECK(std::isnan(input.adjoint().tangent().value()));
  CHECK(std::isnan(input.adjoint().value().tangent()));
  CHECK(on_tape({40, {0, 3}, {}})[1] == 0);  // |x| leaves y² alone
  CHECK(on_tape({40, {0, 3}, {}})[2] == 2);
  CHECK(on_tape({47, {0, 3}, {}})[0] == 0.5);  // a tie has the mean of x and 0: (x / 2)²
}

TEST_CASE("a neighbour outside the domain is left out, and one that throws", "[autodiff][kinks]") {
  const auto guarded = [](auto x) {
    if (x[0] < 0) throw std::domain_error("negative");
    return std::remove_cvref_t<decltype(x[0])>(pow(cbrt(x[0]), 6));
  };
  CHECK(agrees(tapestry::hessian(guarded, {0.})[0], 2));
  const auto nowhere = [](auto x) {
    if (x[0] != 0) throw std::domain_error("elsewhere");
    return std::remove_cvref_t<decltype(x[0])>(square(abs(x[0])));
  };
  CHECK(tapestry::hessian(nowhere, {0.}).unknown == 1);
}

TEST_CASE("Hessians of random sums of squares of lengths are those of the squares written out",
          "[autodiff][kinks]") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> real(-2, 2);
  for (int again = 0; again < 20; ++again) {
    std::array<double, 4> x, w;
    for (double& entry : x) entry = random() % 2 == 0 ? 0.0 : real(random);
    for (double& entry : w) entry = real(random);
    const auto sum_of = [&](auto square_of) {
      return [=](auto v) {
        using V = std::remove_cvref_t<decltype(v[0])>;
        V total = exp(v[0] * w[0] + v[3]);
        for (std::size_t i = 0; i + 1 < 4; ++i)
          total += w[i] * square_of(V(v[i] - x[i]), V(v[i + 1] - x[i + 1])) * cos(v[i]);
        return total;
      };
    };
    const auto by_length = sum_of([](const auto& a, const auto& b) { return square(hypot(a, b)); });
    const auto written = sum_of([](const auto& a, const auto& b) { return a * a + b * b; });
    const auto found = tapestry::hessian(by_length, x), expected = tapestry::hessian(written, x);
    CHECK(found.unknown == 0);
    for (std::size_t i = 0; i < 16; ++i) CHECK(std::abs(found[i] - expected[i]) <= 1e-12);
  }
}

TEST_CASE("NaN times a zero slope is 0 in every sweep", "[autodiff][kinks]") {
  const auto f = [](const auto& x) { return std::remove_cvref_t<decltype(x)>(none * (0.0 * x)); };
  CHECK(tapestry::derivative(f, 2.0).derivative == 0);
  CHECK(tapestry::gradient([&](auto x) { return f(x[0]); }, {2.}).gradient == std::vector<double>{0});
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(2.0)};
  const Variable<double> inner = 0.0 * x[0], outer = none * inner;
  std::feclearexcept(FE_ALL_EXCEPT);
  tape.reverse(outer);
  CHECK(x[0].adjoint() == 0);
  const std::vector<Variable<double>> roots(5, outer);
  CHECK(tapestry::jacobian(tape, roots, x) == std::vector<double>(5));
  CHECK(tapestry::jacobian(tape, std::vector{outer}, x) == std::vector<double>(1));
  using D = Dual<double>;
  Tape<D> of_duals;
  const auto inner_scope = of_duals.activate();
  const Variable<D> input = of_duals.input(D::input(2.0));
  of_duals.reverse(f(input));
  CHECK(input.adjoint().value() == 0);
}
