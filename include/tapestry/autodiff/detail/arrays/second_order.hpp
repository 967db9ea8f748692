#pragma once
#include <tapestry/autodiff/arrays/gather.hpp>

// Reductions on tapes of duals, by their first-order twins. \throws as these

namespace tapestry {
namespace detail {
template <class X>
concept ArrayOfDuals = DifferentiableArray<X> && DualNumber<ArrayScalarType<X>>;

/// An ArrayVariable of a formula.
template <class X>
[[nodiscard]] auto variable_of(const X& x) {
  return ArrayVariable<ArrayScalarType<X>, X::rank>(x);
}
}  // namespace detail

template <Exponential Policy = Exponential::vector, detail::ArrayOfDuals X>
[[nodiscard]] auto softmax_along(const X& x, std::size_t axis) {
  return record_tangent(
      [axis](const auto& at, const auto& along) {
        const auto y = softmax_along<Policy>(at, axis);
        const auto mean = sum_along(y * along, axis);
        return std::pair(y, detail::variable_of(y * (along - repeat(mean, axis))));
      },
      detail::variable_of(x));
}

template <Exponential Policy = Exponential::vector, detail::ArrayOfDuals X>
[[nodiscard]] auto logsumexp_along(const X& x, std::size_t axis) {
  return record_tangent(
      [axis](const auto& at, const auto& along) {
        return std::pair(logsumexp_along<Policy>(at, axis),
                         sum_along(softmax_along<Policy>(at, axis) * along, axis));
      },
      detail::variable_of(x));
}

template <Exponential Policy = Exponential::vector, detail::ArrayOfDuals X>
[[nodiscard]] auto logsumexp(const X& x) {
  return record_tangent(
      [](const auto& at, const auto& along) {
        const Extents<1> line{at.size()};
        const auto share = softmax_along<Policy>(reshape(at, line), 0);
        return std::pair(logsumexp<Policy>(at), sum(share * reshape(along, line)));
      },
      detail::variable_of(x));
}

/// At the origin its derivatives are 0 and second ones NaN, as for |x|.
template <detail::ArrayOfDuals X>
[[nodiscard]] auto norm(const X& x) {
  return record_tangent(
      [](const auto& at, const auto& along) {
        using Number = Variable<detail::ArrayScalarType<decltype(at)>>;
        const Number length = norm(at);
        if (length.value() == 0) return std::pair(length, Number(sum(at * along) * std::nan("")));
        return std::pair(length, Number(sum(at * along) / length));
      },
      detail::variable_of(x));
}
}  // namespace tapestry
