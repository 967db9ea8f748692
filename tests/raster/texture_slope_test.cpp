#include <tapestry/raster/detail/texture_kinds.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

namespace raster = tapestry::raster;
using raster::TextureKind, tapestry::test::random_array;

namespace {
constexpr double step = 1e-6;

/// Whether a coordinate keeps a distance from whole numbers, where the slope of a lookup jumps.
bool is_clear(double position) { return std::abs(position - std::round(position)) > 1e-4; }
}  // namespace

TEST_CASE("atlas_slope agrees with central differences", "[raster][atlas][gradient]") {
  const raster::TextureLayout layout{TextureKind::atlas, 5, 7, 2, 0};
  const auto texels = random_array<double>({35, 3}, 1);
  const auto lookup = [&](double u, double v, std::size_t c) {
    double value = 0;
    raster::visit_atlas_taps(layout, {u, v},
                             [&](const raster::Tap& tap) { value += tap.weight * texels(tap.texel, c); });
    return value;
  };
  tapestry::Random random(2);
  double error = 0;
  std::size_t compared = 0;
  for (int round = 0; round < 2000; ++round) {
    const double u = random.uniform(-3, 5), v = random.uniform(-2, 3);
    if (!is_clear(u * 3.5 - 0.5) || !is_clear(v * 5 - 0.5) || !is_clear(u / 2) || !is_clear(v)) continue;
    ++compared;
    const auto slope = raster::atlas_slope(layout, texels, {u, v});
    for (std::size_t c = 0; c < 3; ++c) {
      const double per_u = (lookup(u + step, v, c) - lookup(u - step, v, c)) / (2 * step);
      const double per_v = (lookup(u, v + step, c) - lookup(u, v - step, c)) / (2 * step);
      error = std::max({error, std::abs(slope[c][0] - per_u), std::abs(slope[c][1] - per_v)});
    }
  }
  CHECK(compared > 1900);
  CHECK(error <= 1e-8);
}

TEST_CASE("cube_slope agrees with central differences", "[raster][cube][gradient]") {
  const raster::TextureLayout layout{TextureKind::cube, 0, 0, 1, 4};
  const auto texels = random_array<double>({3 * 64, 3}, 3);
  const auto lookup = [&](const std::array<double, 3>& b, std::size_t c) {
    double value = 0;
    raster::visit_cube_taps(layout, 2, b,
                            [&](const raster::Tap& tap) { value += tap.weight * texels(tap.texel, c); });
    return value;
  };
  tapestry::Random random(4);
  double error = 0;
  for (int round = 0; round < 2000; ++round) {
    const std::array<double, 3> b{random.uniform(), random.uniform(), random.uniform()};
    if (!is_clear(3 * b[0]) || !is_clear(3 * b[1]) || !is_clear(3 * b[2])) continue;
    const auto slope = raster::cube_slope(layout, texels, 2, b);
    for (std::size_t k = 0; k < 3; ++k) {
      if (std::abs(3 * b[k] - 2.999) < 1e-4) continue;  // where it is cut
      auto ahead = b, behind = b;
      ahead[k] += step;
      behind[k] -= step;
      for (std::size_t c = 0; c < 3; ++c) {
        error = std::max(error, std::abs(slope[c][k] - (lookup(ahead, c) - lookup(behind, c)) / (2 * step)));
      }
    }
  }
  CHECK(error <= 1e-8);
  const raster::TextureLayout single{TextureKind::cube, 0, 0, 1, 1};
  for (const auto& channel : raster::cube_slope(single, texels, 2, {0.2, 0.3, 0.5}))
    CHECK(channel == std::array<double, 3>{0, 0, 0});
}
