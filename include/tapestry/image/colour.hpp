#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <utility>

namespace tapestry::image {

/// BGR to RGB, and back: exchanges the first and the third channel.
///
/// \param picture  [H, W, 3]
/// \throws ShapeError if there are not three channels
template <class T>
[[nodiscard]] Array<T, 3> swap_red_blue(Array<T, 3> picture) {
  if (picture.shape(2) != 3) {
    throw ShapeError("swap_red_blue: picture has " + std::to_string(picture.shape(2)) +
                     " channels, expected 3");
  }
  for (std::size_t i = 0; i < picture.size(); i += 3) std::swap(picture.data()[i], picture.data()[i + 2]);
  return picture;
}

/// Bytes 0 … 255 to colours 0 … 1.
template <std::floating_point T>
[[nodiscard]] Array<T, 3> from_bytes(const Array<std::uint8_t, 3>& bytes) {
  Array<T, 3> picture(bytes.shape());
  for (std::size_t i = 0; i < bytes.size(); ++i) picture.data()[i] = static_cast<T>(bytes.data()[i]) / 255;
  return picture;
}

/// Colours to the nearest bytes; below 0 and NaN give 0, above 1 gives 255. Inverts from_bytes() exactly.
template <std::floating_point T>
[[nodiscard]] Array<std::uint8_t, 3> to_bytes(const Array<T, 3>& picture) {
  Array<std::uint8_t, 3> bytes(picture.shape());
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const T scaled = picture.data()[i] * 255 + T(0.5);
    const bool is_low = !(scaled >= 1);  // NaN too
    bytes.data()[i] = is_low ? std::uint8_t{0} : static_cast<std::uint8_t>(scaled < 255 ? scaled : T(255));
  }
  return bytes;
}

}  // namespace tapestry::image
