#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/png_scan.hpp>
#include <vector>

namespace tapestry::io {
namespace detail {
/// stb's part, compiled where a program includes implementation.hpp. Rows from the top, channels interleaved.
/// Empty when stb cannot decode the file.
std::vector<std::uint16_t> decode_png_16(std::string_view file, int channels);
std::vector<std::uint8_t> decode_png_8(std::string_view file, int channels);
std::string encode_png(const std::uint8_t* pixels, std::size_t height, std::size_t width, int channels);

/// Nearest of 256 levels to a value that is cut to [0, 1].
template <std::floating_point T>
std::uint8_t level(T value) {
  return static_cast<std::uint8_t>((value < 0 ? T(0) : value > 1 ? T(1) : value) * T(255) + T(0.5));
}

/// \param channels  values a pixel, to name the pixel of a value that is not finite
template <std::floating_point T>
std::vector<std::uint8_t> levels(const T* values, std::size_t count, std::size_t width, std::size_t channels,
                                 const std::string& path);

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
[[nodiscard]] Array<std::uint8_t, 3> read_image(const std::string& path);

/// Reads a PNG, BMP, PGM or PPM as grey in [0, 1], [H, W]: value / 255, or / 65535 where the file has 16 bits
/// (PGM and PPM: by the greatest value they state). Colours become (77 R + 150 G + 29 B) / 256; transparency
/// is dropped. No threshold is applied. Throws as read_image() does, and for a JPEG, whose losses blur a
/// mask's border.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
[[nodiscard]] Array<float, 2> read_mask(const std::string& path);

/// Writes RGB, [H, W, 3], as PNG; the whole file or nothing.
/// \throws ShapeError unless there are three channels and 1 to 16,384 rows and columns; FileError (write)
void write_image(const std::string& path, const Array<std::uint8_t, 3>& image);

/// Writes RGB in [0, 1], [H, W, 3], to the nearest of 256 levels; values outside are cut.
/// \throws NumericError naming the first pixel that is not finite; otherwise as above
template <std::floating_point T>
void write_image(const std::string& path, const Array<T, 3>& image);

/// RGB, [H, W, 3], as the bytes of a PNG file; `path` is for messages. Errors as above.
[[nodiscard]] std::string png_file(const std::string& path, const Array<std::uint8_t, 3>& image);

/// RGB in [0, 1], [H, W, 3], as the bytes of a PNG file; `path` is for messages. Errors as above.
template <std::floating_point T>
[[nodiscard]] std::string png_file(const std::string& path, const Array<T, 3>& image);

/// Writes a grey picture in [0, 1], [H, W]; otherwise as above.
template <std::floating_point T>
void write_mask(const std::string& path, const Array<T, 2>& mask);

}  // namespace tapestry::io
