#include <cmath>
#include <tapestry/autodiff/record.hpp>

using D = tapestry::Dual<double>;
auto f(const tapestry::Variable<D>& x) {
  return tapestry::record_scalar<D>(
      3 * x.value().value(), [](D g, D* x_adjoint) { *x_adjoint += g * 3; }, x);
}
