#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/camouflage/method/upc.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage::detail {

double lattice_noise(const std::array<double, 3>& x, const Random& random) {
  std::array<double, 3> share{}, base{};
  for (std::size_t k = 0; k < 3; ++k) {
    base[k] = std::floor(x[k]);
    const double t = x[k] - base[k];
    share[k] = t * t * (3 - 2 * t);
  }
  double sum = 0;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    double weight = 1;
    Random at = random;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t ahead = corner >> k & 1U;
      weight *= ahead == 1 ? share[k] : 1 - share[k];
      at = at.fork(
          static_cast<std::uint64_t>(static_cast<std::int64_t>(base[k]) + static_cast<std::int64_t>(ahead)));
    }
    sum += weight * at.uniform();
  }
  return sum;
}

/// Foliage, roughly: five octaves of noise whose amplitude falls as 1/f, as in natural pictures, between dark
/// green and straw.
[[nodiscard]] inline std::array<double, 3> foliage(const std::array<double, 3>& x, const Random& random) {
  double height = 0, total = 0;
  for (std::uint64_t octave = 0; octave < 5; ++octave) {
    const double frequency = std::ldexp(4.0, static_cast<int>(octave)), amplitude = 1 / frequency;
    height += amplitude *
              lattice_noise({frequency * x[0], frequency * x[1], frequency * x[2]}, random.fork(octave));
    total += amplitude;
  }
  const double share = std::clamp(2 * height / total - 0.5, 0.0, 1.0);  // noise seldom leaves its middle
  constexpr std::array<double, 3> dark{0.12, 0.2, 0.1}, straw{0.6, 0.55, 0.36};
  std::array<double, 3> colour{};
  for (std::size_t c = 0; c < 3; ++c) colour[c] = (1 - share) * dark[c] + share * straw[c];
  return colour;
}

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> upc(const raster::PaintedMesh& car, std::uint64_t seed) {
  const auto texels = panel_texels("upc", car);
  Method<T> method = paint_panels<T>(car, texels);
  method.least = method.greatest = Array<T, 2>(Extents<2>{texels.size(), 3});
  const Random random = Random(seed).fork(0x666F6C69616765ULL);
  for (std::size_t row = 0; row < texels.size(); ++row) {
    const auto picture = detail::foliage(texels[row].position, random);
    for (std::size_t c = 0; c < 3; ++c) {
      method.least(row, c) = static_cast<T>(std::max(0.0, picture[c] - upc_bound));
      method.greatest(row, c) = static_cast<T>(std::min(1.0, picture[c] + upc_bound));
    }
  }
  return method;
}

template decltype(upc<float>) upc<float>;
template decltype(upc<double>) upc<double>;

}  // namespace tapestry::camouflage
