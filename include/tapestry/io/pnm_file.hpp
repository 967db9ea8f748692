#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/io/picture_samples.hpp>

namespace tapestry::io {
namespace detail {
/// Words of the header of a PGM or PPM, between which stand spaces, line ends and comments.
class PnmHeader {
 public:
  PnmHeader(std::string_view file, const std::string& path) : file_(file), path_(path) {}

  [[noreturn]] void fail(std::size_t at, const std::string& what, const std::string& expected = "",
                         const std::string& found = "") const {
    throw FileError(ErrorKind::malformed, {path_, "@" + std::to_string(at), what, expected, found});
  }

  /// The next number. At most seven digits, so that it fits whatever follows.
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

  /// The place of the first sample, after one white space.
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

/// Decodes a binary PGM (P5) or PPM (P6) of 8 or 16 bits; of several pictures in a file the first. Read here
/// and not by stb, which leaves samples unscaled where the greatest is not 255, and takes a cut file for a
/// whole one. Source: Netpbm, formats pgm(5) and ppm(5).
/// Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param path  for messages
/// \throws FileError: malformed (another format, cut, a sample above the greatest), limit (over 16,384 a side
/// or 64 Mpx)
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
