#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/jpeg_scan.hpp>

namespace tapestry::io {
namespace detail {

/// libjpeg-turbo's part, compiled where a program includes implementation.hpp: RGB, rows from the top,
/// channels interleaved, into height · width · 3 bytes.
/// \returns  what is wrong with the file; empty if nothing is
std::string decode_jpeg(std::string_view file, std::size_t height, std::size_t width, std::uint8_t* pixels);

}  // namespace detail

/// A picture turned as its EXIF orientation says: 1 leaves it; 2 and 4 mirror it left to right and top to
/// bottom, 3 turns it by half a circle; 5 to 8 exchange rows and columns, and of these 6 is to be turned
/// clockwise by a quarter, 8 counterclockwise.
[[nodiscard]] inline Array<std::uint8_t, 3> turned_upright(const Array<std::uint8_t, 3>& stored,
                                                           int orientation) {
  if (orientation == 1) return stored;
  const std::size_t rows = stored.shape(0), columns = stored.shape(1);
  const bool exchanges = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Array<std::uint8_t, 3> upright(Extents<3>{exchanges ? columns : rows, exchanges ? rows : columns, 3});
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t row = from_bottom ? rows - 1 - y : y;
      const std::size_t column = from_right ? columns - 1 - x : x;
      for (std::size_t c = 0; c < 3; ++c)
        upright(exchanges ? column : row, exchanges ? row : column, c) = stored(y, x, c);
    }
  return upright;
}

/// Decodes a JPEG, baseline or progressive, as RGB, [H, W, 3], turned upright as its EXIF orientation says.
/// Grey is repeated in the three channels; colour profiles are ignored. Decoding is left to libjpeg-turbo.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: as scan_jpeg(); malformed for damaged or cut picture data; mismatch if the program was
///         built without libjpeg-turbo
[[nodiscard]] inline Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path) {
  const JpegHeader header = scan_jpeg(file, path);
  Array<std::uint8_t, 3> stored(Extents<3>{header.height, header.width, 3});
  const std::string complaint = detail::decode_jpeg(file, header.height, header.width, stored.data());
  if (!complaint.empty())
    throw FileError(complaint.starts_with("built without") ? ErrorKind::mismatch : ErrorKind::malformed,
                    {path, "", "JPEG cannot be decoded: " + complaint});
  return turned_upright(stored, header.orientation);
}

}  // namespace tapestry::io
