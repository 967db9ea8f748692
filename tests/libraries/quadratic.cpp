#include "libraries.hpp"

#include <tapestry/autodiff.hpp>

namespace {
thread_local tapestry::Tape<double> tape;
thread_local tapestry::Variable<double> input, result;
}  // namespace

void quadratic_record(double x, void (*meanwhile)()) {
  const auto scope = tape.activate();
  tape.clear();
  input = tape.input(x);
  meanwhile();
  result = input * input;
}
double quadratic_slope() {
  tape.reverse(result);
  return tape.adjoint(input);
}
int quadratic_statements() { return static_cast<int>(tape.statement_count()); }
