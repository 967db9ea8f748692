#include <cmath>
#include <tapestry/autodiff.hpp>

/// d (x · sin x) / dx at ½, beside the derivative by hand.
int main() {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(0.5);
  tape.reverse(x * sin(x));
  const double by_hand = std::sin(0.5) + 0.5 * std::cos(0.5);
  return std::abs(x.adjoint() - by_hand) < 1e-15 ? 0 : 1;
}
