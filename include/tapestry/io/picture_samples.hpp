#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/png_scan.hpp>  // limits of pictures
#include <vector>

namespace tapestry::io {

/// A picture as an uncompressed file stores it.
struct PictureSamples {
  std::size_t height = 0;
  std::size_t width = 0;
  std::size_t channels = 3;            ///< 1 grey, 3 RGB
  unsigned maximum = 255;              ///< the sample that means 1
  std::vector<std::uint16_t> samples;  ///< [height, width, channels], none above `maximum`
};

/// RGB of 256 levels, [H, W, 3]: samples are rounded, grey is repeated in the three channels.
[[nodiscard]] inline Array<std::uint8_t, 3> rgb_levels(const PictureSamples& picture) {
  Array<std::uint8_t, 3> image(Extents<3>{picture.height, picture.width, 3});
  for (std::size_t i = 0; i < image.size(); ++i) {
    const unsigned sample = picture.samples[picture.channels == 3 ? i : i / 3];
    image.data()[i] = static_cast<std::uint8_t>((sample * 255 + picture.maximum / 2) / picture.maximum);
  }
  return image;
}

/// Grey in [0, 1], [H, W]; colours become (77 R + 150 G + 29 B) / 256, cut to a whole sample, as for a PNG.
[[nodiscard]] inline Array<float, 2> grey_shares(const PictureSamples& picture) {
  Array<float, 2> grey(Extents<2>{picture.height, picture.width});
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const std::uint16_t* const sample = picture.samples.data() + i * picture.channels;
    const unsigned value =
        picture.channels == 1 ? sample[0] : (77U * sample[0] + 150U * sample[1] + 29U * sample[2]) / 256;
    grey.data()[i] = static_cast<float>(value) / static_cast<float>(picture.maximum);
  }
  return grey;
}

namespace detail {
/// \param position  where the file states the size, for messages
/// \throws FileError (limit) of a picture over 16,384 a side or 64 Mpx, (malformed) of one without a pixel
inline void require_picture_size(std::uint64_t width, std::uint64_t height, const std::string& path,
                                 const std::string& position) {
  const auto refuse = [&](ErrorKind kind, const char* what, const char* expected) {
    throw FileError(kind,
                    {path, position, what, expected, std::to_string(width) + " x " + std::to_string(height)});
  };
  if (width == 0 || height == 0) refuse(ErrorKind::malformed, "picture without a pixel", "1 x 1 or more");
  if (width > png_side_limit || height > png_side_limit || width * height > png_pixel_limit)
    refuse(ErrorKind::limit, "picture is too large", "at most 16384 a side and 64 megapixels");
}
}  // namespace detail
}  // namespace tapestry::io
