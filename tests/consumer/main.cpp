#include <iostream>
#include <tapestry/tapestry.hpp>

#include "other.hpp"

/// All of the library in two translation units of one program, and a number that both must agree on. stb's
/// functions are in the other one.
int main() {
  tapestry::Array<float, 3> render = tapestry::zeros<float, 3>({2, 2, 1});
  render(1, 0, 0) = 3;
  render(0, 1, 0) = 1;
  const double here = tapestry::loss::smoothness(render, tapestry::filled<float, 2>({2, 2}, 1.0F));
  const double there = smoothness_elsewhere(render);
  tapestry::io::write_image("consumer.png", tapestry::zeros<float, 3>({2, 2, 3}));
  std::cout << here << ' ' << there << '\n';
  return here == 10 && there == here ? 0 : 1;
}
