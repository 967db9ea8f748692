#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/image/crop.hpp>

namespace tapestry::image {

/// crop() of a picture on the tape; errors as there.
template <class T>
[[nodiscard]] ArrayVariable<T, 3> crop(const ArrayVariable<T, 3>& picture, const PixelWindow& window) {
  require_window("crop", window, picture.shape()[0], picture.shape()[1]);
  return slice(picture, {Range{window.top, window.top + window.height},
                         Range{window.left, window.left + window.width}, Range{}});
}

}  // namespace tapestry::image
