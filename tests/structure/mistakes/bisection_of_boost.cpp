#include <tapestry/autodiff/boost.hpp>
#include <tapestry/autodiff/functions.hpp>

#include <boost/math/tools/roots.hpp>

using V = tapestry::Variable<double>;
V f(const V& p) {
  const auto cubic = [&p](const V& x) -> V { return x * x * x + p * x - 1; };
  const auto is_near = [](const V& a, const V& b) { return abs(a - b) < 1e-12; };
  return boost::math::tools::bisect(cubic, V(0), V(1), is_near).first;
}
