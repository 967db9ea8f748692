#include <tapestry/autodiff.hpp>

using tapestry::Variable;

Variable<double> f(const Variable<double>& x, const Variable<float>& y) { return x * y; }
