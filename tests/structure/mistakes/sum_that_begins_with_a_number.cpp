#include <numeric>
#include <tapestry/autodiff.hpp>

tapestry::Variable<double> f(const std::vector<tapestry::Variable<double>>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0);
}
