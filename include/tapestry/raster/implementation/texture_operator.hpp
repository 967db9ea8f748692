#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/operator_band.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/texture_tiles.hpp>
#include <vector>

namespace tapestry::raster {

template <std::floating_point T>
TextureOperator<T> with_tiles(TextureOperator<T> picture) {
  picture.tiles = std::make_shared<const TextureTiles<T>>(texture_tiles<T>(picture));
  return picture;
}

template <std::floating_point T>
Array<T, 3> render(const TextureOperator<T>& picture, const Array<T, 2>& texels) {
  require_shape("render", "texels", texels, {picture.texel_count, 3});
  Array<T, 3> image = picture.constant;
  T* const out = image.data();
  const T* const texel = texels.data();
  const std::array<T, 3> light = picture.light_colour;
  constexpr std::size_t block = 4096;
  parallel_for(block_count(picture.pixels.size(), block), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, picture.pixels.size(), block);
    for (std::size_t row = begin; row < end; ++row) {
      T red = 0, green = 0, blue = 0;
      for (std::size_t i = picture.row_begin[row]; i < picture.row_begin[row + 1]; ++i) {
        detail::prefetch_ahead(picture, i, texel);
        const T* const colour = texel + 3 * std::size_t{picture.texels_of[i]};
        red += picture.weights[i] * colour[0];
        green += picture.weights[i] * colour[1];
        blue += picture.weights[i] * colour[2];
      }
      T* const pixel = out + 3 * std::size_t{picture.pixels[row]};
      pixel[0] += light[0] * red;
      pixel[1] += light[1] * green;
      pixel[2] += light[2] * blue;
    }
  });
  return image;
}

template <std::floating_point T>
void render_adjoint(const TextureOperator<T>& picture, const Array<T, 3>& render_adjoint,
                    Array<T, 2>& texels_adjoint) {
  require_shape("render_adjoint", "render_adjoint", render_adjoint, {picture.height, picture.width, 3});
  require_shape("render_adjoint", "texels_adjoint", texels_adjoint, {picture.texel_count, 3});
  if (thread_count() == 1) {
    detail::scatter<false>(picture, render_adjoint.data(), 0, 1, texels_adjoint.data());
    return;
  }
  if (picture.tiles) {
    detail::scatter(*picture.tiles, picture.light_colour, render_adjoint.data(), texels_adjoint.data());
    return;
  }
  const std::size_t parts = std::min(static_cast<std::size_t>(thread_count()), detail::most_parts);
  parallel_for(parts, [&](std::size_t part) {
    detail::scatter<true>(picture, render_adjoint.data(), part, parts, texels_adjoint.data());
  });
}

template decltype(texture_operator<float, Light>) texture_operator<float, Light>;
template decltype(texture_operator<double, Light>) texture_operator<double, Light>;
template decltype(texture_operator<float, Unlit>) texture_operator<float, Unlit>;
template decltype(texture_operator<double, Unlit>) texture_operator<double, Unlit>;
template decltype(with_tiles<float>) with_tiles<float>;
template decltype(with_tiles<double>) with_tiles<double>;
template Array<float, 3> render<float>(const TextureOperator<float>& picture, const Array<float, 2>& texels);
template Array<double, 3> render<double>(const TextureOperator<double>& picture,
                                         const Array<double, 2>& texels);
template decltype(render_adjoint<float>) render_adjoint<float>;
template decltype(render_adjoint<double>) render_adjoint<double>;

}  // namespace tapestry::raster
