#include <algorithm>
#include <tapestry/autodiff.hpp>

tapestry::Variable<double> f(const tapestry::Variable<double>& x) { return std::clamp(x, 0.0, 1.0); }
