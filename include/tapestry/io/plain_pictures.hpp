#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/image_file.hpp>
#include <utility>

namespace tapestry::io {
namespace detail {
/// Reads the headers of a BMP, then its rows.
class BmpReader {
 public:
  BmpReader(std::string_view file, const std::string& path) : file_(file), path_(path) {}

  [[nodiscard]] PictureSamples read() {
    read_header();
    const std::size_t row_bytes = (picture_.width * bits_ + 31) / 32 * 4;
    if (pixels_at_ > file_.size() || (file_.size() - pixels_at_) / row_bytes < picture_.height)
      fail(pixels_at_, "BMP is cut", std::to_string(row_bytes * picture_.height) + " bytes of rows",
           std::to_string(file_.size() - std::min(pixels_at_, file_.size())));
    picture_.samples.resize(picture_.height * picture_.width * 3);
    std::uint16_t* sample = picture_.samples.data();
    for (std::size_t y = 0; y < picture_.height; ++y) {
      const std::size_t row = pixels_at_ + row_bytes * (from_top_ ? y : picture_.height - 1 - y);
      for (std::size_t x = 0; x < picture_.width; ++x, sample += 3)
        bits_ <= 8 ? read_index(row, x, sample) : read_colour(row + x * bits_ / 8, sample);
    }
    return std::move(picture_);
  }

 private:
  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw FileError(ErrorKind::malformed, {path_, "@" + std::to_string(at), what, expected, found});
  }

  /// The number in little-endian bytes.
  [[nodiscard]] std::uint32_t number(std::size_t at, std::size_t bytes) const {
    if (at > file_.size() || file_.size() - at < bytes) fail(file_.size(), "BMP ends in its header");
    std::uint32_t value = 0;
    for (std::size_t i = bytes; i-- > 0;) value = value << 8U | static_cast<unsigned char>(file_[at + i]);
    return value;
  }

  void read_header() {
    pixels_at_ = number(10, 4);
    const std::uint32_t size = number(14, 4);
    constexpr std::array<std::uint32_t, 6> known{12, 40, 52, 56, 108, 124};
    if (std::find(known.begin(), known.end(), size) == known.end())
      fail(14, "header of a BMP is of no known size", "12, 40, 52, 56, 108 or 124", std::to_string(size));
    const bool is_short = size == 12;
    const std::uint32_t rows = number(is_short ? 20 : 22, is_short ? 2 : 4);
    from_top_ = !is_short && rows >> 31U != 0;
    picture_.width = number(18, is_short ? 2 : 4);
    picture_.height = from_top_ ? std::uint32_t{0} - rows : rows;
    require_picture_size(picture_.width, picture_.height, path_, "@18");
    bits_ = number(is_short ? 24 : 28, 2);
    const std::uint32_t compression = is_short ? 0 : number(30, 4);
    const bool has_masks = compression == 3 && (bits_ == 16 || bits_ == 32);
    if (compression != 0 && !has_masks)
      fail(30, "compression of a BMP is not read", "none", "kind " + std::to_string(compression));
    if (bits_ == 1 || bits_ == 4 || bits_ == 8)
      find_palette(14 + size, is_short ? 3 : 4, is_short ? 0 : number(46, 4));
    else if (bits_ == 16 || bits_ == 24 || bits_ == 32)
      find_masks(has_masks);
    else
      fail(is_short ? 24 : 28, "bits a pixel of a BMP", "1, 4, 8, 16, 24 or 32", std::to_string(bits_));
    if (pixels_at_ < 14 + size) fail(10, "rows of a BMP begin in its header");
  }

  /// \param used number of entries; 0 for as many as the bits can index
  void find_palette(std::size_t at, std::size_t entry_bytes, std::size_t used) {
    const std::size_t most = std::size_t{1} << bits_;
    if (used > most)
      fail(46, "palette of a BMP", "at most " + std::to_string(most) + " colours", std::to_string(used));
    palette_at_ = at;
    entry_bytes_ = entry_bytes;
    const std::size_t room = pixels_at_ > at ? (pixels_at_ - at) / entry_bytes : 0;
    if (used > room || room == 0) fail(10, "rows of a BMP begin in its palette");
    entries_ = used != 0 ? used : std::min(most, room);
    (void)number(at, 0);
    if ((file_.size() - at) / entry_bytes < entries_) fail(file_.size(), "BMP ends in its palette");
  }

  void find_masks(bool are_stated) {
    masks_ = bits_ == 16 ? Masks{31U << 10U, 31U << 5U, 31U} : Masks{0xFFU << 16U, 0xFFU << 8U, 0xFFU};
    if (!are_stated) return;
    for (std::size_t c = 0; c < 3; ++c) {
      masks_[c] = number(54 + 4 * c, 4);
      const std::uint32_t shifted = masks_[c] == 0 ? 0 : masks_[c] >> std::countr_zero(masks_[c]);
      if (shifted == 0 || shifted > 0xFFFF || (shifted & (shifted + 1)) != 0)
        fail(54 + 4 * c, "mask of a BMP is no row of 1 to 16 bits");
    }
  }

  /// A colour by its index in the palette; black beyond the palette's end.
  void read_index(std::size_t row, std::size_t x, std::uint16_t* rgb) const {
    const std::size_t bit = x * bits_;
    const unsigned byte = static_cast<unsigned char>(file_[row + bit / 8]);
    const std::size_t index = byte >> (8 - bits_ - bit % 8) & ((1U << bits_) - 1);
    if (index >= entries_) return;
    for (std::size_t c = 0; c < 3; ++c)
      rgb[c] = static_cast<unsigned char>(file_[palette_at_ + index * entry_bytes_ + 2 - c]);
  }

