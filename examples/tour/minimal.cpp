// One tape; a scalar, an array, and an operation of our own with its pullback.
#include <cstdio>
#include <tapestry/autodiff/array_functions.hpp>

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable;

/// Longest edge length of a triangle [3, 2]; the pullback pushes its two corners apart.
Variable<double> longest_edge(const ArrayVariable<double, 2>& corners) {
  const auto edge = [&](std::size_t i, std::size_t axis) {
    return corners.value()((i + 1) % 3, axis) - corners.value()(i, axis);
  };
  std::size_t longest = 0;
  for (std::size_t i = 1; i < 3; ++i)
    if (std::hypot(edge(i, 0), edge(i, 1)) > std::hypot(edge(longest, 0), edge(longest, 1))) longest = i;
  const double dx = edge(longest, 0), dy = edge(longest, 1), length = std::hypot(dx, dy);
  const auto pullback = [=](double length_adjoint, Array<double, 2>* corners_adjoint) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double pull = length_adjoint * (axis == 0 ? dx : dy) / length;
      (*corners_adjoint)((longest + 1) % 3, axis) += pull;
      (*corners_adjoint)(longest, axis) -= pull;
    }
  };
  return record_scalar(length, pullback, corners);
}

int main() {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const Variable<double> weight = tape.input(0.5);
  const auto corners = tape.input(Array<double, 2>{{0, 0}, {3, 0}, {3, 4}});
  const Variable<double> loss = weight * weight * longest_edge(corners) + exp(-weight) * sum(square(corners));
  tape.reverse(loss);
  std::printf("loss %.6f, by weight %.6f\n", loss.value(), weight.adjoint());
  for (std::size_t i = 0; i < 3; ++i)
    std::printf("by corner %zu: %.6f %.6f\n", i, corners.adjoint()(i, 0), corners.adjoint()(i, 1));
}
