#pragma once
#include <tapestry/raster/render_variable.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::raster {
namespace detail {

/// Adds every view's render_adjoint(), in the order of views; views without an adjoint add nothing. For a
/// small texture each view sums into an array of its own, so that views are independent of one another.
template <std::floating_point T>
void add_render_adjoints(const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
                         const std::vector<const Array<T, 3>*>& render_adjoints,
                         Array<T, 2>& texels_adjoint) {
  constexpr std::size_t small_texture = 1U << 18U;  // values
  if (texels_adjoint.size() > small_texture) {
    for (std::size_t n = 0; n < pictures.size(); ++n)
      if (render_adjoints[n] != nullptr) render_adjoint(*pictures[n], *render_adjoints[n], texels_adjoint);
    return;
  }
  std::vector<Array<T, 2>> parts(pictures.size());
  parallel_for(pictures.size(), [&](std::size_t n) {
    if (render_adjoints[n] == nullptr) return;
    parts[n] = zeros<T, 2>(texels_adjoint.shape());
    render_adjoint(*pictures[n], *render_adjoints[n], parts[n]);
  });
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.size(); ++i) texels_adjoint.data()[i] += part.data()[i];
}

}  // namespace detail

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
  parallel_for_blocks(picture.pixels.size(), block, [&](std::size_t begin, std::size_t end) {
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

template <std::floating_point T>
ArrayVariable<T, 3> render(const TextureOperator<T>& picture, const ArrayVariable<T, 2>& texels) {
  const auto pullback = [&picture](const Array<T, 3>& adjoint, Array<T, 2>* texels_adjoint) {
    render_adjoint(picture, adjoint, *texels_adjoint);
  };
  return record_array(render(picture, texels.value()), pullback, texels);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 3>> render(
    const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
    const ArrayVariable<T, 2>& texels) {
  std::vector<Array<T, 3>> values(pictures.size());
  parallel_for(values.size(), [&](std::size_t n) { values[n] = render(*pictures[n], texels.value()); });
  const auto pullback = [pictures](const std::vector<const Array<T, 3>*>& adjoints,
                                   Array<T, 2>* texels_adjoint) {
    detail::add_render_adjoints(pictures, adjoints, *texels_adjoint);
  };
  return record_arrays<T, 3>(std::move(values), pullback, texels);
}

}  // namespace tapestry::raster