  void read_colour(std::size_t at, std::uint16_t* rgb) const {
    const std::uint32_t pixel = number(at, bits_ / 8);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto shift = static_cast<unsigned>(std::countr_zero(masks_[c]));
      const std::uint32_t value = (pixel & masks_[c]) >> shift, greatest = masks_[c] >> shift;
      rgb[c] = static_cast<std::uint16_t>((value * 255 + greatest / 2) / greatest);
    }
  }

  using Masks = std::array<std::uint32_t, 3>;  // of R, G, B

  std::string_view file_;
  const std::string& path_;
  PictureSamples picture_;
  std::size_t pixels_at_ = 0, bits_ = 0;
  bool from_top_ = false;
  std::size_t palette_at_ = 0, entry_bytes_ = 4, entries_ = 0;
  Masks masks_{};
};
}  // namespace detail

/// Whether a file is a BMP by its first bytes.
[[nodiscard]] inline bool is_bmp(std::string_view file) { return file.starts_with("BM"); }

/// Decodes an uncompressed BMP of 1, 4 or 8 bits with a palette (black beyond its end), or of 16, 24 or 32
/// bits, with masks or without. Transparency is dropped, colour profiles are ignored. Implemented here
/// instead of by stb, which accepts cut files, and reads colours beyond the palette from uninitialised
/// memory. Source: Microsoft's BITMAPFILEHEADER, BITMAPCOREHEADER and BITMAPINFOHEADER to BITMAPV5HEADER.
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: malformed (cut, run lengths, inconsistent headers), limit (over 16,384 a side or
///         64 Mpx)
[[nodiscard]] inline PictureSamples parse_bmp(std::string_view file, const std::string& path) {
  return detail::BmpReader(file, path).read();
}

namespace detail {
/// Words of the header of a PGM or PPM, separated by spaces, line ends and comments.
class PnmHeader {
 public:
  PnmHeader(std::string_view file, const std::string& path) : file_(file), path_(path) {}

  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw FileError(ErrorKind::malformed, {path_, "@" + std::to_string(at), what, expected, found});
  }

  /// The next number, of at most seven digits, so that it cannot overflow.
  [[nodiscard]] unsigned number() {
    while (at_ < file_.size() && (is_space(file_[at_]) || file_[at_] == '#')) {
      if (file_[at_] == '#')
        while (at_ < file_.size() && file_[at_] != '\n' && file_[at_] != '\r') ++at_;
      else
        ++at_;
    }
    const std::size_t begin = at_;
    unsigned value = 0;
    for (; at_ < file_.size() && file_[at_] >= '0' && file_[at_] <= '9'; ++at_) {
      if (at_ - begin == 7) fail(begin, "number in the header of a PNM picture is too long");
      value = value * 10 + static_cast<unsigned>(file_[at_] - '0');
    }
    if (at_ == begin) fail(at_, "header of a PNM picture lacks a number");
    return value;
  }

  /// The offset of the first sample, after one white space.
  [[nodiscard]] std::size_t samples_at() const {
    if (at_ >= file_.size() || !is_space(file_[at_])) fail(at_, "header of a PNM picture does not end");
    return at_ + 1;
  }

 private:
  [[nodiscard]] static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  std::string_view file_;
  const std::string& path_;
  std::size_t at_ = 2;
};
}  // namespace detail

/// Whether a file is a binary PGM or PPM by its first bytes.
[[nodiscard]] inline bool is_pnm(std::string_view file) {
  return file.size() > 2 && file[0] == 'P' && (file[1] == '5' || file[1] == '6') &&
         std::string_view(" \t\n\v\f\r#").find(file[2]) != std::string_view::npos;
}

/// Decodes a binary PGM (P5) or PPM (P6) of 8 or 16 bits; of several pictures in a file, the first.
/// Implemented here instead of by stb, which does not scale samples whose maximum is not 255, and accepts cut
/// files. Source: Netpbm, formats pgm(5) and ppm(5).
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: malformed (another format, cut, a sample above the maximum), limit (over 16,384 a side
///         or 64 Mpx)
[[nodiscard]] inline PictureSamples parse_pnm(std::string_view file, const std::string& path) {
  detail::PnmHeader header(file, path);
  if (!is_pnm(file)) header.fail(0, "not a binary PGM or PPM picture");
  PictureSamples picture;
  picture.channels = file[1] == '6' ? 3 : 1;
  picture.width = header.number();
  picture.height = header.number();
  detail::require_picture_size(picture.width, picture.height, path, "@2");
  picture.maximum = header.number();
  if (picture.maximum == 0 || picture.maximum > 65535)
    header.fail(2, "greatest sample of a PNM picture", "1 to 65535", std::to_string(picture.maximum));
  const std::size_t begin = header.samples_at(), bytes = picture.maximum > 255 ? 2 : 1;
  const std::size_t count = picture.height * picture.width * picture.channels;
  if (file.size() - begin < count * bytes)
    header.fail(begin, "PNM picture is cut", std::to_string(count * bytes) + " bytes",
                std::to_string(file.size() - begin));
  picture.samples.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto byte = [&](std::size_t k) {
      return static_cast<unsigned>(static_cast<unsigned char>(file[begin + i * bytes + k]));
    };
    const unsigned sample = bytes == 2 ? byte(0) << 8U | byte(1) : byte(0);
    if (sample > picture.maximum)
      header.fail(begin + i * bytes, "sample of a PNM picture", "at most " + std::to_string(picture.maximum),
                  std::to_string(sample));
    picture.samples[i] = static_cast<std::uint16_t>(sample);
  }
  return picture;
}

}  // namespace tapestry::io
