#include <tapestry/autodiff.hpp>

using tapestry::Variable;

Variable<double> f(bool which, const Variable<double>& x, const Variable<double>& y) {
  return which ? x * x : x + y;
}
