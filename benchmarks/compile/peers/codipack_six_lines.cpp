#include <codi.hpp>

double derivative(double value) {
  using Number = codi::RealReverse;
  auto& tape = Number::getTape();
  Number x = value;
  tape.setActive();
  tape.registerInput(x);
  Number y = x * sin(x);
  tape.registerOutput(y);
  tape.setPassive();
  y.setGradient(1.0);
  tape.evaluate();
  const double slope = x.getGradient();
  tape.reset();
  return slope;
}
