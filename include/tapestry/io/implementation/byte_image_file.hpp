#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/detail/bmp_file.hpp>
#include <tapestry/io/detail/png_scan.hpp>
#include <tapestry/io/detail/pnm_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/implementation/image_file.hpp>
#include <tapestry/io/jpeg_file.hpp>

namespace tapestry::io {

Array<std::uint8_t, 3> detail::read_picture(const std::string& path, std::vector<std::string>* warnings,
                                            bool is_texture) {
  std::string file = read_text_file(path, png_file_limit);
  if (is_jpeg(file)) return parse_jpeg(file, path, warnings, !is_texture);
  if (is_bmp(file)) return rgb_levels(parse_bmp(file, path));
  if (is_pnm(file)) return rgb_levels(parse_pnm(file, path));
  const PngHeader header = scan_png(file, path, warnings);
  const std::size_t channels = is_texture && header.has_alpha ? 4 : 3;
  const auto pixels =
      detail::decode_png_8(with_whole_palette(std::move(file), header), static_cast<int>(channels));
  detail::require_decoded(pixels, header.height * header.width * channels, path);
  Array<std::uint8_t, 3> image(Extents<3>{header.height, header.width, 3});
  bool is_opaque = true;
  for (std::size_t i = 0; i < header.height * header.width; ++i) {
    std::copy_n(pixels.data() + i * channels, 3, image.data() + 3 * i);
    is_opaque = is_opaque && (channels == 3 || pixels[i * channels + 3] == 255);
  }
  if (!is_opaque && warnings != nullptr)
    warnings->push_back(path + ": the picture's transparency is not drawn; its colours count as opaque");
  return is_texture ? image : turned_upright(image, header.orientation);
}

Array<std::uint8_t, 3> read_image(const std::string& path, std::vector<std::string>* warnings) {
  return detail::read_picture(path, warnings, false);
}

Array<std::uint8_t, 3> read_texture(const std::string& path, std::vector<std::string>* warnings) {
  return detail::read_picture(path, warnings, true);
}

Array<float, 2> read_mask(const std::string& path, std::vector<std::string>* warnings) {
  std::string file = read_text_file(path, png_file_limit);
  if (is_jpeg(file))
    throw FileError(ErrorKind::malformed,
                    {path, "@0", "a mask must not have lost anything", "a PNG", "a JPEG"});
  if (is_bmp(file)) return grey_shares(parse_bmp(file, path));
  if (is_pnm(file)) return grey_shares(parse_pnm(file, path));
  const PngHeader header = scan_png(file, path, warnings);
  const auto pixels = detail::decode_png_16(with_whole_palette(std::move(file), header), 1);
  detail::require_decoded(pixels, header.height * header.width, path);
  Array<float, 3> stored(Extents<3>{header.height, header.width, 1});
  for (std::size_t i = 0; i < pixels.size(); ++i) stored.data()[i] = static_cast<float>(pixels[i]) / 65535.0F;
  const auto upright = turned_upright(stored, header.orientation);
  Array<float, 2> mask(Extents<2>{upright.shape(0), upright.shape(1)});
  std::copy_n(upright.data(), upright.size(), mask.data());
  return mask;
}

void write_image(const std::string& path, const Array<std::uint8_t, 3>& image) {
  require_shape("write_image", "image", image, {image.shape(0), image.shape(1), 3});
  detail::write_png(path, image.data(), image.shape(0), image.shape(1), 3);
}

std::string png_file(const std::string& path, const Array<std::uint8_t, 3>& image) {
  require_shape("png_file", "image", image, {image.shape(0), image.shape(1), 3});
  return detail::checked_png(path, image.data(), image.shape(0), image.shape(1), 3);
}

std::string jpeg_file(const std::string& path, const Array<std::uint8_t, 3>& image, int quality) {
  require_shape("jpeg_file", "image", image, {image.shape(0), image.shape(1), 3});
  if (quality < 1 || quality > 100)
    throw DomainError({"jpeg_file: quality is ", quality, ", expected 1 to 100"});
  detail::require_writable_size(path, image.shape(0), image.shape(1));
  return detail::require_encoded(path,
                                 detail::encode_jpeg(image.data(), image.shape(0), image.shape(1), quality));
}

}  // namespace tapestry::io
