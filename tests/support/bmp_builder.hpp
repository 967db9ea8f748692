#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

namespace tapestry::test {
/// The low bytes of a number, the least significant first.
inline std::string little_endian(std::uint32_t value, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> 8 * i & 0xFFU);
  return text;
}

/// Parts of a BMP; every field can be made wrong.
struct BmpParts {
  int width = 1;
  int height = 1;  ///< negative: rows from the top
  std::uint32_t header_size = 40;
  int bits = 24;
  std::uint32_t compression = 0;
  std::uint32_t used = 0;     ///< colours of the palette, as stated
  std::string palette{};      ///< or masks
  std::string rows{};         ///< each filled up to a multiple of four bytes
  std::uint32_t rows_at = 0;  ///< as stated; 0 for where they are
};

inline std::string bmp(const BmpParts& parts) {
  const bool is_short = parts.header_size == 12;
  const auto number = [](int value, int bytes) {
    return little_endian(static_cast<std::uint32_t>(value), bytes);
  };
  std::string header = little_endian(parts.header_size, 4) + number(parts.width, is_short ? 2 : 4) +
                       number(parts.height, is_short ? 2 : 4) + number(1, 2) + number(parts.bits, 2);
  if (!is_short)
    header += little_endian(parts.compression, 4) + std::string(12, '\0') + little_endian(parts.used, 4);
  header.resize(parts.header_size, '\0');
  const std::size_t rows_at = 14 + header.size() + parts.palette.size();
  const std::size_t stated = parts.rows_at != 0 ? parts.rows_at : rows_at;
  return "BM" + little_endian(static_cast<std::uint32_t>(rows_at + parts.rows.size()), 4) + number(0, 4) +
         little_endian(static_cast<std::uint32_t>(stated), 4) + header + parts.palette + parts.rows;
}
}  // namespace tapestry::test
