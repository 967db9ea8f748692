#pragma once
#include <zlib.h>

#include <tapestry/core/array.hpp>
#include <tapestry/io/file_source.hpp>

namespace tapestry::io {
namespace detail {
/// Integers of an EXIF block, in its own byte order.
class ExifReader {
 public:
  explicit ExifReader(std::string_view tiff) : tiff_(tiff), is_little_(tiff.starts_with("II")) {}

  /// The orientation of the first picture; 1 if the block states no valid one.
  [[nodiscard]] int orientation() const {
    const std::size_t value = value_of(number(4, 4), 0x0112, 3);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }

  /// Focal length of the lens as if on 35 mm film, mm; 0 if the block does not state it.
  [[nodiscard]] std::size_t focal_length_35mm() const {
    return value_of(value_of(number(4, 4), 0x8769, 4), 0xA405, 3);
  }

 private:
  /// The first value of this tag and type, 3 (two bytes) or 4 (four), in a directory; 0 if there is none.
  [[nodiscard]] std::size_t value_of(std::size_t directory, std::size_t tag, std::size_t type) const {
    if (directory == 0 || (!is_little_ && !tiff_.starts_with("MM"))) return 0;
    const std::size_t entries = number(directory, 2);
    for (std::size_t i = 0; i < entries && directory + 2 + 12 * i + 12 <= tiff_.size(); ++i) {
      const std::size_t entry = directory + 2 + 12 * i;
      if (number(entry, 2) == tag && number(entry + 2, 2) == type)
        return number(entry + 8, type == 3 ? 2 : 4);
    }
    return 0;
  }

  /// The integer there; 0 beyond the end of the block.
  [[nodiscard]] std::size_t number(std::size_t at, std::size_t bytes) const {
    if (at > tiff_.size() || tiff_.size() - at < bytes) return 0;
    std::size_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i)
      value = value << 8U | static_cast<unsigned char>(tiff_[at + (is_little_ ? bytes - 1 - i : i)]);
    return value;
  }

  std::string_view tiff_;
  bool is_little_;
};
}  // namespace detail

/// Longest side, most pixels and most bytes of a PNG file.
inline constexpr std::size_t png_side_limit = 16384;
inline constexpr std::uint64_t png_pixel_limit = std::uint64_t(1) << 26U;  ///< see png_side_limit
inline constexpr std::uint64_t png_file_limit = std::uint64_t(1) << 30U;   ///< see png_side_limit

/// Content of the first chunk of a PNG file, and the place of its palette.
struct PngHeader {
  std::size_t height = 0;
  std::size_t width = 0;
  unsigned bits = 0;         ///< a channel
  unsigned colour_type = 0;  ///< 0 grey, 2 RGB, 3 palette, 4 grey and alpha, 6 RGB and alpha
  bool interlaced = false;
  std::size_t palette_at = 0;    ///< offset of the palette's chunk, 0 without one
  std::size_t palette_size = 0;  ///< bytes of its content
  bool has_alpha = false;        ///< whether it states opacity, by a channel or a colour
  int orientation = 1;           ///< by its EXIF block, see turned_upright()
  std::size_t end_at = 0;        ///< place of a missing end chunk behind whole picture data, else 0
};

/// Whether a file is a PNG by its first bytes, which reveal a transfer as text.
[[nodiscard]] inline bool is_png(std::string_view file) { return file.starts_with("\x89PNG\r\n\x1a\n"); }

namespace detail {
/// A picture's file held in memory, and its name for messages.
class PictureBytes {
 public:
  PictureBytes(std::string_view file, const std::string& path) : file_(file), path_(path) {}

  /// Throws FileError about a byte.
  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected = "",
                         const std::string& found = "", ErrorKind kind = ErrorKind::malformed) const {
    throw FileError(kind, {path_, "@" + std::to_string(at), what, expected, found});
  }

 protected:
  std::string_view file_;
  const std::string& path_;
};

/// Walks over the chunks of a PNG, verifies each, and unpacks the picture data without storing them, to check
/// that they are complete. stb, which decodes the file afterwards, compares no checksum, and allocates the
/// size that a cut chunk claims.
class PngScan : PictureBytes {
 public:
  PngScan(std::string_view file, const std::string& path, std::vector<std::string>* warnings)
      : PictureBytes(file, path), warnings_(warnings) {}

