#include <tapestry/autodiff.hpp>

auto f() {
  return tapestry::gradient([](double x) { return x * x; }, std::vector<double>{1});
}
