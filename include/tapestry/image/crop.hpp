#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/image/pixel_window.hpp>

namespace tapestry::image {
/// A window of a picture.
///
/// \param picture  [H, W, C]
/// \returns        [window.height, window.width, C]
/// \throws ShapeError if the window leaves the picture
template <std::floating_point T>
[[nodiscard]] Array<T, 3> crop(const Array<T, 3>& picture, const PixelWindow& window) {
  require_window("crop", window, picture.shape(0), picture.shape(1));
  const std::size_t channels = picture.shape(2), row = window.width * channels;
  Array<T, 3> part(Extents<3>{window.height, window.width, channels});
  for (std::size_t y = 0; y < window.height; ++y)
    std::copy_n(picture.data() + ((window.top + y) * picture.shape(1) + window.left) * channels, row,
                part.data() + y * row);
  return part;
}

/// crop() of a picture on the tape; errors as there.
template <Scalar T>
[[nodiscard]] ArrayVariable<T, 3> crop(const ArrayVariable<T, 3>& picture, const PixelWindow& window) {
  require_window("crop", window, picture.shape()[0], picture.shape()[1]);
  return slice(picture, {Range{window.top, window.top + window.height},
                         Range{window.left, window.left + window.width}, Range{}});
}
}  // namespace tapestry::image
