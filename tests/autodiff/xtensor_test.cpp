#include <tapestry/autodiff/dual.hpp>
#include <tapestry/core/array.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Array, tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

// xtensor's own reductions do not take variables, whose sums are formulas: sum(), dot(), norm(), logsumexp()
// and softmax() of functions.hpp take arrays of variables as they take vectors. xtensor has a sum() that
// would be found by the argument as well.
TEST_CASE("xtensor's expressions of variables are differentiated", "[autodiff][xtensor]") {
  ActiveTape<double> tape;
  const Variable<double> a = tape.input(2.0), b = tape.input(4.0);
  const Array<Variable<double>, 1> x = {a, b, a}, y = {b, b, a};
  const Array<Variable<double>, 1> z = x * y + 2.0 * x - y / x;
  const Variable<double> total = tapestry::sum(z) * norm(x);
  CHECK(z(0).value() == 10);
  tape.reverse(tapestry::sum(z));  // ab + b² + a² + 2(2a + b) − b/a − 1 − 1
  CHECK(a.adjoint() == 4 + 4 + 4 + 1.0);
  CHECK(b.adjoint() == 2 + 8 + 2 - 0.5);
  CHECK(total.is_active());
}

TEST_CASE("xtensor's expressions of duals carry derivatives", "[autodiff][xtensor]") {
  using D = Dual<double>;
  const Array<D, 1> x = {D::input(2.0), D(4.0)};
  const Array<D, 1> z = x * x + 1.0;
  CHECK(z(0).tangent() == 4);
  CHECK(z(1).tangent() == 0);
}
