#include <tapestry/autodiff.hpp>

auto f() {
  return tapestry::gradient([](const auto& x) { return x[0] * x[0]; }, 3.0);
}
