#include <tapestry/autodiff/dual.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/sparse_hessian.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::dot, tapestry::Dual, tapestry::logsumexp, tapestry::norm, tapestry::softmax, tapestry::sum,
    tapestry::Variable, tapestry::test::ActiveTape;

// sum, dot, norm, logsumexp and softmax of a vector of any scalar.

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
using Values = std::vector<double>;

/// All five functions of a vector, weighted so that each entry has a slope of its own.
struct Five {
  template <class S>
  std::vector<S> operator()(std::span<const S> x) const {
    const std::vector<S> all(x.begin(), x.end());
    std::vector<S> results = {sum(all), dot(all, all), norm(all), logsumexp(all)};
    for (const S& share : softmax(all)) results.push_back(share);
    return results;
  }
};
struct Total {
  template <class S>
  S operator()(std::span<const S> x) const {
    S total(0);
    double weight = 1;
    for (const S& result : Five()(x)) total += (weight += 0.5) * result;
    return total;
  }
};

/// The Jacobian of Five by the formulas of its derivatives, in long double.
Values jacobian_by_hand(const Values& x) {
  const std::size_t n = x.size();
  long double squares = 0, exponentials = 0;
  for (const double entry : x) {
    squares += static_cast<long double>(entry) * static_cast<long double>(entry);
    exponentials += std::exp(static_cast<long double>(entry));
  }
  Values result;
  const auto share = [&](std::size_t i) { return std::exp(static_cast<long double>(x[i])) / exponentials; };
  for (std::size_t j = 0; j < n; ++j) result.push_back(1);
  for (const double entry : x) result.push_back(2 * entry);
  for (const double entry : x)
    result.push_back(static_cast<double>(static_cast<long double>(entry) / std::sqrt(squares)));
  for (std::size_t j = 0; j < n; ++j) result.push_back(static_cast<double>(share(j)));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j)
      result.push_back(static_cast<double>(share(i) * ((i == j ? 1 : 0) - share(j))));
  return result;
}

/// Within 16 roundings, of numbers of size 1 or more.
void check_near(const Values& found, const Values& expected) {
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i)
    CHECK(std::abs(found[i] - expected[i]) <=
          16 * std::numeric_limits<double>::epsilon() * std::max(1.0, std::abs(expected[i])));
}
}  // namespace

TEST_CASE("functions of a vector have one Jacobian, forwards and backwards", "[autodiff][range]") {
  const Values x = {0.5, -1.25, 2, 0.75};
  const Values expected = jacobian_by_hand(x);
  check_near(tapestry::forward_jacobian(Five(), x), expected);
  ActiveTape<double> tape;
  std::vector<Variable<double>> inputs(4);
  tape.input(x, inputs);
  const auto results = Five()(std::span<const Variable<double>>(inputs));
  CHECK(tape.statement_count() == 4 + results.size());  // one statement each
  check_near(tapestry::jacobian(tape, results, inputs), expected);
  const Values values = Five()(std::span<const double>(x));
  for (std::size_t i = 0; i < values.size(); ++i) CHECK(values[i] == results[i].value());
}

TEST_CASE("functions of a vector are differentiated by one number, and of floats", "[autodiff][range]") {
  const auto length = [](const auto& t) {
    using S = std::remove_cvref_t<decltype(t)>;
    return S(norm(std::vector<S>{3 * t, 4 * t}) + sum(std::vector<S>{t, t}));
  };
  CHECK(tapestry::derivative(length, 2.0).derivative == 7);
  CHECK(tapestry::derivative(length, 2.0F).value == 14.0F);
}

TEST_CASE("second derivatives of functions of a vector are those of central differences",
          "[autodiff][range]") {
  const Values x = {0.5, -1.25, 2};
  const Values found = tapestry::hessian(Total(), x);
  for (std::size_t j = 0; j < 3; ++j) {
    const auto gradient = [&](double h) {
      Values at = x;
      at[j] += h;
      return tapestry::gradient(Total(), at).gradient;
    };
    for (std::size_t i = 0; i < 3; ++i) {
      const auto quotient = [&](double h) { return (gradient(h)[i] - gradient(-h)[i]) / (2 * h); };
      CHECK(std::abs(found[i * 3 + j] - (4 * quotient(0x1p-11) - quotient(0x1p-10)) / 3) <= 1e-10);
    }
  }
}

TEST_CASE("the pattern of a function of a vector is that of its Hessian", "[autodiff][range]") {
  const auto pattern_of = [](const auto& f) { return tapestry::hessian_pattern(f, Values{1, 2, 3}); };
  const auto entries = [&](const auto& f) { return pattern_of(f).entry_count(); };
  CHECK(entries([]<class S>(std::span<const S> x) { return S(sum(x)); }) == 0);
  CHECK(entries([]<class S>(std::span<const S> x) { return S(dot(x, x)); }) == 3);
  CHECK(entries([]<class S>(std::span<const S> x) { return S(norm(x)); }) == 9);
  CHECK(entries([]<class S>(std::span<const S> x) { return S(logsumexp(x)); }) == 9);
  CHECK(entries([]<class S>(std::span<const S> x) { return S(softmax(x)[1]); }) == 9);
}

TEST_CASE("a dual vector of infinite entries has the slopes that the tape gives", "[autodiff][range]") {
  const auto slopes = [](const auto& f, const Values& x) {
    const Values found = tapestry::forward_jacobian(f, x);
    CHECK(found == tapestry::gradient(f, x).gradient);
    return found;
  };
  const auto length = []<class S>(std::span<const S> x) { return S(norm(x)); };
  const auto total = []<class S>(std::span<const S> x) { return S(logsumexp(x)); };
  CHECK(slopes(length, {infinity, 1, -infinity}) == Values{1, 0, -1});
  CHECK(slopes(length, {0, 0}) == Values{0, 0});
  CHECK(slopes(total, {infinity, 1, infinity}) == Values{0.5, 0, 0.5});
  CHECK(slopes(total, {-infinity, -infinity}) == Values{0.5, 0.5});
  CHECK(slopes(total, {-infinity, 3}) == Values{0, 1});
  // The same on a tape of duals: the value carries the derivatives that the slopes multiply.
  const auto mixed = [](const auto& f, const Values& x) {
    return tapestry::hessian_product(f, x, Values(x.size(), 1)).gradient;
  };
  CHECK(mixed(length, {infinity, 1, -infinity}) == Values{1, 0, -1});
  using D = Dual<double>;
  const Dual<D> entry(D::input(infinity), {D(1)});
  CHECK(norm(std::vector<Dual<D>>{entry, entry}).value().tangent() == 2);
  CHECK(logsumexp(std::vector<Dual<D>>{entry}).value().tangent() == 1);
}
