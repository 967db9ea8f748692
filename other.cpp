#include "tapestry_autodiff.hpp"

tapestry::Variable<double> squared(const tapestry::Variable<double>& x) {
  const auto pullback = [x = x.value()](double value_adjoint, double* x_adjoint) {
    *x_adjoint += value_adjoint * 2 * x;
  };
  return record_scalar(x.value() * x.value(), pullback, x);
}
