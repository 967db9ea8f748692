#pragma once
#include <cctype>
#include <tapestry/io/detail/picture_format.hpp>
#include <tapestry/io/implementation/image_file.hpp>

namespace tapestry::io {
namespace detail {
inline Array<std::uint8_t, 3> png_picture(std::string file, const std::string& path,
                                          std::vector<std::string>* warnings, bool is_texture) {
  const PngHeader header = scan_png(file, path, warnings);
  const std::size_t channels = is_texture && header.has_alpha ? 4 : 3;
  Array<std::uint8_t, 3> image(Extents<3>{header.height, header.width, channels});
  require_decoded(decode_png(with_whole_palette(std::move(file), header), image), path);
  if (channels == 3) return turned_upright(std::move(image), is_texture ? 1 : header.orientation);
  Array<std::uint8_t, 3> colours(Extents<3>{header.height, header.width, 3});
  bool is_opaque = true;
  for (std::size_t i = 0; i < header.height * header.width; ++i) {
    std::copy_n(image.data() + 4 * i, 3, colours.data() + 3 * i);
    is_opaque = is_opaque && image.data()[4 * i + 3] == 255;
  }
  if (!is_opaque && warnings != nullptr)
    warnings->push_back(path + ": the picture's transparency is not drawn; its colours count as opaque");
  return colours;
}

inline Array<float, 2> png_mask(std::string file, const std::string& path,
                                std::vector<std::string>* warnings) {
  const PngHeader header = scan_png(file, path, warnings);
  Array<std::uint16_t, 3> stored(Extents<3>{header.height, header.width, 1});
  require_decoded(decode_png(with_whole_palette(std::move(file), header), stored), path);
  const auto upright = turned_upright(std::move(stored), header.orientation);
  Array<float, 2> mask(Extents<2>{upright.shape(0), upright.shape(1)});
  for (std::size_t i = 0; i < mask.size(); ++i)
    mask.data()[i] = static_cast<float>(upright.data()[i]) / 65535.0F;
  return mask;
}

inline Array<std::uint8_t, 3> jpeg_picture(std::string file, const std::string& path,
                                           std::vector<std::string>* warnings, bool is_texture) {
  return parse_jpeg(file, path, warnings, !is_texture);
}

template <auto parse>
Array<std::uint8_t, 3> plain_picture(std::string file, const std::string& path, std::vector<std::string>*,
                                     bool) {
  return rgb_levels(parse(file, path));
}

template <auto parse>
Array<float, 2> plain_mask(std::string file, const std::string& path, std::vector<std::string>*) {
  return grey_shares(parse(file, path));
}

std::span<const PictureFormat> picture_formats() {
  static constexpr PictureFormat formats[]{
      {"PNG", ".png", is_png, png_picture, png_mask},
      {"JPEG", ".jpg .jpeg", is_jpeg, jpeg_picture, nullptr},
      {"BMP", ".bmp", is_bmp, plain_picture<parse_bmp>, plain_mask<parse_bmp>},
      {"PBM PGM PPM", ".pgm .ppm .pnm", is_pnm, plain_picture<parse_pnm>, plain_mask<parse_pnm>}};
  return formats;
}

/// The words of a column of picture_formats(), each behind a space.
inline std::string words_of_formats(std::string_view PictureFormat::*column) {
  std::string words;
  for (const PictureFormat& format : picture_formats()) words.append(" ").append(format.*column);
  return words;
}

/// Those words as a list for messages: "A, B or C".
inline std::string listed_formats(std::string_view PictureFormat::*column) {
  std::string list = words_of_formats(column).substr(1);
  list.replace(list.rfind(' '), 1, " or ");
  for (auto at = list.find(' '); at < list.rfind(" or "); at = list.find(' ', at + 2)) list.insert(at, ",");
  return list;
}

/// \throws FileError (malformed) for a file of no such format
inline const PictureFormat& picture_format(const std::string& file, const std::string& path) {
  for (const PictureFormat& format : picture_formats())
    if (format.recognises(file)) return format;
  std::string_view found = recognised_format(std::as_bytes(std::span<const char>(file)));
  if (found.empty()) found = file.empty() ? "0 bytes" : "other bytes";
  constexpr std::pair<std::string_view, const char*> others[]{
      {"GIF8", "a GIF image"},      {"8BPS", "a PSD image"}, {"\x76\x2f\x31\x01", "an EXR image"},
      {"\xabKTX", "a KTX texture"}, {"#?", "an HDR image"},  {"\x89PNG", "a PNG damaged by a text transfer"}};
  for (const auto& [beginning, name] : others)
    if (file.starts_with(beginning)) found = name;
  if (file.size() > 2 && file[0] == 'P' && file[1] >= '1' && file[1] <= '7')
    found = "a PNM image of another kind";
  throw malformed_file({path, "@0", "not a picture of a kind that is read here",
                        "a " + listed_formats(&PictureFormat::names), std::string(found)});
}
}  // namespace detail

std::string picture_endings() { return detail::listed_formats(&detail::PictureFormat::endings); }

bool has_picture_name(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::ranges::transform(ending, ending.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return (detail::words_of_formats(&detail::PictureFormat::endings) + " ").find(" " + ending + " ") !=
         std::string::npos;
}

Array<std::uint8_t, 3> detail::read_picture(const std::string& path, std::vector<std::string>* warnings,
                                            bool is_texture) {
  std::string file = read_text_file(path, png_file_limit);
  const PictureFormat& format = picture_format(file, path);
  return format.picture(std::move(file), path, warnings, is_texture);
}

Array<std::uint8_t, 3> read_image(const std::string& path, std::vector<std::string>* warnings) {
  return detail::read_picture(path, warnings, false);
}

Array<std::uint8_t, 3> read_texture(const std::string& path, std::vector<std::string>* warnings) {
  return detail::read_picture(path, warnings, true);
}

Array<float, 2> read_mask(const std::string& path, std::vector<std::string>* warnings) {
  std::string file = read_text_file(path, png_file_limit);
  const auto& format = detail::picture_format(file, path);
  if (format.mask == nullptr)
    throw malformed_file(
        {path, "@0", "a mask must not have lost anything", "a PNG", "a " + std::string(format.names)});
  return format.mask(std::move(file), path, warnings);
}

void write_image(const std::string& path, const Array<std::uint8_t, 3>& image) {
  write_file_atomically(path, png_file(path, image));
}

std::string png_file(const std::string& path, const Array<std::uint8_t, 3>& image) {
  const std::size_t channels = image.shape(2) == 4 ? 4 : 3;
  require_shape("png_file", "image", image, {image.shape(0), image.shape(1), channels});
  return detail::checked_png(path, image.data(), image.shape(0), image.shape(1), static_cast<int>(channels));
}

std::string jpeg_file(const std::string& path, const Array<std::uint8_t, 3>& image, int quality) {
  require_shape("jpeg_file", "image", image, {image.shape(0), image.shape(1), 3});
  if (quality < 1 || quality > 100)
    throw DomainError({"jpeg_file: quality is ", quality, ", expected 1 to 100"});
  detail::require_writable_size(path, image.shape(0), image.shape(1));
  return detail::encode_jpeg(image.data(), image.shape(0), image.shape(1), quality);
}
}  // namespace tapestry::io
