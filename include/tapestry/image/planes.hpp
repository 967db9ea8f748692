#pragma once
#include <cstddef>
#include <tapestry/core/array.hpp>

namespace tapestry::image {

/// Writes a picture [H, W, C] channel by channel, [C, H, W]: the order in which networks take pictures.
template <class T>
void write_planes(const Array<T, 3>& picture, T* planes) {
  const std::size_t channels = picture.shape(2), pixels = picture.shape(0) * picture.shape(1);
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (std::size_t c = 0; c < channels; ++c)
      planes[c * pixels + pixel] = picture.data()[channels * pixel + c];
}

/// The picture [H, W, C] as an array [C, H, W].
template <class T>
[[nodiscard]] Array<T, 3> planes_of(const Array<T, 3>& picture) {
  Array<T, 3> planes(Extents<3>{picture.shape(2), picture.shape(0), picture.shape(1)});
  write_planes(picture, planes.data());
  return planes;
}

/// Inverts write_planes(), into another precision if asked for.
///
/// \param planes  [C, H, W]
/// \param shape   H, W, C
template <class To, class From>
[[nodiscard]] Array<To, 3> picture_of_planes(const From* planes, const Extents<3>& shape) {
  Array<To, 3> picture(shape);
  const std::size_t channels = shape[2], pixels = shape[0] * shape[1];
  for (std::size_t pixel = 0; pixel < pixels; ++pixel)
    for (std::size_t c = 0; c < channels; ++c)
      picture.data()[channels * pixel + c] = static_cast<To>(planes[c * pixels + pixel]);
  return picture;
}

}  // namespace tapestry::image
