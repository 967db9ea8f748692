#pragma once
#include <tapestry/camouflage/method/comparators.hpp>
#include <tapestry/camouflage/method/methods.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> random_paint(std::size_t texel_count, std::uint64_t seed) {
  Random noise = Random(seed).fork(0x6E6F697365ULL);
  Method<T> method;
  method.least = method.greatest = random_colours<T>(texel_count, noise);
  method.is_optimised = false;
  return method;
}

template <std::floating_point T>
Method<T> solid_paint(std::size_t texel_count) {
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(texel_count, std::size_t(0));
  method.row_count = 1;
  return method;
}

}  // namespace tapestry::camouflage

namespace tapestry::camouflage::detail {

/// The largest upright square within the extents of a panel, about their middle.
struct PatchSquare {
  double left = std::numeric_limits<double>::max(), right = -std::numeric_limits<double>::max();
  double bottom = std::numeric_limits<double>::max(), top = -std::numeric_limits<double>::max();

  void reach(const PanelTexel& texel) {
    left = std::min(left, texel.right);
    right = std::max(right, texel.right);
    bottom = std::min(bottom, texel.up);
    top = std::max(top, texel.up);
  }
  /// Row and column shares in [0, 1] of a place in the picture; outside them, outside the square.
  [[nodiscard]] std::array<double, 2> operator()(const PanelTexel& texel) const {
    const double side = std::min(right - left, top - bottom);
    if (!(side > 0)) return {2, 2};
    return {0.5 - (texel.up - (top + bottom) / 2) / side, 0.5 + (texel.right - (left + right) / 2) / side};
  }
};

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> planar_patch(const raster::PaintedMesh& car) {
  const auto texels = panel_texels("planar_patch", car);
  std::array<detail::PatchSquare, panel_count> squares{};
  for (const PanelTexel& texel : texels) squares[static_cast<std::size_t>(texel.panel)].reach(texel);
  const auto place_of = [&](const PanelTexel& texel) {
    return squares[static_cast<std::size_t>(texel.panel)](texel);
  };
  std::array<std::size_t, panel_count> sizes{};
  for (const PanelTexel& texel : texels)
    if (detail::is_inside(place_of(texel))) ++sizes[static_cast<std::size_t>(texel.panel)];
  const auto largest = static_cast<double>(*std::max_element(sizes.begin(), sizes.end()));
  if (largest == 0)
    throw Error(
        ErrorKind::mismatch,
        "the method planar_patch needs a panel of more than a line of texels; the atlas is too small");
  const auto edge = static_cast<std::size_t>(std::sqrt(largest));

  std::vector<std::size_t> rows(car.layout.texel_count(car.mesh), Method<T>::unpainted);
  const auto pixel = [&](double share) {
    return std::min(static_cast<std::size_t>(share * static_cast<double>(edge)), edge - 1);
  };
  for (const PanelTexel& texel : texels)
    if (const auto place = place_of(texel); detail::is_inside(place))
      rows[texel.texel] = pixel(place[0]) * edge + pixel(place[1]);
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  method.elsewhere = own_colours<T>(car);
  return method;
}

template <std::floating_point T>
Method<T> camou(const raster::PaintedMesh& car) {
  require_atlas("camou", car);
  constexpr std::size_t edge = camou_pattern_edge;
  const std::size_t height = car.layout.height, width = car.layout.width;
  const std::size_t texels_a_colour = (height + 4 * edge - 1) / (4 * edge);
  std::vector<std::size_t> rows(height * width);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      rows[y * width + x] = y / texels_a_colour % edge * edge + x / texels_a_colour % edge;
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  return method;
}

}  // namespace tapestry::camouflage

namespace tapestry::camouflage::detail {

/// Noise between the points of a lattice, in [0, 1): smooth, and the same at the same place.
[[nodiscard]] inline double lattice_noise(const std::array<double, 3>& x, const Random& random) {
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

template <std::floating_point T>
Method<T> das_full() {
  Method<T> method;
  method.attention = 1;
  return method;
}

template <std::floating_point T>
Method<T> das(const raster::PaintedMesh& car) {
  Method<T> method = paint_panels<T>(car, panel_texels("das", car));
  method.attention = das_full<T>().attention;
  return method;
}

template <std::floating_point T>
Method<T> mesh_adv(const raster::PaintedMesh& car) {
  Method<T> method;
  method.shape = std::make_shared<const ShapeParameter>(shape_parameter(car));
  return method;
}

template <std::floating_point T>
Method<T> method_by_name(const std::string& name, const raster::PaintedMesh& car, std::uint64_t seed) {
  const std::size_t texel_count = car.layout.texel_count(car.mesh);
  if (name == "fca" || name == "rauca") return fca<T>();
  if (name == "planar_patch") return planar_patch<T>(car);
  if (name == "camou") return camou<T>(car);
  if (name == "upc") return upc<T>(car, seed);
  if (name == "das") return das<T>(car);
  if (name == "das_full") return das_full<T>();
  if (name == "mesh_adv") return mesh_adv<T>(car);
  if (name == "random") return random_paint<T>(texel_count, seed);
  if (name == "solid") return solid_paint<T>(texel_count);
  throw DomainError({"no method is called ", in_quotes(name)});
}

}  // namespace tapestry::camouflage
