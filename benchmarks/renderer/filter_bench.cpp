// A checker that is seen at 7 degrees, 256 pixels of 4 x 4 samples: frames and texture operators with each
// filter.
#include <benchmark/benchmark.h>

#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace {
namespace raster = tapestry::raster;
using tapestry::Array, tapestry::geometry::Vector3;

constexpr std::size_t texels_along = 1024, field = 64, pixels = 256, samples = 4;

/// A square of 8 by 8 in pieces, so many along each side.
tapestry::geometry::Mesh sheet(int pieces) {
  const double angle = 0.122, cosine = std::cos(angle), sine = std::sin(angle);
  tapestry::geometry::Mesh mesh;
  for (int row = 0; row <= pieces; ++row)
    for (int column = 0; column <= pieces; ++column) {
      const double u = static_cast<double>(column) / pieces, v = static_cast<double>(row) / pieces;
      mesh.positions.push_back({8 * u - 4, (4 - 8 * v) * sine, 5 + (8 * v - 4) * cosine});
      mesh.uvs.push_back({u, v});
    }
  for (int row = 0; row < pieces; ++row)
    for (int column = 0; column < pieces; ++column) {
      const int a = row * (pieces + 1) + column, b = a + 1, c = b + pieces + 1, d = c - 1;
      mesh.faces.push_back({a, b, c});
      mesh.faces.push_back({a, c, d});
    }
  mesh.face_uvs = mesh.faces;
  return mesh;
}

struct Problem {
  Problem(raster::TextureFilter filter, int pieces) {
    body.mesh = sheet(pieces);
    body.painted.assign(body.mesh.faces.size(), 1);
    body.layout.height = body.layout.width = texels_along;
    body.layout.filter = filter;
    camera.tan_half_fov_x = camera.tan_half_fov_y = 0.5;
    auto checker = tapestry::zeros<float, 2>({texels_along * texels_along, 3});
    for (std::size_t i = 0; i < checker.size(); ++i) {
      const std::size_t row = i / 3 / texels_along, column = i / 3 % texels_along;
      checker.data()[i] = static_cast<float>((row / field + column / field) % 2);
    }
    texels = raster::is_filtered(body.layout) ? raster::MipPyramid(body.layout)(checker) : checker;
  }
  [[nodiscard]] Array<float, 3> picture(std::size_t size, std::size_t rate) const {
    return raster::render_textured(body, camera, size, size, raster::Unlit{}, texels, rate).colour;
  }

  raster::PaintedMesh body;
  tapestry::geometry::Camera camera;
  Array<float, 2> texels;
};

/// Root of the mean square of the difference from 128 x 128 samples a pixel, over pixels of the sheet alone.
double error_of(const Problem& problem) {
  constexpr std::size_t of_pixel = 32;
  static const auto seen = Problem(raster::TextureFilter::bilinear, 1).picture(pixels * of_pixel, 4);
  const auto picture = problem.picture(pixels, samples);
  const auto covered =
      raster::texture_operator<float>(problem.body, problem.camera, pixels, pixels, raster::Unlit{}, 8)
          .coverage;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < pixels; ++i)
    for (std::size_t j = 0; j < pixels; ++j) {
      if (covered(i, j) < 1) continue;
      double mean = 0;
      for (std::size_t k = 0; k < of_pixel * of_pixel; ++k)
        mean += static_cast<double>(seen(i * of_pixel + k / of_pixel, j * of_pixel + k % of_pixel, 0));
      sum += std::pow(static_cast<double>(picture(i, j, 0)) - mean / (of_pixel * of_pixel), 2);
      ++count;
    }
  return std::sqrt(sum / count);
}

raster::TextureFilter filter_of(const benchmark::State& state) {
  return raster::texture_filters[static_cast<std::size_t>(state.range(0))];
}

void frame(benchmark::State& state) {
  tapestry::limit_threads(1);
  const Problem problem(filter_of(state), static_cast<int>(state.range(1)));
  state.counters["rms"] = error_of(problem);
  for (auto _ : state) benchmark::DoNotOptimize(problem.picture(pixels, samples).data());
}

void texture_operator(benchmark::State& state) {
  tapestry::limit_threads(1);
  const Problem problem(filter_of(state), static_cast<int>(state.range(1)));
  for (auto _ : state)
    benchmark::DoNotOptimize(raster::texture_operator<float>(problem.body, problem.camera, pixels, pixels,
                                                             raster::Unlit{}, samples)
                                 .weights.data());
}

// Filters in the order of texture_filters; 2 faces, and 20,000.
BENCHMARK(frame)
    ->ArgsProduct({{0, 1, 2}, {1, 100}})
    ->ArgNames({"filter", "pieces"})
    ->Unit(benchmark::kMillisecond);
BENCHMARK(texture_operator)
    ->ArgsProduct({{0, 1, 2}, {1, 100}})
    ->ArgNames({"filter", "pieces"})
    ->Unit(benchmark::kMillisecond);
}  // namespace
