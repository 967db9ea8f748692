#include <iostream>
#include <xtensor/xarray.hpp>
#include <xtensor/xio.hpp>
#include <xtensor/xmath.hpp>
#include <xtensor/xtensor.hpp>
#include <xtensor/xview.hpp>

int main() {
  const xt::xtensor<double, 2> a = xt::eye<double>(3);
  std::cout << xt::sum(a * xt::sin(a))() << '\n';
}
