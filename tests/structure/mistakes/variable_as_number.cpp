#include <tapestry/autodiff.hpp>

double f(const tapestry::Variable<double>& x) { return x; }
