#pragma once
#include <tapestry/io/detail/png_scan.hpp>  // limits of pictures

namespace tapestry::io {
/// A picture as an uncompressed file stores it.
struct PictureSamples {
  std::size_t height = 0;
  std::size_t width = 0;
  std::size_t channels = 3;            ///< 1 grey, 3 RGB
  unsigned maximum = 255;              ///< the sample value that stands for 1
  std::vector<std::uint16_t> samples;  ///< [height, width, channels], none above `maximum`
};

/// RGB in 256 levels, [H, W, 3]: samples are rounded, and grey is repeated in the three channels.
[[nodiscard]] inline Array<std::uint8_t, 3> rgb_levels(const PictureSamples& picture) {
  Array<std::uint8_t, 3> image(Extents<3>{picture.height, picture.width, 3});
  for (std::size_t i = 0; i < image.size(); ++i) {
    const unsigned sample = picture.samples[picture.channels == 3 ? i : i / 3];
    image.data()[i] = static_cast<std::uint8_t>((sample * 255 + picture.maximum / 2) / picture.maximum);
  }
  return image;
}

/// Grey in [0, 1], [H, W]; colours become (77 R + 150 G + 29 B) / 256, truncated to a whole sample, as for a
/// PNG.
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
/// \param position place in the file that states the size, for messages
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
/// The part that calls stb, compiled where a program includes implementation.hpp: fills [H, W, C], C as the
/// caller wants them.
/// \returns false if stb cannot decode the file
bool decode_png(std::string_view file, Array<std::uint16_t, 3>& pixels);
bool decode_png(std::string_view file, Array<std::uint8_t, 3>& pixels);

/// read_texture() or read_image().
Array<std::uint8_t, 3> read_picture(const std::string& path, std::vector<std::string>* warnings,
                                    bool is_texture);

/// \throws std::bad_alloc
std::string encode_png(const std::uint8_t* pixels, std::size_t height, std::size_t width, int channels);
std::string encode_jpeg(const std::uint8_t* pixels, std::size_t height, std::size_t width, int quality);

/// Nearest of 256 levels to a value, which is first clipped to [0, 1].
template <std::floating_point T>
std::uint8_t level(T value) {
  return static_cast<std::uint8_t>((value < 0 ? T(0) : value > 1 ? T(1) : value) * T(255) + T(0.5));
}

/// \param channels values a pixel, used to name the pixel of a value that is not finite
template <std::floating_point T>
std::vector<std::uint8_t> levels(const T* values, std::size_t count, std::size_t width, std::size_t channels,
                                 const std::string& path);
}  // namespace detail

/// Reads a PNG, JPEG, BMP, PBM, PGM or PPM as RGB, [H, W, 3]. The format is found from the content, not the
/// name.
///
/// Pictures are turned upright by their EXIF. Every kind of PNG is converted: grey is repeated in the three
/// channels, palettes are looked up (black beyond their end), 1 to 4 bits are scaled to 0-255, and of 16 bits
/// the upper 8 are kept. Transparency is dropped and colours are taken as stored (PNG does not premultiply).
/// Colour profiles and gamma are ignored. For the other formats see parse_jpeg(), parse_bmp() and
/// parse_pnm(). Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
///
/// \param warnings  receives sentences about damage that leaves a picture: surplus data of a PNG, a JPEG with
///                  junk bytes or a cut end. Null refuses such a JPEG
/// \throws FileError: malformed (no such format, damaged, checksums included), limit (over 16,384 a side or
///         64 Mpx)
[[nodiscard]] Array<std::uint8_t, 3> read_image(const std::string& path,
                                                std::vector<std::string>* warnings = nullptr);

/// read_image() of a picture that uv point into: as stored, since no viewer turns a texture by its EXIF. A
/// picture that is not opaque adds a warning.
[[nodiscard]] Array<std::uint8_t, 3> read_texture(const std::string& path,
                                                  std::vector<std::string>* warnings = nullptr);

/// Reads a PNG, BMP, PBM, PGM or PPM as grey in [0, 1], [H, W]: value / 255, or / 65535 where the file has 16
/// bits (PGM and PPM: divided by the maximum that they state). Colours become (77 R + 150 G + 29 B) / 256;
/// transparency is dropped. No threshold is applied. Throws as read_image() does, and for a JPEG, because its
/// losses blur a mask's border. Takes memory of at most 4 times the file, 24 bytes a pixel and 1 MiB.
[[nodiscard]] Array<float, 2> read_mask(const std::string& path,
                                        std::vector<std::string>* warnings = nullptr);

/// Writes RGB, or RGBA with straight opacity, [H, W, 3 or 4], as PNG; the whole file or nothing.
/// \throws ShapeError unless there are 3 or 4 channels and 1 to 16,384 rows and columns; FileError (write)
void write_image(const std::string& path, const Array<std::uint8_t, 3>& image);

/// Writes RGB in [0, 1], [H, W, 3], rounded to 256 levels; values outside are clipped.
/// \throws NumericError naming the first pixel that is not finite; otherwise as above
template <std::floating_point T>
void write_image(const std::string& path, const Array<T, 3>& image);

/// RGB or RGBA, [H, W, 3 or 4], as the bytes of a PNG file; `path` is for messages. Errors as above.
[[nodiscard]] std::string png_file(const std::string& path, const Array<std::uint8_t, 3>& image);

/// RGB in [0, 1], [H, W, 3], as the bytes of a PNG file; `path` is for messages. Errors as above.
template <std::floating_point T>
[[nodiscard]] std::string png_file(const std::string& path, const Array<T, 3>& image);

/// RGB, [H, W, 3], as the bytes of a baseline JPEG file: smaller than a PNG, and not without loss.
///
/// \param path     for messages
/// \param quality  1 to 100; at most 90 halves the resolution of colours in both directions
/// \throws DomainError for another quality; otherwise as write_image()
[[nodiscard]] std::string jpeg_file(const std::string& path, const Array<std::uint8_t, 3>& image,
                                    int quality);

/// Writes a grey picture in [0, 1], [H, W]; otherwise as above.
template <std::floating_point T>
void write_mask(const std::string& path, const Array<T, 2>& mask);

/// Writes the gradient of a picture as a picture for people: grey where it is 0, brighter where more of a
/// colour raises the value, darker where more of it lowers the value.
///
///   ½ + ½ · ∛(g / max |g|)
///
/// The cube root makes small values visible: a thousandth of the largest is shown as a tenth.
///
/// \param gradient  [1, H, W, 3]
/// \throws ShapeError for other extents; NumericError for values that are not finite; FileError (write)
template <std::floating_point T>
void write_gradient(const std::string& path, const Array<T, 4>& gradient);
}  // namespace tapestry::io
