#include <algorithm>
#include <tapestry/autodiff.hpp>

tapestry::Variable<double> f(const tapestry::Variable<double>& x) { return std::max(x, 0.0); }
