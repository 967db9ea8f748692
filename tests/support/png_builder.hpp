#pragma once
#include <zlib.h>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

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

inline std::string zlib_packed(const std::string& content, int level = 9) {
  uLongf size = compressBound(static_cast<uLong>(content.size()));
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
            static_cast<uLong>(content.size()), level);
  packed.resize(size);
  return packed;
}

/// Parts of a PNG; every field can be made wrong.
struct PngParts {
  std::uint32_t width = 1, height = 1;
  int bits = 8, colour_type = 0, interlace = 0;
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

/// Samples of a picture, [height, width, channels], each below 2^bits.
struct PngSamples {
  std::size_t height = 0, width = 0, channels = 1;
  unsigned bits = 8;
  std::vector<unsigned> samples{};

  [[nodiscard]] unsigned at(std::size_t y, std::size_t x, std::size_t c) const {
    return samples[(y * width + x) * channels + c];
  }
};

/// Channels of a colour type.
inline std::size_t png_channels(int colour_type) {
  return colour_type == 2 ? 3 : colour_type == 4 ? 2 : colour_type == 6 ? 4 : 1;
}

/// The predictor of that name: the nearest to left + above - above left.
inline unsigned paeth(unsigned left, unsigned above, unsigned corner) {
  const int estimate = static_cast<int>(left + above) - static_cast<int>(corner);
  const auto distance = [&](unsigned value) {
    const int difference = estimate - static_cast<int>(value);
    return difference < 0 ? -difference : difference;
  };
  if (distance(left) <= distance(above) && distance(left) <= distance(corner)) return left;
  return distance(above) <= distance(corner) ? above : corner;
}

/// Every `dx`-th pixel of every `dy`-th row from x0, y0 on, as rows with a filter byte before each.
/// \param filter  0 to 4 as PNG numbers them, or 5: another for each row
inline std::string png_pass(const PngSamples& picture, std::size_t x0, std::size_t y0, std::size_t dx,
                            std::size_t dy, unsigned filter) {
  if (x0 >= picture.width) return {};
  const std::size_t pixel = (picture.channels * picture.bits + 7) / 8;  // bytes, one at least
  std::vector<unsigned> above;
  std::string rows;
  for (std::size_t y = y0, number = 0; y < picture.height; y += dy, ++number) {
    std::vector<unsigned> row;
    unsigned free_bits = 0;  // of the last byte
    for (std::size_t x = x0; x < picture.width; x += dx)
      for (std::size_t c = 0; c < picture.channels; ++c) {
        const unsigned sample = picture.at(y, x, c);
        if (picture.bits == 16) row.push_back(sample >> 8U);
        if (picture.bits >= 8) {
          row.push_back(sample & 0xFFU);
          continue;
        }
        if (free_bits == 0) row.push_back(0);
        free_bits = (free_bits == 0 ? 8 : free_bits) - picture.bits;
        row.back() |= sample << free_bits;
      }
    above.resize(row.size(), 0);
    const unsigned kind = filter == 5 ? static_cast<unsigned>(number % 5) : filter;
    rows += static_cast<char>(kind);
    for (std::size_t i = 0; i < row.size(); ++i) {
      const unsigned left = i < pixel ? 0 : row[i - pixel], corner = i < pixel ? 0 : above[i - pixel];
      const unsigned predictions[]{0, left, above[i], (left + above[i]) / 2, paeth(left, above[i], corner)};
      rows += static_cast<char>(row[i] - predictions[kind]);
    }
    above = row;
  }
  return rows;
}

/// The picture data of a PNG. Source: PNG specification, second edition, sections 7 to 9.
inline std::string png_rows(const PngSamples& picture, bool interlaced, unsigned filter) {
  if (!interlaced) return png_pass(picture, 0, 0, 1, 1, filter);
  return png_pass(picture, 0, 0, 8, 8, filter) + png_pass(picture, 4, 0, 8, 8, filter) +
         png_pass(picture, 0, 4, 4, 8, filter) + png_pass(picture, 2, 0, 4, 4, filter) +
         png_pass(picture, 0, 2, 2, 4, filter) + png_pass(picture, 1, 0, 2, 2, filter) +
         png_pass(picture, 0, 1, 1, 2, filter);
}
}  // namespace tapestry::test
