#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

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
[[nodiscard]] Array<std::uint8_t, 3> turned_upright(const Array<std::uint8_t, 3>& stored, int orientation);

/// Decodes a JPEG, baseline or progressive, as RGB, [H, W, 3], turned upright as its EXIF orientation says.
/// Grey is repeated in the three channels; colour profiles are ignored. Decoding is left to libjpeg-turbo.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: as scan_jpeg(); malformed for damaged or cut picture data; mismatch if the program was
///         built without libjpeg-turbo
[[nodiscard]] Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path);

}  // namespace tapestry::io
