#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/gradient_check.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable, tapestry::test::random_array;

namespace {
double product_of_waves(const Array<double, 1>& x) {
  double value = 1;
  for (const double element : x.storage()) value *= 1.5 + std::sin(element);
  return value;
}

Array<double, 1> product_of_waves_gradient(const Array<double, 1>& x) {
  Array<double, 1> gradient = x;
  for (double& element : gradient.storage())
    element = product_of_waves(x) * std::cos(element) / (1.5 + std::sin(element));
  return gradient;
}
}  // namespace

TEST_CASE("a right gradient passes, more closely with Richardson extrapolation",
          "[autodiff][gradient_check]") {
  const auto x = random_array<double>({20}, 1, -2, 2);
  const auto gradient = product_of_waves_gradient(x);
  const auto plain = tapestry::check_gradient(product_of_waves, x, gradient);
  CHECK(plain.passed());
  CHECK(plain.checked == 20);
  CHECK(plain.kinks.empty());
  const auto extrapolated = tapestry::check_gradient(product_of_waves, x, gradient, {.richardson = true});
  CHECK(extrapolated.worst.relative_error < 1e-9);
  CHECK(extrapolated.worst.relative_error < plain.worst.relative_error);
}

TEST_CASE("a wrong entry is found and named", "[autodiff][gradient_check]") {
  const auto x = random_array<double>({4, 5}, 1, -2, 2);
  const auto f = [](const Array<double, 2>& at) {
    double value = 0;
    for (const double element : at.storage()) value += element * element;
    return value;
  };
  Array<double, 2> gradient = 2 * x;
  gradient(2, 3) += 1e-3;
  const auto report = tapestry::check_gradient(f, x, gradient);
  CHECK_FALSE(report.passed());
  REQUIRE(report.failures.size() == 1);
  CHECK(report.worst.index == 13);
  CHECK(report.worst.analytic == gradient(2, 3));
  CHECK(std::abs(report.worst.numeric - 2 * x(2, 3)) <= 1e-8);
  CHECK(report.worst.step > 0);
  CHECK(report.to_text().find("failed entry 13") != std::string::npos);
  gradient(2, 3) = std::numeric_limits<double>::quiet_NaN();
  CHECK(tapestry::check_gradient(f, x, gradient).failures.size() == 1);
}

TEST_CASE("a kink within the step is told from a wrong gradient", "[autodiff][gradient_check]") {
  const double h = 0x1p-17;  // the default step near 0
  for (const double distance : {0.0, h / 8, h / 3, 2 * h / 3}) {
    const Array<double, 1> x = {distance, 2.0};
    const auto f = [](const Array<double, 1>& at) { return std::abs(at(0)) + std::sin(at(1)); };
    const Array<double, 1> gradient = {1, std::cos(2.0)};
    const auto report = tapestry::check_gradient(f, x, gradient);
    INFO("at " << distance);
    CHECK(report.passed());
    REQUIRE(report.kinks.size() == 1);
    CHECK(report.kinks.front().index == 0);
  }
  const auto jump = [](const Array<double, 1>& at) { return at(0) < 1 ? at(0) : at(0) + 1; };
  CHECK(tapestry::check_gradient(jump, Array<double, 1>{1 - h / 3}, Array<double, 1>{1}).kinks.size() == 1);
}

TEST_CASE("what a function rounds by can be said, and a wrong gradient is still found",
          "[autodiff][gradient_check]") {
  const auto noisy = [](const Array<double, 1>& x) {  // by 20 epsilon, another way at every argument
    double sum = 1;
    for (const double element : x.storage()) sum += 1e-6 * element + 4.4e-15 * std::sin(1e12 * element);
    return sum;
  };
  const auto x = random_array<double>({20}, 5, 0.1, 0.9);
  auto gradient = tapestry::filled<double, 1>({20}, 1e-6);
  tapestry::GradientCheckOptions options;
  options.step = 1e-5;
  const auto strict = tapestry::check_gradient(noisy, x, gradient, options);
  CHECK(strict.failures.size() + strict.kinks.size() > 0);
  options.rounding = 64;
  const auto told = tapestry::check_gradient(noisy, x, gradient, options);
  CHECK(told.passed());
  CHECK(told.kinks.empty());
  gradient(3) = 1e-6 + 1e-8;
  CHECK_FALSE(tapestry::check_gradient(noisy, x, gradient, options).passed());
}

