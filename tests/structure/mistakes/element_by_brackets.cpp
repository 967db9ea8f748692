#include <tapestry/autodiff/array_variable.hpp>

void f(const tapestry::ArrayVariable<double, 1>& x) { x[0]; }
