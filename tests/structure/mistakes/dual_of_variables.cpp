#include <tapestry/autodiff.hpp>

auto f(const tapestry::Dual<tapestry::Variable<double>>& x) { return x.value(); }
