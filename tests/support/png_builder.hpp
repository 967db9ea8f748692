#pragma once
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace tapestry::test {
/// Four bytes, the most significant first.
inline std::string big_endian(std::uint32_t value) {
  std::string text;
  for (unsigned shift = 32; shift > 0; shift -= 8) text += static_cast<char>(value >> (shift - 8) & 0xFFU);
  return text;
}

inline std::string png_chunk(const std::string& type, const std::string& content) {
  const std::string checked = type + content;
  const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(checked.data()), checked.size());
  return big_endian(static_cast<std::uint32_t>(content.size())) + checked +
         big_endian(static_cast<std::uint32_t>(crc));
}

inline std::string zlib_packed(const std::string& content) {
  uLongf size = compressBound(static_cast<uLong>(content.size()));
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
            static_cast<uLong>(content.size()), 9);
  packed.resize(size);
  return packed;
}

/// What to put into a PNG; every field can be made wrong.
struct PngParts {
  std::uint32_t width = 1;
  std::uint32_t height = 1;
  int bits = 8;
  int colour_type = 0;
  int interlace = 0;
  std::string rows{};         ///< unpacked picture data, a filter byte before each row
  std::string before_data{};  ///< chunks between header and picture data
};

inline std::string png_signature() { return "\x89PNG\r\n\x1a\n"; }

inline std::string png_header(const PngParts& parts) {
  std::string header = big_endian(parts.width) + big_endian(parts.height);
  for (const int value : {parts.bits, parts.colour_type, 0, 0, parts.interlace})
    header += static_cast<char>(value);
  return png_chunk("IHDR", header);
}

inline std::string png(const PngParts& parts) {
  return png_signature() + png_header(parts) + parts.before_data +
         png_chunk("IDAT", zlib_packed(parts.rows)) + png_chunk("IEND", "");
}
}  // namespace tapestry::test
