#include <tapestry/loss/cross_entropy.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
template <class T>
Array<T, 4> one(T value) {
  return tapestry::filled<T, 4>({1, 1, 1, 1}, value);
}

/// −t · log σ(x) − (1 − t) · log σ(−x) and its slope, in numbers whose exponentials do not overflow.
double entropy_of(double logit, double wanted) {
  const auto x = static_cast<long double>(logit), t = static_cast<long double>(wanted);
  return static_cast<double>(t * std::log1p(std::exp(-x)) + (1 - t) * std::log1p(std::exp(x)));
}
double slope_of(double logit, double wanted) {
  const auto x = static_cast<long double>(logit), t = static_cast<long double>(wanted);
  return static_cast<double>((1 - t) / (1 + std::exp(-x)) - t / (1 + std::exp(x)));
}

/// Random shares that sum to 1 along axis 1.
Array<double, 4> random_shares() {
  auto shares = random_array<double>({2, 3, 2, 2}, 1);
  for (std::size_t n = 0; n < 2; ++n)
    for (std::size_t cell = 0; cell < 4; ++cell) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) sum += shares(n, k, cell / 2, cell % 2);
      for (std::size_t k = 0; k < 3; ++k) shares(n, k, cell / 2, cell % 2) /= sum;
    }
  return shares;
}
}  // namespace

TEST_CASE("binary cross entropy of one logit keeps its digits at both ends", "[loss][cross_entropy]") {
  for (const double wanted : {0.0, 0.3, 1.0})
    for (const double x : {-800.0, -40.0, -1.5, 0.0, 0.7, 40.0, 800.0}) {
      CAPTURE(wanted, x);
      CHECK(loss::binary_cross_entropy(one(x), one(wanted)) == Approx(entropy_of(x, wanted)).epsilon(1e-14));
      auto adjoint = one(0.0);
      loss::binary_cross_entropy_adjoint(one(x), one(wanted), 1.0, adjoint);
      CHECK(adjoint(0, 0, 0, 0) == Approx(slope_of(x, wanted)).epsilon(1e-14));
    }
  CHECK(loss::binary_cross_entropy(one(40.F), one(1.F)) == Approx(std::exp(-40.0)).epsilon(1e-6));
  CHECK(std::isnan(loss::binary_cross_entropy(one(std::numeric_limits<float>::quiet_NaN()), one(1.F))));
}

TEST_CASE("cross entropy of two classes is the binary one of their difference", "[loss][cross_entropy]") {
  for (const double x : {-700.0, -2.0, 0.0, 3.0, 700.0}) {
    const Array<double, 4> logits{{{{x + 5}}, {{5.0}}}}, wanted{{{{0.75}}, {{0.25}}}};
    CHECK(loss::cross_entropy(logits, wanted) == Approx(entropy_of(x, 0.75)).epsilon(1e-13));
  }
}

TEST_CASE("a logit of minus infinity for a class that is not wanted costs nothing", "[loss][cross_entropy]") {
  const double none = -std::numeric_limits<double>::infinity();
  const Array<double, 4> logits{{{{0.0}}, {{none}}}}, wanted{{{{1.0}}, {{0.0}}}};
  CHECK(loss::cross_entropy(logits, wanted) == 0);
}

TEST_CASE("both cross entropies of computed logits agree with central differences",
          "[loss][cross_entropy][gradient]") {
  const auto shares = std::make_shared<const Array<double, 4>>(random_shares());
  const auto start = random_array<double>({2, 3, 2, 2}, 2, -3, 3);
  const auto direction = test::random_direction<double>({2, 3, 2, 2}, 3);
  const bool is_binary = GENERATE(true, false);
  const auto of = [&](const ArrayVariable<double, 4>& x) {
    const ArrayVariable<double, 4> computed = x * exp(0.2 * x);
    return is_binary ? loss::binary_cross_entropy(computed, shares) : loss::cross_entropy(computed, shares);
  };
  const auto value = [&](const Array<double, 4>& x) { return of(ArrayVariable<double, 4>(x)).value(); };
  ActiveTape<double> tape;
  const auto x = tape.input(start);
  tape.reverse(3 * of(x));
  CHECK(test::dot(x.adjoint(), direction) ==
        Approx(3 * test::central_difference(value, start, direction)).epsilon(1e-8));
}

TEST_CASE("cross entropies refuse other extents and nothing", "[loss][cross_entropy][error]") {
  const auto logits = random_array<float>({1, 2, 3, 4}, 4);
  CHECK_THROWS_WITH(loss::binary_cross_entropy(logits, random_array<float>({1, 2, 4, 3}, 5)),
                    "binary_cross_entropy: wanted is [1, 2, 4, 3], expected [1, 2, 3, 4]");
  const auto none = tapestry::zeros<float, 4>({0, 2, 3, 4});
  CHECK_THROWS_WITH(loss::cross_entropy(none, none), "cross_entropy: no logits");
}