  PngHeader scan() {
    if (!is_png(file_)) fail(0, "not a PNG");
    bool ended = false;
    bool follows_data = false;
    for (std::size_t at = 8; !ended;) {
      if (can_lack_end() && file_.size() - at < 12) header_.end_at = at;
      if (header_.end_at > 0) break;
      const std::size_t size = chunk_size(at);
      const std::string_view type = file_.substr(at + 4, 4);
      const std::string_view content = file_.substr(at + 8, size);
      if ((at == 8) != (type == "IHDR")) fail(at, "PNG does not begin with its one header chunk");
      if (type == "IHDR") read_header(content);
      if (type == "PLTE") {
        if (size == 0 || size % 3 != 0 || size > 768 || header_.palette_at != 0)
          fail(at, "PNG palette is damaged");
        header_.palette_at = at;
        header_.palette_size = size;
      }
      if (type == "IDAT") {
        if (!pieces_.empty() && !follows_data) fail(at, "PNG picture data are interrupted by another chunk");
        pieces_.push_back(content);
      }
      if (type == "tRNS") header_.has_alpha = true;
      if (type == "eXIf") header_.orientation = ExifReader(content).orientation();
      follows_data = type == "IDAT";
      if (type[0] < 'a' && type != "IHDR" && type != "PLTE" && type != "IDAT" && type != "IEND")
        fail(at, "PNG has an unknown chunk that must not be skipped");
      ended = type == "IEND";
      at += size + 12;
    }
    if (header_.colour_type == 3 && header_.palette_at == 0) fail(33, "PNG lacks its palette");
    if (pieces_.empty()) fail(33, "PNG has no picture data");
    check_picture();
    if (header_.end_at > 0)
      warnings_->push_back(path_ + ": PNG lacks a sound end chunk behind its picture data");
    return header_;
  }

 private:
  [[nodiscard]] bool can_lack_end() const { return warnings_ != nullptr && !pieces_.empty(); }

  [[nodiscard]] std::uint32_t u32(std::size_t at) const {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value = value << 8U | static_cast<unsigned char>(file_[at + i]);
    return value;
  }

