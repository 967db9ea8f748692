#pragma once
#include <tapestry/io/detail/png_scan.hpp>  // limits of pictures

namespace tapestry::io {
/// Header of a JPEG file, before the picture data.
struct JpegHeader {
  std::size_t height = 0;  ///< as stored, before it is turned upright
  std::size_t width = 0;
  std::size_t channels = 0;           ///< 1 grey, 3 colour, 4 CMYK
  int orientation = 1;                ///< 1 to 8, see turned_upright()
  std::size_t focal_length_35mm = 0;  ///< of the lens as if on 35 mm film, mm, by EXIF; 0 if not stated
};

namespace detail {
/// Walks over the segments of a JPEG up to its picture data.
class JpegScan : PictureBytes {
 public:
  using PictureBytes::PictureBytes;

  [[nodiscard]] JpegHeader scan() {
    for (std::size_t at = 2;;) {
      while (byte(at) != 0xFF) ++at;      // junk between segments; the decoder warns
      while (byte(at + 1) == 0xFF) ++at;  // fill bytes
      const unsigned marker = byte(at + 1);
      if (marker == 0xDA) break;
      if (marker <= 0x01 || (marker >= 0xD0 && marker <= 0xD8)) {
        at += 2;
        continue;
      }
      if (marker == 0xD9) fail(at, "JPEG ends before its picture data");
      const std::size_t length = byte(at + 2) << 8U | byte(at + 3);
      if (length < 2 || file_.size() - at - 2 < length) fail(at, "JPEG segment is cut");
      read_segment(marker, at, file_.substr(at + 4, length - 2));
      at += 2 + length;
    }
    if (header_.width == 0) fail(2, "JPEG has no frame header before its picture data");
    return header_;
  }

 private:
  [[nodiscard]] unsigned byte(std::size_t at) const {
    if (at >= file_.size()) fail(file_.size(), "JPEG ends before its picture data");
    return static_cast<unsigned char>(file_[at]);
  }

  void read_segment(unsigned marker, std::size_t at, std::string_view content) {
    using namespace std::string_view_literals;
    if (marker == 0xE1 && content.starts_with("Exif\0\0"sv)) {
      const ExifReader exif(content.substr(6));
      header_.orientation = exif.orientation();
      header_.focal_length_35mm = exif.focal_length_35mm();
    }
    const bool is_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (!is_frame) return;
    if (marker > 0xC2 && marker != 0xC9 && marker != 0xCA)
      fail(at, "this kind of JPEG is not read", "baseline, sequential or progressive coding",
           "frame type " + std::to_string(marker - 0xC0));
    if (header_.width != 0) fail(at, "JPEG has a second frame header");
    if (content.size() < 6) fail(at, "JPEG frame header is cut");
    const auto number = [&](std::size_t i) { return static_cast<unsigned char>(content[i]); };
    if (number(0) != 8) fail(at, "bits a channel of a JPEG", "8", std::to_string(number(0)));
    header_.height = static_cast<std::size_t>(number(1) << 8U | number(2));
    header_.width = static_cast<std::size_t>(number(3) << 8U | number(4));
    header_.channels = number(5);
    if (header_.channels != 1 && header_.channels != 3 && header_.channels != 4)
      fail(at, "channels of a JPEG", "1 (grey), 3 (colour) or 4 (CMYK)", std::to_string(header_.channels));
    if (header_.height == 0 || header_.width == 0) fail(at, "JPEG of no extent");
    if (header_.height > png_side_limit || header_.width > png_side_limit ||
        std::uint64_t(header_.height) * header_.width > png_pixel_limit)
      fail(at, "picture is too large", "at most 16384 a side and 64 Mpx",
           std::to_string(header_.width) + " x " + std::to_string(header_.height), ErrorKind::limit);
  }

  JpegHeader header_;
};

/// Error or warning of a decoder; empty for a sound file.
struct JpegComplaint {
  std::string text{};
  bool is_warning = false;  ///< damage that leaves a picture
};

/// The part that calls libjpeg-turbo, compiled where a program includes implementation.hpp: RGB, or CMYK as
/// stored, rows from the top, channels interleaved.
/// \param pixels    height · width · 3 bytes, or · 4 for a header of 4 channels
/// \param is_strict whether to stop at the first damage
JpegComplaint decode_jpeg(std::string_view file, const JpegHeader& header, bool is_strict,
                          std::uint8_t* pixels);

/// RGB of CMYK as Adobe's programs store it, inverted: K · C / 255 and so on, rounded.
[[nodiscard]] Array<std::uint8_t, 3> rgb_of_inverted_cmyk(const Array<std::uint8_t, 3>& cmyk);
}  // namespace detail

/// A picture, [H, W, C], turned upright by its EXIF orientation. 1 returns it without a copy, 2 mirrors it
/// left to right, 4 top to bottom, and 3 turns it by half a circle. 5 to 8 exchange rows and columns; 6 turns
/// it clockwise by a quarter, 8 counterclockwise.
template <class Element>
[[nodiscard]] Array<Element, 3> turned_upright(Array<Element, 3> stored, int orientation) {
  if (orientation == 1) return stored;
  const auto [rows, columns, channels] = stored.shape();
  const bool exchanges = orientation >= 5;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 7 || orientation == 8;
  const bool from_bottom = orientation == 3 || orientation == 4 || orientation == 6 || orientation == 7;
  Array<Element, 3> upright(Extents<3>{exchanges ? columns : rows, exchanges ? rows : columns, channels});
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t x = 0; x < columns; ++x) {
      const std::size_t row = from_bottom ? rows - 1 - y : y;
      const std::size_t column = from_right ? columns - 1 - x : x;
      for (std::size_t c = 0; c < channels; ++c)
        upright(exchanges ? column : row, exchanges ? row : column, c) = stored(y, x, c);
    }
  return upright;
}

/// Whether a file is a JPEG by its first bytes.
[[nodiscard]] inline bool is_jpeg(std::string_view file) { return file.starts_with("\xff\xd8\xff"); }

/// Reads the header of a JPEG, up to the picture data. Sources: ITU-T T.81, annex B; for the orientation and
/// the focal length Exif 2.3 (CIPA DC-008), sections 4.6.4 and 4.6.5.
///
/// \param path  for messages
/// \throws FileError: malformed (cut; lossless or hierarchical), limit (over 16,384 a side or 64 Mpx)
[[nodiscard]] inline JpegHeader scan_jpeg(std::string_view file, const std::string& path) {
  return detail::JpegScan(file, path).scan();
}

/// Decodes a JPEG, sequential or progressive, of Huffman or arithmetic coding, as RGB, [H, W, 3], turned
/// upright by its EXIF orientation. Grey is repeated in the three channels, CMYK counts as inverted, as
/// Adobe's programs store it; colour profiles are ignored. Decoding is left to libjpeg-turbo. Takes memory of
/// at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path      for messages
/// \param warnings  receives a sentence about picture data that are damaged, cut or hold junk bytes: the rest
///                  is read, missing pixels are grey. Null refuses such a file
/// \param is_upright  whether the picture is turned; else it stays as stored
/// \throws FileError: as scan_jpeg(); malformed for picture data that cannot be decoded; mismatch if the
///         program was built without libjpeg-turbo
[[nodiscard]] Array<std::uint8_t, 3> parse_jpeg(std::string_view file, const std::string& path,
                                                std::vector<std::string>* warnings = nullptr,
                                                bool is_upright = true);
}  // namespace tapestry::io
