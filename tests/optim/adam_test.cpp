#include <tapestry/optim/adam.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace optim = tapestry::optim;

TEST_CASE("Adam takes the steps worked out by hand", "[optim][adam]") {
  optim::Adam<double> adam(1, {0.1, 0.9, 0.999, 0.0});
  std::vector<double> x{1.0};
  // t = 1: m = 0.2, m̂ = 2, v = 0.004, v̂ = 4: the step is η · 2 / 2
  adam.step(x, std::vector<double>{2.0});
  CHECK(x[0] == Approx(0.9).epsilon(1e-14));
  // t = 2: m = 0.18 − 0.1 = 0.08, m̂ = 0.08 / 0.19; v = 0.003996 + 0.001 = 0.004996, v̂ = v / 0.001999
  adam.step(x, std::vector<double>{-1.0});
  CHECK(x[0] == Approx(0.9 - 0.1 * (0.08 / 0.19) / std::sqrt(0.004996 / 0.001999)).epsilon(1e-12));
  CHECK(adam.state().step == 2);
  CHECK(adam.state().first_moment[0] == Approx(0.08).epsilon(1e-14));
  CHECK(adam.state().second_moment[0] == Approx(0.004996).epsilon(1e-14));
}

TEMPLATE_TEST_CASE("Adam's first step has the length of the learning rate", "[optim][adam]", float, double) {
  optim::Adam<TestType> adam(3);
  std::vector<TestType> x{0, 0, 0};
  adam.step(x, std::vector<TestType>{TestType(5), TestType(-1e-3), TestType(0)});
  CHECK(x[0] == Approx(-0.01).epsilon(1e-5));
  CHECK(x[1] == Approx(0.01).epsilon(2e-5));  // ε / |g| = 1e−5
  CHECK(x[2] == TestType(0));
}

TEST_CASE("Adam leaves a parameter without a slope where it is, also with epsilon 0", "[optim][adam]") {
  optim::Adam<double> adam(1, {0.1, 0.9, 0.999, 0.0});
  std::vector<double> x{1.0};
  adam.step(x, std::vector<double>{0.0});
  CHECK(x[0] == 1.0);
}

TEST_CASE("Adam goes on to the same bits after its state was saved and restored", "[optim][adam]") {
  constexpr std::size_t count = 40000;  // more than one block
  const auto start = tapestry::test::random_array<float>({count}, 1);
  const auto gradients = tapestry::test::random_array<float>({4, count}, 2, -1, 1);
  const auto take = [&](optim::Adam<float>& adam, auto& x, std::size_t step) {
    adam.step({x.data(), count}, {gradients.data() + step * count, count});
  };
  auto whole = start;
  optim::Adam<float> uninterrupted(count);
  for (std::size_t step = 0; step < 4; ++step) take(uninterrupted, whole, step);

  auto halves = start;
  optim::Adam<float> first(count);
  for (std::size_t step = 0; step < 2; ++step) take(first, halves, step);
  optim::Adam<float> second(count);
  second.restore(first.state());
  for (std::size_t step = 2; step < 4; ++step) take(second, halves, step);
  CHECK((whole == halves));
}

TEST_CASE("Adam reaches the minimum of a parabola", "[optim][adam]") {
  optim::Adam<double> adam(2);
  std::vector<double> x{0.5, -0.25};
  for (int step = 0; step < 2000; ++step) adam.step(x, std::vector<double>{2 * (x[0] - 0.1), 20 * x[1]});
  CHECK(std::abs(x[0] - 0.1) < 1e-3);
  CHECK(std::abs(x[1]) < 1e-3);
}

TEST_CASE("Adam lets NaN through to its own parameter only", "[optim][adam]") {
  optim::Adam<double> adam(2);
  std::vector<double> x{0.0, 0.0};
  adam.step(x, std::vector<double>{std::numeric_limits<double>::quiet_NaN(), 1.0});
  CHECK(std::isnan(x[0]));
  CHECK(x[1] == Approx(-0.01));
}

TEST_CASE("Adam refuses lengths and settings that do not fit", "[optim][adam]") {  // T04
  optim::Adam<double> adam(2);
  std::vector<double> two{0, 0}, three{0, 0, 0};
  CHECK_THROWS_WITH(adam.step(three, two), "Adam: parameters has 3 values, expected 2");
  CHECK_THROWS_WITH(adam.step(two, three), "Adam: gradient has 3 values, expected 2");
  CHECK_THROWS_AS(adam.restore(optim::Adam<double>(3).state()), tapestry::ShapeError);
  CHECK_THROWS_AS(optim::Adam<double>(1, {0.1, 1.0, 0.999, 1e-8}), tapestry::DomainError);
  CHECK_THROWS_AS(optim::Adam<double>(1, {0.1, 0.9, 0.999, -1.0}), tapestry::DomainError);
  CHECK_THROWS_AS(optim::Adam<double>(1, {std::nan(""), 0.9, 0.999, 1e-8}), tapestry::DomainError);
}

TEST_CASE("Adam moves arrays as it moves lists", "[optim][adam]") {
  optim::Adam<double> of_list(6), of_array(6);
  std::vector<double> list{1, 2, 3, 4, 5, 6};
  tapestry::Array<double, 2> array = {{1, 2, 3}, {4, 5, 6}};
  const tapestry::Array<double, 2> gradient = {{0.5, -1, 2}, {0, 3, -0.25}};
  for (int step = 0; step < 3; ++step) {
    of_list.step(list, std::vector<double>{0.5, -1, 2, 0, 3, -0.25});
    of_array.step(array, gradient);
  }
  CHECK(std::equal(list.begin(), list.end(), array.data()));
  CHECK_THROWS_WITH(of_array.step(array, tapestry::zeros<double, 2>({3, 2})),
                    "Adam: gradient is [3, 2], expected [2, 3]");
}
