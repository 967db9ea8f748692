#include <cmath>
#include <tapestry/autodiff/record.hpp>

using D = tapestry::Dual<double>;
auto f(const tapestry::Variable<D>& x) {
  const double cosine = std::cos(x.value().value());
  return tapestry::record_scalar<D>(
      D(std::sin(x.value().value())), [=](D g, D* x_adjoint) { *x_adjoint += g * cosine; }, x);
}
