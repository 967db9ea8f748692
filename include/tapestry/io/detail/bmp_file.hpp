#pragma once
#include <tapestry/io/image_file.hpp>

namespace tapestry::io {
namespace detail {
/// Unpacks the run lengths of a BMP (BI_RLE8, BI_RLE4) to indices into its palette, [height, width], row 0 on
/// top; 0 where no run lies. Pixels beyond a row or the top are dropped. Source: Microsoft, Bitmap
/// Compression.
///
///   n v      n pixels of v; of 4 bits, the halves of v in turn
///   0 n ...  n > 2 pixels as they are, in whole pairs of bytes
///   0 2 x y  moves x to the right and y up
///   0 0      ends the row; 0 1 ends the picture
///
/// \param bits  of an index: 4 or 8
/// \returns nothing if the runs end before the picture does
inline std::vector<std::uint8_t> unpacked_bmp_runs(std::string_view runs, std::size_t height,
                                                   std::size_t width, std::size_t bits) {
  std::vector<std::uint8_t> indices(height * width);
  const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(runs[at]); };
  std::size_t x = 0, rows = 0;  // from the bottom
  const auto put = [&](unsigned pair, std::size_t i) {
    const unsigned index = bits == 8 ? pair : i % 2 == 0 ? pair >> 4U : pair & 15U;
    if (x < width && rows < height)
      indices[(height - 1 - rows) * width + x] = static_cast<std::uint8_t>(index);
    ++x;
  };
  for (std::size_t at = 0; at + 2 <= runs.size();) {
    const std::size_t count = byte(at), value = byte(at + 1);
    at += 2;
    if (count > 0) {
      for (std::size_t i = 0; i < count; ++i) put(static_cast<unsigned>(value), i);
    } else if (value == 0) {
      x = 0;
      ++rows;
    } else if (value == 1) {
      return indices;
    } else {
      const std::size_t bytes = value == 2 ? 2 : bits == 8 ? value : (value + 1) / 2;
      if (runs.size() - at < bytes) return {};
      if (value == 2) {
        x += byte(at);
        rows += byte(at + 1);
      } else {
        for (std::size_t i = 0; i < value; ++i) put(byte(at + (bits == 8 ? i : i / 2)), i);
      }
      at += bytes + bytes % 2;
      if (at > runs.size()) return {};
    }
  }
  return rows >= height || (rows + 1 == height && x >= width) ? indices : std::vector<std::uint8_t>{};
}

class BmpReader : PictureBytes {
 public:
  using PictureBytes::PictureBytes;

  [[nodiscard]] PictureSamples read() {
    read_header();
    if (is_packed_) return read_runs();
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
    is_packed_ = !from_top_ && ((compression == 1 && bits_ == 8) || (compression == 2 && bits_ == 4));
    if (compression != 0 && !has_masks && !is_packed_)
      fail(30, "compression of a BMP is not read", "none, or runs of 4 or 8 bits",
           "kind " + std::to_string(compression));
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

  [[nodiscard]] PictureSamples read_runs() {
    if (pixels_at_ > file_.size()) fail(pixels_at_, "BMP is cut");
    const auto indices = unpacked_bmp_runs(file_.substr(pixels_at_), picture_.height, picture_.width, bits_);
    if (indices.empty()) fail(file_.size(), "BMP is cut: its runs do not reach their end");
    picture_.samples.resize(picture_.height * picture_.width * 3);
    for (std::size_t i = 0; i < indices.size(); ++i) look_up(indices[i], picture_.samples.data() + 3 * i);
    return std::move(picture_);
  }

  /// A colour by its index in the palette; black beyond the palette's end.
  void read_index(std::size_t row, std::size_t x, std::uint16_t* rgb) const {
    const std::size_t bit = x * bits_;
    const unsigned byte = static_cast<unsigned char>(file_[row + bit / 8]);
    look_up(byte >> (8 - bits_ - bit % 8) & ((1U << bits_) - 1), rgb);
  }

  void look_up(std::size_t index, std::uint16_t* rgb) const {
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

  PictureSamples picture_;
  std::size_t pixels_at_ = 0, bits_ = 0;
  bool from_top_ = false, is_packed_ = false;
  std::size_t palette_at_ = 0, entry_bytes_ = 4, entries_ = 0;
  Masks masks_{};
};
}  // namespace detail

/// Whether a file begins as BMP files do.
[[nodiscard]] inline bool is_bmp(std::string_view file) { return file.starts_with("BM"); }

/// Decodes a BMP of run lengths of 4 or 8 bits, see unpacked_bmp_runs(), or an uncompressed one of 1, 4 or 8
/// bits with a palette (black beyond its end), or of 16, 24 or 32 bits, with masks or without. Transparency
/// is dropped, colour profiles are ignored. Implemented here instead of by stb, which accepts cut files, and
/// reads colours beyond the palette from uninitialised memory. Source: Microsoft's BITMAPFILEHEADER,
/// BITMAPCOREHEADER and BITMAPINFOHEADER to BITMAPV5HEADER. Takes memory of at most 4 times the file, 24
/// bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: malformed (cut, other compressions, inconsistent headers), limit (over 16,384 a side or
///         64 Mpx)
[[nodiscard]] inline PictureSamples parse_bmp(std::string_view file, const std::string& path) {
  return detail::BmpReader(file, path).read();
}
}  // namespace tapestry::io
