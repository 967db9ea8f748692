#include <tapestry/autodiff.hpp>
#include <vector>

auto f() {
  return tapestry::gradient([](double x) { return x * x; }, std::vector<double>{1});
}
