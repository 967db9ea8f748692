#include <tapestry/autodiff/array_variable.hpp>

tapestry::Variable<double> f(const tapestry::ArrayVariable<double, 1>& a) { return a * a; }
