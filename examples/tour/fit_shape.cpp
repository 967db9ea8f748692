// Differentiates silhouettes: finds where a car stands from one of them, and bends a sphere into it by eight.
#include <chrono>
#include <cstdio>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/geometry/point_columns.hpp>
#include <tapestry/geometry/shapes.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/loss/mesh_regularity.hpp>
#include <tapestry/optim/adam.hpp>
#include <tapestry/raster/silhouette.hpp>

using namespace tapestry;
using Shape = ArrayVariable<double, 2>;
constexpr std::size_t size = 96;  // pixels a side

/// Steps of Adam whose length falls to nothing.
template <std::size_t Rank, class Loss>
void descend(const char* what, Array<double, Rank>& x, int steps, double rate, Loss loss) {
  const auto start = std::chrono::steady_clock::now();
  optim::Adam<double> adam(x.size());
  for (int step = 0; step < steps; ++step) {
    Tape<double> tape;
    const auto scope = tape.activate();
    const auto input = tape.input(x);
    tape.reverse(loss(input));
    adam.set_learning_rate(rate * (steps - step) / steps);
    adam.step({x.data(), x.size()}, {input.adjoint().data(), x.size()});
  }
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  std::printf("%s: %d steps in %.1f s, ", what, steps, seconds.count());
}

int main() {
  const auto car = io::read_obj(TAPESTRY_ASSETS "/car_sedan.obj").mesh;
  const auto camera = [](unsigned i) { return geometry::orbit_camera(0.8 * i, 0.1 * i, 9, {}, 0.6); };
  std::vector<Array<double, 2>> goals;
  for (unsigned i = 0; i < 8; ++i) goals.push_back(raster::silhouette<double>(car, camera(i), size, size));
  const auto miss = [&](const auto& mesh, unsigned i, const Shape& x, const ArrayVariable<double, 1>& pose) {
    return sum(square(raster::silhouette(mesh, camera(i), size, size, x, pose) - goals[i]));
  };

  Array<double, 1> pose = {0.0933, 0.1866, 0.28, 0.2, -0.1, 0.2};  // 20 degrees and 0.3 m off
  descend("pose", pose, 150, 0.02, [&](const auto& at) { return miss(car, 1, {}, at); });
  std::printf("off by %.2f degrees and %.2f cm\n", geometry::length({pose(0), pose(1), pose(2)}) * 57.29578,
              geometry::length({pose(3), pose(4), pose(5)}) * 100);
  const auto sphere = geometry::icosphere(3, 1.2, {0, 0, 0.7});
  const auto topology = geometry::mesh_topology(sphere);
  auto shape = geometry::position_array<double>(sphere);
  descend("shape", shape, 200, 0.03, [&](const auto& at) {
    Variable<double> loss = 3000 * loss::laplacian(topology, at);
    for (unsigned i = 0; i < 8; ++i) loss = loss + miss(sphere, i, at, {});
    return loss;
  });
  double common = 0, either = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const auto found = raster::silhouette(sphere, camera(i), size, size, Shape(shape)).value();
    common += xt::sum(xt::minimum(found, goals[i]))();
    either += xt::sum(xt::maximum(found, goals[i]))();
  }
  std::printf("IoU %.3f\n", common / either);
}
