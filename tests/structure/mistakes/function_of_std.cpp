#include <cmath>
#include <tapestry/autodiff.hpp>

tapestry::Variable<double> f(const tapestry::Variable<double>& x) { return std::sin(x); }
