#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <utility>

namespace tapestry::raster {

/// A view behind a mask m: its picture is m·P and its coverage m·c, P and c being those of the view. So laid
/// over a background I, m·P + (1 − m·c)·I, the mesh shows where m is 1 and I alone where m is 0; pixels that
/// m hides leave the operator and cost no time.
///
/// Without tiles, see with_tiles().
/// \param mask  m, [H, W], in [0, 1]
/// \throws ShapeError if mask is not of the picture's size
template <std::floating_point T>
[[nodiscard]] TextureOperator<T> masked(TextureOperator<T> picture, const Array<T, 2>& mask) {
  require_shape("masked", "mask", mask, {picture.height, picture.width});
  picture.tiles = nullptr;  // of other weights
  for (std::size_t pixel = 0; pixel < mask.size(); ++pixel) {
    const T m = mask.data()[pixel];
    picture.coverage.data()[pixel] *= m;
    for (std::size_t c = 0; c < 3; ++c) picture.constant.data()[3 * pixel + c] *= m;
  }
  std::size_t kept_rows = 0;
  std::uint32_t kept = 0, begin = 0;
  for (std::size_t row = 0; row < picture.pixels.size(); ++row) {
    const std::uint32_t end = picture.row_begin[row + 1], pixel = picture.pixels[row];
    const T m = mask.data()[pixel];
    for (std::uint32_t i = begin; m != T(0) && i < end; ++i, ++kept) {
      picture.texels_of[kept] = picture.texels_of[i];
      picture.weights[kept] = m * picture.weights[i];
    }
    begin = end;
    if (m == T(0)) continue;
    picture.pixels[kept_rows++] = pixel;
    picture.row_begin[kept_rows] = kept;
  }
  picture.pixels.resize(kept_rows);
  picture.row_begin.resize(kept_rows + 1);
  picture.texels_of.resize(kept);
  picture.weights.resize(kept);
  return picture;
}

}  // namespace tapestry::raster
