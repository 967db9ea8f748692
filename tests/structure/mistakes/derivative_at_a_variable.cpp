#include <tapestry/autodiff.hpp>

auto f(const tapestry::Variable<double>& x) {
  return tapestry::derivative([](const auto& y) { return y * y; }, x);
}
