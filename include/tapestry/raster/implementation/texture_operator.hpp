#pragma once
#include <tapestry/raster/render_variable.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::raster {
template <std::floating_point T>
Array<T, 3> render(const TextureOperator<T>& picture, const Array<T, 2>& texels) {
  require_shape("render", "texels", texels, {picture.texel_count, 3});
  const bool is_compact = picture.constant.size() == 0;
  Array<T, 3> image = is_compact ? zeros<T, 3>({picture.height, picture.width, 3}) : picture.constant;
  for (std::size_t i = 0; i < picture.constant_pixels.size(); ++i)
    std::copy_n(picture.constants.data() + 3 * i, 3,
                image.data() + 3 * std::size_t{picture.constant_pixels[i]});
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
CompactOperator<T> compacted(TextureOperator<T> picture) {
  std::vector<std::uint64_t> is_read(picture.texel_count / 64 + 1, 0);  // a bit a texel
  for (const std::uint32_t texel : picture.texels_of) is_read[texel / 64] |= std::uint64_t(1) << texel % 64;
  CompactOperator<T> compact{std::move(picture), 0, {}};
  compact.whole_count = compact.texel_count;
  std::vector<std::uint32_t> before(is_read.size());  // own texels before each word
  for (std::size_t word = 0; word < is_read.size(); ++word) {
    before[word] = static_cast<std::uint32_t>(compact.texels.size());
    for (std::uint64_t bits = is_read[word]; bits != 0; bits &= bits - 1)
      compact.texels.push_back(static_cast<std::uint32_t>(64 * word) +
                               static_cast<std::uint32_t>(std::countr_zero(bits)));
  }
  for (std::uint32_t& texel : compact.texels_of) {
    const std::uint64_t lower = is_read[texel / 64] & ((std::uint64_t(1) << texel % 64) - 1);
    texel = before[texel / 64] + static_cast<std::uint32_t>(std::popcount(lower));
  }
  for (std::size_t i = 0; i < compact.constant.size(); i += 3) {
    const T* const colour = compact.constant.data() + i;
    if (std::count(colour, colour + 3, T(0)) == 3) continue;
    compact.constant_pixels.push_back(static_cast<std::uint32_t>(i / 3));
    compact.constants.insert(compact.constants.end(), colour, colour + 3);
  }
  compact.constant = {};
  for (auto* list :
       {&compact.pixels, &compact.row_begin, &compact.texels_of, &compact.constant_pixels, &compact.texels})
    list->shrink_to_fit();
  for (auto* list : {&compact.weights, &compact.constants}) list->shrink_to_fit();
  compact.texel_count = compact.texels.size();
  return compact;
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 3>> render(
    const std::vector<std::shared_ptr<const CompactOperator<T>>>& pictures,
    const ArrayVariable<T, 2>& texels) {
  std::vector<Array<T, 3>> values(pictures.size());
  parallel_for(values.size(), [&](std::size_t n) {
    values[n] = render(*pictures[n], own_texels(*pictures[n], texels.value()));
  });
  const auto pullback = [pictures](const std::vector<const Array<T, 3>*>& adjoints,
                                   Array<T, 2>* texels_adjoint) {
    std::vector<Array<T, 2>> parts(pictures.size());
    parallel_for(pictures.size(), [&](std::size_t n) {
      if (adjoints[n] == nullptr) return;
      parts[n] = zeros<T, 2>({pictures[n]->texel_count, 3});
      render_adjoint(*pictures[n], *adjoints[n], parts[n]);
    });
    for (std::size_t n = 0; n < pictures.size(); ++n)
      if (adjoints[n] != nullptr) add_own_texels(*pictures[n], parts[n], T(1), *texels_adjoint);
  };
  return record_arrays<T, 3>(std::move(values), pullback, texels);
}
}  // namespace tapestry::raster
