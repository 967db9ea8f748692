#include <tapestry/raster/fragments.hpp>

#include "../support/catch.hpp"

namespace raster = tapestry::raster;
using tapestry::geometry::Camera, tapestry::geometry::Mesh;

namespace {
constexpr std::size_t cells = 1000;  // along each axis of a wall at z = 2 that fills the picture and more

/// A square wall cut into 1000 × 1000 cells of two faces each, face 2·(row · cells + column) above the
/// diagonal from the upper left to the lower right.
Mesh wall() {
  Mesh mesh;
  for (std::size_t row = 0; row <= cells; ++row)
    for (std::size_t column = 0; column <= cells; ++column)
      mesh.positions.push_back(
          {4.4 * static_cast<double>(column) / cells - 2.2, 4.4 * static_cast<double>(row) / cells - 2.2, 2});
  const auto index = [](std::size_t row, std::size_t column) {
    return static_cast<std::int32_t>(row * (cells + 1) + column);
  };
  for (std::size_t row = 0; row < cells; ++row) {
    for (std::size_t column = 0; column < cells; ++column) {
      const std::int32_t a = index(row, column), b = index(row, column + 1), c = index(row + 1, column + 1),
                         d = index(row + 1, column);
      mesh.faces.push_back({a, b, c});
      mesh.faces.push_back({a, c, d});
    }
  }
  return mesh;
}
}  // namespace

TEST_CASE("two million faces smaller than a pixel: each sample shows the one it lies in",
          "[raster][visibility]") {
  const Mesh mesh = wall();
  constexpr std::size_t size = 200;
  for (const std::size_t samples : std::vector<std::size_t>{1, 4}) {
    const auto buffer = raster::visibility(mesh, Camera{}, size, size, samples);
    const std::size_t columns = size * samples;
    std::size_t wrong = 0, compared = 0;
    for (std::size_t i = 0; i < buffer.face.size(); ++i) {
      const auto cell = [&](std::size_t sample) {
        const double view = 2 * ((static_cast<double>(sample) + 0.5) / static_cast<double>(columns) * 2 - 1);
        return (view + 2.2) / 4.4 * cells;
      };
      const double x = cell(i % columns), y = cell(i / columns);
      const double dx = x - std::floor(x), dy = y - std::floor(y);
      // Snapping moves a side by at most 1/256 of a sample.
      const double slack = 1.0 / 256 * cells / (1.1 * static_cast<double>(columns));
      if (std::min({dx, dy, 1 - dx, 1 - dy, std::abs(dx - dy)}) < 2 * slack) continue;
      const auto face = 2 * (static_cast<std::int32_t>(y) * static_cast<std::int32_t>(cells) +
                             static_cast<std::int32_t>(x)) +
                        (dx > dy ? 0 : 1);
      ++compared;
      wrong += buffer.face[i] == face ? 0 : 1;
    }
    CHECK(compared > buffer.face.size() / 2);
    CHECK(wrong == 0);
    CHECK(std::count(buffer.face.begin(), buffer.face.end(), -1) == 0);
  }
}

TEST_CASE("fragments of two million faces cover every pixel exactly once", "[raster][fragments]") {
  const Mesh mesh = wall();
  constexpr std::size_t size = 100;
  const auto list = raster::list_fragments(mesh, Camera{}, size, size, 8);
  std::vector<float> coverage(size * size, 0);
  std::size_t count = 0;
  for (const auto& band : list.bands) {
    for (const auto& fragment : band) coverage[fragment.pixel] += fragment.coverage;
    count += band.size();
  }
  CHECK(count > 40 * size * size);  // of 165 faces that a pixel shows, 64 at most have a sample
  CHECK(std::count(coverage.begin(), coverage.end(), 1.0F) == static_cast<std::ptrdiff_t>(size * size));
}
