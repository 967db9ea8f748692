#pragma once
#include <cstddef>
#include <tapestry/core/array.hpp>

namespace tapestry::image {

/// Pictures [N, H, W, C] channel by channel, [N, C, H, W]: the order in which other libraries' networks take
/// them. Tapestry's take pictures as they are.
template <class T>
[[nodiscard]] Array<T, 4> planes_of(const Array<T, 4>& pictures) {
  const std::size_t pixels = pictures.shape(1) * pictures.shape(2), channels = pictures.shape(3);
  Array<T, 4> planes(Extents<4>{pictures.shape(0), channels, pictures.shape(1), pictures.shape(2)});
  for (std::size_t n = 0; n < pictures.shape(0); ++n)
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t c = 0; c < channels; ++c)
        planes.data()[(n * channels + c) * pixels + pixel] =
            pictures.data()[(n * pixels + pixel) * channels + c];
  return planes;
}

/// Inverts planes_of().
template <class T>
[[nodiscard]] Array<T, 4> pictures_of_planes(const Array<T, 4>& planes) {
  const std::size_t channels = planes.shape(1), pixels = planes.shape(2) * planes.shape(3);
  Array<T, 4> pictures(Extents<4>{planes.shape(0), planes.shape(2), planes.shape(3), channels});
  for (std::size_t n = 0; n < planes.shape(0); ++n)
    for (std::size_t pixel = 0; pixel < pixels; ++pixel)
      for (std::size_t c = 0; c < channels; ++c)
        pictures.data()[(n * pixels + pixel) * channels + c] =
            planes.data()[(n * channels + c) * pixels + pixel];
  return pictures;
}

}  // namespace tapestry::image
