#pragma once
#include <tapestry/image/batch.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/detail/bmp_file.hpp>
#include <tapestry/io/detail/pnm_file.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/jpeg_file.hpp>

namespace tapestry::io {
namespace detail {
inline void require_decoded(bool is_decoded, const std::string& path) {
  if (!is_decoded) throw malformed_file({path, "", "PNG picture data cannot be decoded"});
}

template <std::floating_point T>
std::vector<std::uint8_t> levels(const T* values, std::size_t count, std::size_t width, std::size_t channels,
                                 const std::string& path) {
  std::vector<std::uint8_t> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) {
      const std::size_t pixel = i / channels;
      throw NumericError({path, ": picture is not written, its value at row ", pixel / width, ", column ",
                          pixel % width, " is not finite"});
    }
    result[i] = level(values[i]);
  }
  return result;
}

inline void require_writable_size(const std::string& path, std::size_t height, std::size_t width) {
  if (height == 0 || width == 0 || height > png_side_limit || width > png_side_limit)
    throw ShapeError({path, ": cannot write a picture of ", height, " x ", width});
}

inline std::string checked_png(const std::string& path, const std::uint8_t* pixels, std::size_t height,
                               std::size_t width, int channels) {
  require_writable_size(path, height, width);
  return encode_png(pixels, height, width, channels);
}

inline void write_png(const std::string& path, const std::uint8_t* pixels, std::size_t height,
                      std::size_t width, int channels) {
  write_file_atomically(path, checked_png(path, pixels, height, width, channels));
}
}  // namespace detail

template <std::floating_point T>
void write_image(const std::string& path, const Array<T, 3>& image) {
  require_shape("write_image", "image", image, {image.shape(0), image.shape(1), 3});
  const auto pixels = detail::levels(image.data(), image.size(), image.shape(1), 3, path);
  detail::write_png(path, pixels.data(), image.shape(0), image.shape(1), 3);
}

template <std::floating_point T>
std::string png_file(const std::string& path, const Array<T, 3>& image) {
  require_shape("png_file", "image", image, {image.shape(0), image.shape(1), 3});
  const auto pixels = detail::levels(image.data(), image.size(), image.shape(1), 3, path);
  return detail::checked_png(path, pixels.data(), image.shape(0), image.shape(1), 3);
}

template <std::floating_point T>
void write_mask(const std::string& path, const Array<T, 2>& mask) {
  const auto pixels = detail::levels(mask.data(), mask.size(), mask.shape(1), 1, path);
  detail::write_png(path, pixels.data(), mask.shape(0), mask.shape(1), 1);
}

template <std::floating_point T>
void write_gradient(const std::string& path, const Array<T, 4>& gradient) {
  require_shape("write_gradient", "gradient", gradient, {1, gradient.shape(1), gradient.shape(2), 3});
  auto picture = image::picture_of(gradient, 0);
  T largest = 0;
  for (const T value : picture.storage()) largest = std::max(largest, std::abs(value));
  if (largest == 0) largest = 1;
  for (T& value : picture.storage()) value = (1 + std::cbrt(value / largest)) / 2;
  write_image(path, picture);
}
}  // namespace tapestry::io
