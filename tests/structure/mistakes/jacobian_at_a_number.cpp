#include <tapestry/autodiff/jacobian.hpp>

auto f() {
  return tapestry::jacobian([](const auto& x) { return x[0] * x[0]; }, 3.0);
}
