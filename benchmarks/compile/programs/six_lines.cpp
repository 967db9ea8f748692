#include <tapestry/autodiff.hpp>

double derivative(double value) {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(value);
  const tapestry::Variable<double> y = x * sin(x);
  tape.reverse(y);
  return x.adjoint();
}
