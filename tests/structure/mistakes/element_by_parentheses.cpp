#include <tapestry/autodiff/array_variable.hpp>

void f(const tapestry::ArrayVariable<double, 2>& x) { x(0, 1); }