  /// Size of the content of the chunk at this offset; checks that it lies within the file and has the right
  /// checksum.
  [[nodiscard]] std::size_t chunk_size(std::size_t at) {
    if (file_.size() - at < 12)
      fail(at, "PNG is cut: it does not reach its end chunk", "12 more bytes",
           std::to_string(file_.size() - at));
    const std::size_t size = u32(at);
    if (size > file_.size() - at - 12)
      fail(at, "PNG chunk is longer than the file", std::to_string(size) + " bytes",
           std::to_string(file_.size() - at - 12));
    for (std::size_t i = 4; i < 8; ++i) {
      const char letter = static_cast<char>(static_cast<unsigned char>(file_[at + i]) | 0x20U);
      if (letter < 'a' || letter > 'z') fail(at + 4, "PNG chunk has no name");
    }
    const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(file_.data() + at + 4), size + 4);
    if (crc == u32(at + 8 + size)) return size;
    if (!can_lack_end() || file_.substr(at + 4, 4) != "IEND")
      fail(at + 8 + size, "checksum of PNG chunk is wrong");
    header_.end_at = at;
    return size;
  }

  void read_header(std::string_view content) {
    if (content.size() != 13)
      fail(8, "PNG header has a wrong size", "13 bytes", std::to_string(content.size()));
    header_.width = u32(16);
    header_.height = u32(20);
    const auto byte = [&](std::size_t i) {
      return static_cast<unsigned>(static_cast<unsigned char>(content[i]));
    };
    header_.bits = byte(8);
    header_.colour_type = byte(9);
    header_.has_alpha = header_.colour_type == 4 || header_.colour_type == 6;
    header_.interlaced = byte(12) == 1;
    const std::string size = std::to_string(header_.width) + " x " + std::to_string(header_.height);
    if (header_.width == 0 || header_.height == 0) fail(16, "PNG without a pixel", "1 x 1 or more", size);
    if (header_.width > png_side_limit || header_.height > png_side_limit ||
        std::uint64_t{header_.width} * header_.height > png_pixel_limit)
      fail(16, "picture is too large", "at most 16384 a side and 64 megapixels", size, ErrorKind::limit);
    const unsigned type = header_.colour_type;
    const unsigned allowed = type == 0 ? 1 | 2 | 4 | 8 | 16 : type == 3 ? 1 | 2 | 4 | 8 : 8 | 16;
    const bool one_bit = header_.bits != 0 && (header_.bits & (header_.bits - 1)) == 0;
    if (type > 6 || type == 1 || type == 5 || !one_bit || (header_.bits & allowed) == 0)
      fail(24, "PNG with an unknown kind of pixel", "",
           "colour type " + std::to_string(type) + " of " + std::to_string(header_.bits) + " bits");
    if (byte(10) != 0 || byte(11) != 0 || byte(12) > 1) fail(26, "PNG with an unknown compression");
  }

  /// Bytes of the unpacked picture, with a filter byte before every row, of every pass if interlaced.
  [[nodiscard]] std::uint64_t unpacked_size() const {
    constexpr std::array<std::size_t, 7> channels{1, 0, 3, 1, 2, 0, 4};
    const std::uint64_t pixel_bits = channels[header_.colour_type] * header_.bits;
    const auto pass = [&](std::uint64_t width, std::uint64_t height) {
      return width == 0 ? 0 : height * (1 + (width * pixel_bits + 7) / 8);
    };
    if (!header_.interlaced) return pass(header_.width, header_.height);
    struct Pass {
      std::size_t x, y, dx, dy;
    };
    constexpr Pass adam7[] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                              {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    std::uint64_t size = 0;
    for (const auto& [x, y, dx, dy] : adam7) {
      const auto count = [](std::size_t extent, std::size_t first, std::size_t step) {
        return extent > first ? (extent - first + step - 1) / step : 0;
      };
      size += pass(count(header_.width, x, dx), count(header_.height, y, dy));
    }
    return size;
  }

  void check_picture() const {
    const std::uint64_t needed = unpacked_size();
    std::uint64_t packed = 0;
    for (const auto piece : pieces_) packed += piece.size();
    if (needed > 1032 * (packed + 1))
      fail(33, "PNG has too little picture data for its size",
           std::to_string(needed / 1032) + " bytes or more", std::to_string(packed));
    constexpr std::uint64_t least_surplus = std::uint64_t(1) << 16U;  // beyond twice the picture, a bomb
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) throw std::bad_alloc();
    std::vector<Bytef> buffer(std::size_t{1} << 16U);
    int status = Z_OK;
    for (const auto piece : pieces_) {
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
      stream.avail_in = static_cast<uInt>(piece.size());
      do {
        stream.next_out = buffer.data();
        stream.avail_out = static_cast<uInt>(buffer.size());
        status = inflate(&stream, Z_NO_FLUSH);
      } while (status == Z_OK && (stream.avail_in > 0 || stream.avail_out == 0) &&
               stream.total_out <= 2 * needed + least_surplus);
      if (status != Z_OK && status != Z_BUF_ERROR) break;
    }
    const std::uint64_t unpacked = stream.total_out;
    inflateEnd(&stream);
    if (status == Z_MEM_ERROR) throw std::bad_alloc();
    if (status != Z_STREAM_END)
      fail(33, "PNG picture data is damaged or cut", std::to_string(needed) + " bytes",
           std::to_string(unpacked) + " good ones");
    if (unpacked < needed)
      fail(33, "PNG picture data has a wrong size", std::to_string(needed), std::to_string(unpacked));
    if (unpacked > needed && warnings_ != nullptr)
      warnings_->push_back(path_ + ": PNG has more picture data than its size needs; the rest is ignored");
  }

  std::vector<std::string>* warnings_;
  PngHeader header_;
  std::vector<std::string_view> pieces_;
};
}  // namespace detail

/// Verifies a PNG held in memory before it is decoded: the signature, the header's limits, the length and
/// checksum of every chunk, that the chunks of picture data follow each other, and that the data unpack to
/// the size of the picture, or up to twice that and 64 KiB. Bytes after the end chunk are ignored. Source:
/// PNG specification, second edition (ISO/IEC 15948).
///
/// \param path      for messages
/// \param warnings  unless null, receives sentences about data beyond the size and about a missing or damaged
///                  end chunk; if null, the latter is refused
/// \throws FileError: malformed, limit (over 16,384 a side or 64 Mpx)
[[nodiscard]] inline PngHeader scan_png(std::string_view file, const std::string& path,
                                        std::vector<std::string>* warnings = nullptr) {
  return detail::PngScan(file, path, warnings).scan();
}

/// A verified PNG with an end chunk, and its palette extended to 256 entries, black where the file has none;
/// for a pixel beyond the palette stb would read uninitialised memory. Checksums are no longer right.
[[nodiscard]] inline std::string with_whole_palette(std::string file, const PngHeader& header) {
  if (header.end_at > 0)
    file.replace(header.end_at, std::string::npos, std::string("\0\0\0\0IEND\0\0\0\0", 12));
  if (header.palette_at == 0 || header.palette_size == 768) return file;
  file.insert(header.palette_at + 8 + header.palette_size, 768 - header.palette_size, '\0');
  file.replace(header.palette_at, 4, std::string("\0\0\3\0", 4));
  return file;
}
}  // namespace tapestry::io
