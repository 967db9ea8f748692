#pragma once
#include <tapestry/autodiff/array_derivatives.hpp>
#include "random_array.hpp"

namespace tapestry::test {
/// A number of the array's scalar, from any formula.
template <class X, class Formula>
[[nodiscard]] auto number(const X&, const Formula& formula) {
  return Variable<typename X::value_type>(formula);
}

/// Largest error of hessian_product() of f along a random direction, against central differences of
/// gradients, extrapolated to a step of 0, that a tape of numbers computes, over the largest entry. NaN
/// counts as infinity.
template <class Function, std::size_t... Ranks>
[[nodiscard]] double hessian_product_error(const Function& f, const Array<double, Ranks>&... x) {
  std::uint64_t seed = 7;
  const auto direction = [&seed](const auto& of) {
    auto along = of;
    Random random(++seed);
    for (double& entry : along.storage()) entry = random.uniform(-1.0, 1.0);
    return along;
  };
  const std::tuple<Array<double, Ranks>...> at{x...}, along{direction(x)...};
  constexpr double step = 3e-5;
  const auto gradients = [&](double distance) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const auto input = [&](auto values, const auto& by) {
      for (std::size_t i = 0; i < values.size(); ++i) values.data()[i] += distance * by.data()[i];
      return tape.input(std::move(values));
    };
    return [&]<std::size_t... i>(std::index_sequence<i...>) {
      const std::tuple inputs{input(std::get<i>(at), std::get<i>(along))...};
      tape.reverse(Variable<double>(f(std::get<i>(inputs)...)));
      return std::tuple{Array<double, Ranks>(std::get<i>(inputs).adjoint())...};
    }
    (std::index_sequence_for<Array<double, Ranks>...>());
  };
  const auto here = gradients(0), ahead = gradients(step), behind = gradients(-step),
             nearly_ahead = gradients(step / 2), nearly_behind = gradients(-step / 2);
  const auto found = hessian_product(f, at, along);
  double largest = 0, error = 0;
  const auto compare = [&](const auto& product, const auto& gradient, const auto& own, const auto& a,
                           const auto& b, const auto& c, const auto& d) {
    for (std::size_t i = 0; i < product.size(); ++i) {
      const double whole = (a.data()[i] - b.data()[i]) / (2 * step),
                   half = (c.data()[i] - d.data()[i]) / step, expected = (4 * half - whole) / 3;
      const double off =
          std::abs(product.data()[i] - expected) + std::abs(gradient.data()[i] - own.data()[i]);
      largest = std::max(largest, std::abs(expected));
      error = off <= error ? error : std::isnan(off) ? std::numeric_limits<double>::infinity() : off;
    }
  };
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (compare(std::get<i>(found.product), std::get<i>(found.gradient), std::get<i>(here), std::get<i>(ahead),
             std::get<i>(behind), std::get<i>(nearly_ahead), std::get<i>(nearly_behind)),
     ...);
  }
  (std::index_sequence_for<Array<double, Ranks>...>());
  return error / std::max(largest, 1e-3);
}
}  // namespace tapestry::test
