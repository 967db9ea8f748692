#pragma once
/// \file
/// The compiled part of image_file.hpp: stb's PNG reader and its writers of PNG and JPEG, with internal
/// linkage, so that a program may carry another copy of them.
#if defined(INCLUDE_STB_IMAGE_H) || defined(INCLUDE_STB_IMAGE_WRITE_H)
#error "include tapestry/implementation.hpp before any header of stb"
#endif

#include <tapestry/core/parallel.hpp>
#include <tapestry/io/detail/deflated_part.hpp>
#include <tapestry/io/image_file.hpp>

namespace tapestry::io::detail {
/// Compressor for stb's writer; its files are smaller than with stb's own. The caller frees the result. Uses
/// zlib's default level, not the 8 that stb passes: level 8 takes 5 times as long for files smaller by 4 % (a
/// sheet of 960 pictures). Parts are deflated by several threads, as by Adler's pigz; a picture of one part
/// has the bytes of zlib's compress().
inline unsigned char* compress_for_png(unsigned char* bytes, int count, int* compressed_count, int) {
  constexpr std::size_t part_size = std::size_t{1} << 20U;
  const auto size = static_cast<std::size_t>(count);
  const std::string_view all(reinterpret_cast<const char*>(bytes), size);
  std::vector<std::string> parts(block_count(size, part_size));
  parallel_for(parts.size(), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, size, part_size);
    parts[index] = deflated_part(all, begin, end, end == size, Z_DEFAULT_COMPRESSION, MAX_MEM_LEVEL - 1);
  });
  std::size_t sum = 6;
  for (const auto& part : parts) {
    if (part.empty()) return nullptr;
    sum += part.size();
  }
  auto* const compressed = static_cast<unsigned char*>(std::malloc(sum));
  if (compressed == nullptr) return nullptr;
  unsigned char* to = compressed;
  *to++ = 0x78;  // deflate, a window of 32 KiB
  *to++ = 0x9C;  // default level
  for (const auto& part : parts) to = std::copy(part.begin(), part.end(), to);
  const uLong check = adler32_z(adler32(0, nullptr, 0), bytes, size);
  for (unsigned shift = 32; shift > 0; shift -= 8) *to++ = static_cast<unsigned char>(check >> (shift - 8));
  *compressed_count = static_cast<int>(sum);
  return compressed;
}
}  // namespace tapestry::io::detail

#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#pragma GCC diagnostic ignored "-Wpedantic"
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wdouble-promotion"
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wcast-qual"
#pragma GCC diagnostic ignored "-Wcast-align"
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#include <stb_image.h>
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#define STBIW_ZLIB_COMPRESS tapestry::io::detail::compress_for_png
#include <stb_image_write.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace tapestry::io::detail {
/// Fills a picture by a loader of stb. Throws if stb ran out of memory, which it does not always report as
/// the reason.
template <class Element, class Load>
bool decode_png_by(Load load, std::string_view file, Array<Element, 3>& pixels) {
  int width = 0, height = 0, stored_channels = 0;
  stbi__g_failure_reason = nullptr;
  const std::unique_ptr<Element, decltype(&stbi_image_free)> decoded(
      load(reinterpret_cast<const stbi_uc*>(file.data()), static_cast<int>(file.size()), &width, &height,
           &stored_channels, static_cast<int>(pixels.shape(2))),
      stbi_image_free);
  if (decoded == nullptr) {
    const char* const reason = stbi_failure_reason();
    if (reason == nullptr || std::string_view(reason) == "outofmem") throw std::bad_alloc();
    return false;
  }
  if (static_cast<std::size_t>(height) != pixels.shape(0) ||
      static_cast<std::size_t>(width) != pixels.shape(1))
    return false;
  std::copy_n(decoded.get(), pixels.size(), pixels.data());
  return true;
}

bool decode_png(std::string_view file, Array<std::uint16_t, 3>& pixels) {
  return decode_png_by(stbi_load_16_from_memory, file, pixels);
}

bool decode_png(std::string_view file, Array<std::uint8_t, 3>& pixels) {
  return decode_png_by(stbi_load_from_memory, file, pixels);
}

/// Takes what stb's writers write.
inline void append_to_file(void* file, void* bytes, int count) {
  static_cast<std::string*>(file)->append(static_cast<const char*>(bytes), static_cast<std::size_t>(count));
}

/// File that a writer of stb makes. Where memory lacks, it tries once more without what the pool keeps.
template <class Write>
std::string encoded_by(Write write) {
  for (const bool is_last : {false, true}) {
    std::string file;
    if (write(&file) != 0) return file;
    if (!is_last) platform::PagePool::shared().release();
  }
  throw std::bad_alloc();
}

std::string encode_png(const std::uint8_t* pixels, std::size_t height, std::size_t width, int channels) {
  return encoded_by([&](std::string* file) {
    return stbi_write_png_to_func(append_to_file, file, static_cast<int>(width), static_cast<int>(height),
                                  channels, pixels, static_cast<int>(width) * channels);
  });
}

std::string encode_jpeg(const std::uint8_t* pixels, std::size_t height, std::size_t width, int quality) {
  return encoded_by([&](std::string* file) {
    return stbi_write_jpg_to_func(append_to_file, file, static_cast<int>(width), static_cast<int>(height), 3,
                                  pixels, quality);
  });
}
}  // namespace tapestry::io::detail
