#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/checkpoint.hpp>

#include <thread>

#include "../../support/catch.hpp"

using tapestry::DomainError, tapestry::Variable;

namespace {
using Words = const void*;

/// Where the active tape writes next.
Words place() { return tapestry::detail::TapeState<double>::active->words; }

/// The gradient of a product of 1,000 factors x, and where its tape began.
Words place_of_gradient(double x, std::size_t factor_count = 1000) {
  Words begin = nullptr;
  const auto result = tapestry::gradient(
      [&](auto v) {
        begin = place();
        Variable<double> product = 1;
        for (std::size_t i = 0; i < factor_count; ++i) product *= v[0];
        return product;
      },
      {x});
  CHECK(result.gradient[0] == static_cast<double>(factor_count) * (x == 1 ? 1 : 0));
  return begin;
}
}  // namespace

TEST_CASE("a gradient is taken in the memory of the one before, on each thread", "[autodiff][spare]") {
  const Words first = place_of_gradient(1);
  CHECK(place_of_gradient(1) == first);
  CHECK(place_of_gradient(0) == first);
  Words elsewhere = first;
  std::thread([&] { elsewhere = place_of_gradient(1); }).join();
  CHECK(elsewhere != first);
}

TEST_CASE("gradients inside a gradient have tapes of their own", "[autodiff][spare]") {
  Words inner = nullptr;
  const auto outer = tapestry::gradient(
      [&](auto v) {
        const Words mine = place();
        inner = place_of_gradient(1);
        CHECK(inner != mine);
        CHECK(place() == mine);
        return v[0] * v[1];
      },
      {2, 3});
  CHECK(outer.gradient == std::vector<double>{3, 2});
}

TEST_CASE("a call that throws leaves a tape that serves again, and no variable of it", "[autodiff][spare]") {
  Variable<double> escaped;
  const auto fails = [&](auto v) -> Variable<double> {
    escaped = v[0] * v[0];
    throw std::runtime_error("no");
  };
  CHECK_THROWS_AS(tapestry::gradient(fails, {1}), std::runtime_error);
  CHECK(tapestry::gradient([](auto v) { return v[0] * v[0]; }, {3}).gradient[0] == 6);
  CHECK_THROWS_AS(tapestry::gradient([&](auto v) { return v[0] * escaped; }, {3}), DomainError);
  CHECK(tapestry::hessian([](auto v) { return v[0] * v[0]; }, {3}) == std::vector<double>{2});
}

TEST_CASE("checkpoints and preaccumulated parts take the memory of the one before", "[autodiff][spare]") {
  std::vector<Words> places;
  const auto part = [&](std::span<const Variable<double>> v) {
    places.push_back(place());
    return Variable<double>(v[0] * v[0]);
  };
  const auto whole = [&](auto v) {
    Variable<double> y = v[0];
    for (int i = 0; i < 3; ++i) y = tapestry::preaccumulate<double>(part, std::array{y});
    return y;
  };
  CHECK(tapestry::gradient(whole, {1}).gradient[0] == 8);
  REQUIRE(places.size() == 3);
  CHECK(places[1] == places[2]);
}
