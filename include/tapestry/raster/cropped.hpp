#pragma once
#include <tapestry/image/crop.hpp>
#include <tapestry/raster/texture_operator.hpp>

namespace tapestry::raster {
/// The smallest window that holds every pixel with coverage; empty where there is none.
template <std::floating_point T>
[[nodiscard]] image::PixelWindow covered_window(const Array<T, 2>& coverage) {
  std::size_t top = coverage.shape(0), left = coverage.shape(1), bottom = 0, right = 0;
  for (std::size_t y = 0; y < coverage.shape(0); ++y)
    for (std::size_t x = 0; x < coverage.shape(1); ++x) {
      if (!(coverage(y, x) > T(0))) continue;
      top = std::min(top, y);
      left = std::min(left, x);
      bottom = y + 1;
      right = std::max(right, x + 1);
    }
  if (bottom == 0) return {};
  return {top, left, bottom - top, right - left};
}

/// The operator of a window of the picture: render() of it is the crop of render(), and costs no more than
/// the window. Drops entries outside the window.
///
/// \throws ShapeError if the window leaves the picture
template <std::floating_point T>
[[nodiscard]] TextureOperator<T> cropped(const TextureOperator<T>& picture,
                                         const image::PixelWindow& window) {
  image::require_window("cropped", window, picture.height, picture.width);
  TextureOperator<T> part;
  part.height = window.height;
  part.width = window.width;
  part.texel_count = picture.texel_count;
  part.light_colour = picture.light_colour;
  part.non_finite_faces = picture.non_finite_faces;
  part.constant = image::crop(picture.constant, window);
  part.coverage = Array<T, 2>(Extents<2>{window.height, window.width});
  for (std::size_t y = 0; y < window.height; ++y)
    std::copy_n(picture.coverage.data() + (window.top + y) * picture.width + window.left, window.width,
                part.coverage.data() + y * window.width);
  part.row_begin.push_back(0);
  for (std::size_t row = 0; row < picture.pixels.size(); ++row) {
    const std::size_t y = picture.pixels[row] / picture.width, x = picture.pixels[row] % picture.width;
    if (y < window.top || y >= window.top + window.height || x < window.left ||
        x >= window.left + window.width)
      continue;
    part.pixels.push_back(static_cast<std::uint32_t>((y - window.top) * window.width + x - window.left));
    for (std::uint32_t i = picture.row_begin[row]; i < picture.row_begin[row + 1]; ++i) {
      part.texels_of.push_back(picture.texels_of[i]);
      part.weights.push_back(picture.weights[i]);
    }
    part.row_begin.push_back(static_cast<std::uint32_t>(part.texels_of.size()));
  }
  return part;
}

/// A view behind a mask m: its picture is m·P and its coverage m·c, with P and c of the view. Laid over a
/// background I, m·P + (1 − m·c)·I, the mesh shows where m is 1, and I alone where m is 0. Pixels that m
/// hides leave the operator and cost no time.
///
/// \param mask  m, [H, W], in [0, 1]
/// \throws ShapeError if mask is not of the picture's size
template <std::floating_point T>
[[nodiscard]] TextureOperator<T> masked(TextureOperator<T> picture, const Array<T, 2>& mask) {
  require_shape("masked", "mask", mask, {picture.height, picture.width});
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