TEST_CASE("check_hessian passes a smooth function, and tells kinks of its gradient",
          "[autodiff][gradient_check]") {
  const auto smooth = [](auto x) { return exp(x[0] * x[1]) * sin(x[2]) + x[1] / x[2]; };
  const auto right = tapestry::check_hessian(smooth, std::vector<double>{0.3, -1.2, 0.8});
  INFO(right.to_text());
  CHECK(right.passed());
  CHECK(right.checked == 9);
  CHECK(right.worst.relative_error > 0);
  CHECK(tapestry::check_hessian(smooth, std::vector<double>{0.3, -1.2, 0.8}, {.subset = 1}).checked == 3);
  const double h = 0x1p-17;  // the default step near 0
  const auto bent =
      tapestry::check_hessian([](auto x) { return x[0] * abs(x[0]); }, std::vector<double>{h / 3});
  CHECK(bent.passed());
  CHECK(bent.kinks.size() == 1);
}

TEST_CASE("a seeded subset is checked instead of all", "[autodiff][gradient_check]") {
  const auto x = random_array<double>({1000}, 1, -1, 1);
  const auto f = [](const Array<double, 1>& at) { return at(3) * at(500); };
  Array<double, 1> wrong = tapestry::filled<double, 1>({1000}, 1.0);
  const auto first = tapestry::check_gradient(f, x, wrong, {.subset = 10, .seed = 5});
  const auto again = tapestry::check_gradient(f, x, wrong, {.subset = 10, .seed = 5});
  const auto other = tapestry::check_gradient(f, x, wrong, {.subset = 10, .seed = 6});
  REQUIRE(first.failures.size() == 10);
  CHECK(first.to_text() == again.to_text());
  CHECK(first.to_text() != other.to_text());
}

TEST_CASE("a function on the tape is checked against its own gradient", "[autodiff][gradient_check]") {
  const auto x = random_array<double>({3, 4}, 1, -2, 2);
  const auto good = [](const ArrayVariable<double, 2>& at) {
    return Variable<double>(logsumexp(at) * sum(tanh(at)));
  };
  CHECK(tapestry::check_tape_gradient(good, x).passed());
  const auto bad = [](const ArrayVariable<double, 2>& at) {
    return tapestry::record_scalar(
        sum(square(passive(at))).value(),
        [at](double g, Array<double, 2>* by_x) {
          for (std::size_t i = 0; i < by_x->size(); ++i)
            by_x->data()[i] += g * at.value().data()[i];  // 2 is missing
        },
        at);
  };
  CHECK(tapestry::check_tape_gradient(bad, x).failures.size() == 12);
}

TEST_CASE("a check of no entries names none", "[autodiff][gradient_check]") {
  const Array<double, 1> nothing(tapestry::Extents<1>{0});
  const auto report = tapestry::check_gradient([](const Array<double, 1>&) { return 1.0; }, nothing, nothing);
  CHECK(report.passed());
  CHECK(report.to_text() == "0 entries checked, 0 above tolerance, 0 at kinks");
}

TEST_CASE("a gradient of other extents is refused", "[autodiff][gradient_check]") {
  const Array<double, 1> x = {1, 2};
  CHECK_THROWS_WITH(tapestry::check_gradient(product_of_waves, x, Array<double, 1>{1}),
                    "check_gradient: gradient is [1], expected [2]");
}

TEST_CASE("the tape and dual numbers are checked against each other", "[autodiff][gradient_check]") {
  const auto good = []<class S>(std::span<S> x) {
    std::remove_const_t<S> total = 0;
    for (std::size_t i = 0; i + 1 < x.size(); ++i) total += tanh(x[i] * x[i + 1]) + abs(x[i]);
    return total;
  };
  const std::vector<double> x = {0.5, 0, -1.25, 2};
  const auto report = tapestry::check_gradient_by_duals(good, x);
  CHECK(report.passed());
  CHECK(report.checked == 4);
  CHECK(report.worst.relative_error <= 1e-15);

  // A gradient stopped on the tape alone: entry 2 is wrong there, by all of it.
  const auto stopped = []<class S>(std::span<S> v) {
    using V = std::remove_const_t<S>;
    const V factor = std::is_same_v<V, tapestry::Variable<double>> ? passive(v[2]) : v[2];
    return V(v[0] * factor);
  };
  const auto failed = tapestry::check_gradient_by_duals(stopped, x);
  REQUIRE(failed.failures.size() == 1);
  CHECK(failed.worst.index == 2);
  CHECK(failed.worst.analytic == 0);
  CHECK(failed.worst.numeric == 0.5);
}
