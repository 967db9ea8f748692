#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/bmp_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/jpeg_file.hpp>
#include <tapestry/io/picture_samples.hpp>
#include <tapestry/io/png_scan.hpp>
#include <tapestry/io/pnm_file.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {
namespace detail {
/// stb's part, compiled where a program includes implementation.hpp. Rows from the top, channels interleaved.
/// Empty when stb cannot decode the file.
std::vector<std::uint16_t> decode_png_16(std::string_view file, int channels);
std::vector<std::uint8_t> decode_png_8(std::string_view file, int channels);
std::string encode_png(const std::uint8_t* pixels, std::size_t height, std::size_t width, int channels);

template <class Element>
void require_decoded(const std::vector<Element>& pixels, std::size_t count, const std::string& path) {
  if (pixels.size() != count)
    throw FileError(ErrorKind::malformed, {.path = path, .what = "PNG picture data cannot be decoded"});
}

/// Nearest of 256 levels to a value that is cut to [0, 1].
template <std::floating_point T>
std::uint8_t level(T value) {
  return static_cast<std::uint8_t>((value < 0 ? T(0) : value > 1 ? T(1) : value) * T(255) + T(0.5));
}

/// \param channels  values a pixel, to name the pixel of a value that is not finite
template <std::floating_point T>
std::vector<std::uint8_t> levels(const T* values, std::size_t count, std::size_t width, std::size_t channels,
                                 const std::string& path) {
  std::vector<std::uint8_t> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) {
      const std::size_t pixel = i / channels;
      throw NumericError(path + ": picture is not written, its value at row " +
                         std::to_string(pixel / width) + ", column " + std::to_string(pixel % width) +
                         " is not finite");
    }
    result[i] = level(values[i]);
  }
  return result;
}

inline std::string checked_png(const std::string& path, const std::uint8_t* pixels, std::size_t height,
                               std::size_t width, int channels) {
  if (height == 0 || width == 0 || height > png_side_limit || width > png_side_limit)
    throw ShapeError(path + ": cannot write a picture of " + std::to_string(height) + " x " +
                     std::to_string(width));
  const std::string file = encode_png(pixels, height, width, channels);
  if (file.empty())
    throw FileError(ErrorKind::limit, {.path = path, .what = "picture is too large to encode"});
  return file;
}

inline void write_png(const std::string& path, const std::uint8_t* pixels, std::size_t height,
                      std::size_t width, int channels) {
  write_file_atomically(path, checked_png(path, pixels, height, width, channels));
}
}  // namespace detail

/// Reads a PNG, JPEG, BMP, PGM or PPM as RGB, [H, W, 3]. The file's content decides what it is, not its name.
///
/// For the others see parse_jpeg(), parse_bmp() and parse_pnm(). Every kind of PNG is converted: grey is
/// repeated in the three channels, palettes are looked up (black beyond their end), 1 to 4 bits are scaled to
/// 0-255, of 16 bits the upper 8 are kept. Transparency is dropped and colours are taken as stored (PNG does
/// not premultiply); colour profiles and gamma are ignored.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \throws FileError: malformed (no such format, damaged, checksums included), limit (over 16,384 a side or
///         64 Mpx)
[[nodiscard]] inline Array<std::uint8_t, 3> read_image(const std::string& path) {
  std::string file = read_text_file(path, png_file_limit);
  if (is_jpeg(file)) return parse_jpeg(file, path);
  if (is_bmp(file)) return rgb_levels(parse_bmp(file, path));
  if (is_pnm(file)) return rgb_levels(parse_pnm(file, path));
  const PngHeader header = scan_png(file, path);
  const auto pixels = detail::decode_png_8(with_whole_palette(std::move(file), header), 3);
  detail::require_decoded(pixels, header.height * header.width * 3, path);
  Array<std::uint8_t, 3> image(Extents<3>{header.height, header.width, 3});
  std::copy(pixels.begin(), pixels.end(), image.data());
  return image;
}

/// Reads a PNG, BMP, PGM or PPM as grey in [0, 1], [H, W]: value / 255, or / 65535 where the file has 16 bits
/// (PGM and PPM: by the greatest value they state). Colours become (77 R + 150 G + 29 B) / 256; transparency
/// is dropped. No threshold is applied. Throws as read_image() does, and for a JPEG, whose losses blur a
/// mask's border.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
[[nodiscard]] inline Array<float, 2> read_mask(const std::string& path) {
  std::string file = read_text_file(path, png_file_limit);
  if (is_jpeg(file))
    throw FileError(ErrorKind::malformed,
                    {path, "@0", "a mask must not have lost anything", "a PNG", "a JPEG"});
  if (is_bmp(file)) return grey_shares(parse_bmp(file, path));
  if (is_pnm(file)) return grey_shares(parse_pnm(file, path));
  const PngHeader header = scan_png(file, path);
  const auto pixels = detail::decode_png_16(with_whole_palette(std::move(file), header), 1);
  detail::require_decoded(pixels, header.height * header.width, path);
  Array<float, 2> mask(Extents<2>{header.height, header.width});
  for (std::size_t i = 0; i < pixels.size(); ++i) mask.data()[i] = static_cast<float>(pixels[i]) / 65535.0F;
  return mask;
}

/// Writes RGB, [H, W, 3], as PNG; the whole file or nothing.
/// \throws ShapeError unless there are three channels and 1 to 16,384 rows and columns; FileError (write)
inline void write_image(const std::string& path, const Array<std::uint8_t, 3>& image) {
  require_shape("write_image", "image", image, {image.shape(0), image.shape(1), 3});
  detail::write_png(path, image.data(), image.shape(0), image.shape(1), 3);
}

/// Writes RGB in [0, 1], [H, W, 3], to the nearest of 256 levels; values outside are cut.
/// \throws NumericError naming the first pixel that is not finite; otherwise as above
template <std::floating_point T>
void write_image(const std::string& path, const Array<T, 3>& image) {
  require_shape("write_image", "image", image, {image.shape(0), image.shape(1), 3});
  const auto pixels = detail::levels(image.data(), image.size(), image.shape(1), 3, path);
  detail::write_png(path, pixels.data(), image.shape(0), image.shape(1), 3);
}

/// RGB, [H, W, 3], as the bytes of a PNG file; `path` is for messages. Errors as above.
[[nodiscard]] inline std::string png_file(const std::string& path, const Array<std::uint8_t, 3>& image) {
  require_shape("png_file", "image", image, {image.shape(0), image.shape(1), 3});
  return detail::checked_png(path, image.data(), image.shape(0), image.shape(1), 3);
}

/// RGB in [0, 1], [H, W, 3], as the bytes of a PNG file; `path` is for messages. Errors as above.
template <std::floating_point T>
[[nodiscard]] std::string png_file(const std::string& path, const Array<T, 3>& image) {
  require_shape("png_file", "image", image, {image.shape(0), image.shape(1), 3});
  const auto pixels = detail::levels(image.data(), image.size(), image.shape(1), 3, path);
  return detail::checked_png(path, pixels.data(), image.shape(0), image.shape(1), 3);
}

/// Writes a grey picture in [0, 1], [H, W]; otherwise as above.
template <std::floating_point T>
void write_mask(const std::string& path, const Array<T, 2>& mask) {
  const auto pixels = detail::levels(mask.data(), mask.size(), mask.shape(1), 1, path);
  detail::write_png(path, pixels.data(), mask.shape(0), mask.shape(1), 1);
}

}  // namespace tapestry::io
