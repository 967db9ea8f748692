#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/attention.hpp>

namespace tapestry::loss {
namespace detail {
/// The connected parts of a heat map: for each place the number of its part, from 1, or 0 where there is no
/// heat; neighbours are above, below, left and right.
struct HeatParts {
  std::vector<std::size_t> part;
  std::vector<std::size_t> sizes;  ///< size of part p at index p − 1

  /// Weight of a place of a part: 1 over the number of parts and H·W + 1 − size.
  [[nodiscard]] double weight(std::size_t place) const {
    const std::size_t rest = part.size() + 1 - sizes[part[place] - 1];
    return 1 / (static_cast<double>(sizes.size()) * static_cast<double>(rest));
  }
};

template <std::floating_point T>
[[nodiscard]] HeatParts heat_parts(const Array<T, 2>& heat) {
  const std::size_t height = heat.shape(0), width = heat.shape(1);
  HeatParts parts{std::vector<std::size_t>(heat.size(), 0), {}};
  std::vector<std::size_t> open;
  const auto join = [&](std::size_t place) {
    if (parts.part[place] != 0 || !(heat.data()[place] > T(0))) return;
    parts.part[place] = parts.sizes.size();
    ++parts.sizes.back();
    open.push_back(place);
  };
  for (std::size_t start = 0; start < heat.size(); ++start) {
    if (parts.part[start] != 0 || !(heat.data()[start] > T(0))) continue;
    parts.sizes.push_back(0);
    join(start);
    while (!open.empty()) {
      const std::size_t place = open.back(), x = place % width, y = place / width;
      open.pop_back();
      if (x > 0) join(place - 1);
      if (x + 1 < width) join(place + 1);
      if (y > 0) join(place - width);
      if (y + 1 < height) join(place + width);
    }
  }
  return parts;
}
}  // namespace detail

template <std::floating_point T>
T attention(const Array<T, 2>& heat) {
  const auto parts = detail::heat_parts(heat);
  double loss = 0;
  for (std::size_t i = 0; i < heat.size(); ++i)
    if (parts.part[i] != 0) loss += parts.weight(i) * std::tanh(static_cast<double>(heat.data()[i]));
  return static_cast<T>(loss);
}

template <std::floating_point T>
void attention_adjoint(const Array<T, 2>& heat, T loss_adjoint, Array<T, 2>& heat_adjoint) {
  require_shape("attention_adjoint", "heat_adjoint", heat_adjoint, heat.shape());
  const auto parts = detail::heat_parts(heat);
  for (std::size_t i = 0; i < heat.size(); ++i) {
    if (parts.part[i] == 0) continue;
    const double value = std::tanh(static_cast<double>(heat.data()[i]));
    heat_adjoint.data()[i] +=
        static_cast<T>(static_cast<double>(loss_adjoint) * parts.weight(i) * (1 - value * value));
  }
}

template <std::floating_point T>
Variable<T> attention(const ArrayVariable<T, 2>& heat) {
  const auto pullback = [kept = heat.value()](T loss_adjoint, Array<T, 2>* heat_adjoint) {
    attention_adjoint(kept, loss_adjoint, *heat_adjoint);
  };
  return record_scalar(attention(heat.value()), pullback, heat);
}
}  // namespace tapestry::loss
