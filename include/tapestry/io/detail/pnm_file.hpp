#pragma once
#include <tapestry/io/image_file.hpp>

namespace tapestry::io {
namespace detail {
/// Words of the header of a PBM, PGM or PPM, and of a plain one's samples, separated by spaces, line ends and
/// comments.
class PnmHeader : public PictureBytes {
 public:
  using PictureBytes::PictureBytes;

  /// The next number, of at most seven digits, so that it cannot overflow.
  [[nodiscard]] unsigned number() {
    skip_blanks();
    const std::size_t begin = at_;
    unsigned value = 0;
    for (; at_ < file_.size() && file_[at_] >= '0' && file_[at_] <= '9'; ++at_) {
      if (at_ - begin == 7) fail(begin, "number in the header of a PNM picture is too long");
      value = value * 10 + static_cast<unsigned>(file_[at_] - '0');
    }
    if (at_ == begin)
      fail(at_,
           at_ == file_.size() ? "PNM picture is cut: a number is missing" : "PNM picture lacks a number");
    return value;
  }

  /// The next digit, 0 or 1, of a plain PBM, whose digits may stand without blanks.
  [[nodiscard]] unsigned bit() {
    skip_blanks();
    if (at_ >= file_.size() || (file_[at_] != '0' && file_[at_] != '1'))
      fail(at_, "PNM picture lacks a bit", "0 or 1");
    return file_[at_++] == '1' ? 1 : 0;
  }

  [[nodiscard]] std::size_t at() const { return at_; }

  /// The offset of the first sample, after one white space.
  [[nodiscard]] std::size_t samples_at() const {
    if (at_ >= file_.size() || !is_space(file_[at_])) fail(at_, "header of a PNM picture does not end");
    return at_ + 1;
  }

 private:
  void skip_blanks() {
    while (at_ < file_.size() && (is_space(file_[at_]) || file_[at_] == '#')) {
      if (file_[at_] == '#')
        while (at_ < file_.size() && file_[at_] != '\n' && file_[at_] != '\r') ++at_;
      else
        ++at_;
    }
  }

  [[nodiscard]] static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  std::size_t at_ = 2;
};

/// Samples of a binary picture: bits of rows that fill whole bytes, 8 bits, or 16 from the upper byte on.
inline void read_binary_samples(std::string_view file, const PnmHeader& header, PictureSamples& picture) {
  const std::size_t begin = header.samples_at(), row_values = picture.width * picture.channels;
  const bool is_bits = file[1] == '4';
  const std::size_t value_bytes = picture.maximum > 255 ? 2 : 1;
  const std::size_t row_bytes = is_bits ? (row_values + 7) / 8 : row_values * value_bytes;
  if (file.size() - begin < picture.height * row_bytes)
    header.fail(begin, "PNM picture is cut", std::to_string(picture.height * row_bytes) + " bytes",
                std::to_string(file.size() - begin));
  for (std::size_t i = 0; i < picture.samples.size(); ++i) {
    const std::size_t row = begin + i / row_values * row_bytes, value = i % row_values;
    const auto byte = [&](std::size_t k) { return unsigned{static_cast<unsigned char>(file[row + k])}; };
    const unsigned sample = is_bits            ? byte(value / 8) >> (7 - value % 8) & 1U
                            : value_bytes == 2 ? byte(2 * value) << 8U | byte(2 * value + 1)
                                               : byte(value);
    if (sample > picture.maximum)
      header.fail(row + value * value_bytes, "sample of a PNM picture",
                  "at most " + std::to_string(picture.maximum), std::to_string(sample));
    picture.samples[i] = static_cast<std::uint16_t>(sample);
  }
}

inline void read_plain_samples(bool is_bits, PnmHeader& header, PictureSamples& picture) {
  for (std::uint16_t& sample : picture.samples) {
    const unsigned value = is_bits ? header.bit() : header.number();
    if (value > picture.maximum)
      header.fail(header.at(), "sample of a PNM picture", "at most " + std::to_string(picture.maximum),
                  std::to_string(value));
    sample = static_cast<std::uint16_t>(value);
  }
}
}  // namespace detail

/// Whether a file is a PBM, PGM or PPM, plain or binary, by its first bytes.
[[nodiscard]] inline bool is_pnm(std::string_view file) {
  return file.size() > 2 && file[0] == 'P' && file[1] >= '1' && file[1] <= '6' &&
         std::string_view(" \t\n\v\f\r#").find(file[2]) != std::string_view::npos;
}

/// Decodes a PBM (P1, P4), PGM (P2, P5) or PPM (P3, P6), plain or binary, of up to 16 bits; of several
/// pictures in a file, the first. Implemented here instead of by stb, which does not scale samples whose
/// maximum is not 255, and accepts cut files. Source: Netpbm, formats pbm(5), pgm(5) and ppm(5).
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: malformed (another format, cut, a sample above the maximum), limit (over 16,384 a side
///         or 64 Mpx)
[[nodiscard]] inline PictureSamples parse_pnm(std::string_view file, const std::string& path) {
  detail::PnmHeader header(file, path);
  if (!is_pnm(file)) header.fail(0, "not a PBM, PGM or PPM picture");
  const bool is_plain = file[1] <= '3', is_bits = file[1] == '1' || file[1] == '4';
  PictureSamples picture;
  picture.channels = file[1] == '6' || file[1] == '3' ? 3 : 1;
  picture.width = header.number();
  picture.height = header.number();
  detail::require_picture_size(picture.width, picture.height, path, "@2");
  picture.maximum = is_bits ? 1 : header.number();
  if (picture.maximum == 0 || picture.maximum > 65535)
    header.fail(2, "greatest sample of a PNM picture", "1 to 65535", std::to_string(picture.maximum));
  const std::size_t count = picture.height * picture.width * picture.channels;
  if (file.size() < count / 8) header.fail(header.at(), "PNM picture is cut");  // before memory is taken
  picture.samples.resize(count);
  is_plain ? detail::read_plain_samples(is_bits, header, picture)
           : detail::read_binary_samples(file, header, picture);
  if (is_bits)
    for (std::uint16_t& sample : picture.samples)
      sample = static_cast<std::uint16_t>(1 - sample);  // 1 is black
  return picture;
}
}  // namespace tapestry::io
