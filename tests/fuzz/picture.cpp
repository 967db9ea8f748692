#include <tapestry/io/image_file.hpp>

#include "../support/bmp_builder.hpp"
#include "../support/png_builder.hpp"
#include "target.hpp"

namespace {
using namespace tapestry;

void read(const std::string& bytes) {
  const std::string path = fuzz::folder().write("picture", bytes);
  const auto image = io::read_image(path);
  if (image.size() == 0) throw std::logic_error("a picture without pixels");
  (void)io::read_mask(path);  // which takes less: a JPEG is no mask
}

/// A PNG of each kind of 9 x 5 pixels; palettes are of 3 colours. BMPs, a PGM and a PPM of a few pixels.
std::vector<std::string> seeds() {
  const std::string palette = test::png_chunk("PLTE", std::string(9, '\x40'));
  std::vector<std::string> files;
  const std::pair<int, int> kinds[]{{0, 1}, {0, 8}, {0, 16}, {2, 8}, {2, 16}, {3, 2}, {4, 8}, {6, 8}};
  for (const auto& [colour, bits] : kinds) {
    const std::size_t channels = colour == 2 ? 3 : colour == 4 ? 2 : colour == 6 ? 4 : 1;
    const std::size_t row = 1 + (9 * channels * static_cast<std::size_t>(bits) + 7) / 8;
    test::PngParts parts{9, 5, bits, colour, 0, "", colour == 3 ? palette : ""};
    for (std::size_t i = 0; i < 5 * row; ++i)
      parts.rows += static_cast<char>(i % row == 0 ? i / row : colour == 3 ? 0x12 : 17 * i);
    files.push_back(test::png(parts));
  }
  for (const int bits : {1, 8})
    files.push_back(test::bmp({.bits = bits, .palette = "one_two_", .rows = "\1..."}));
  files.push_back(test::bmp({.width = 2, .height = -2, .header_size = 124, .rows = "abcdef..ghijkl.."}));
  const std::string masks =
      test::little_endian(0xF800, 4) + test::little_endian(0x7E0, 4) + test::little_endian(0x1F, 4);
  files.push_back(test::bmp({.bits = 16, .compression = 3, .palette = masks, .rows = "ab.."}));
  files.emplace_back("P5 2 1 65535\nabcd");
  files.emplace_back("P6\n#\n1 2 127\nabcdef");
  return files;
}

/// Puts the checksum of every chunk right, as far as chunks can be found.
std::string repair(std::string file) {
  if (!file.starts_with("\x89PNG")) return file;
  for (std::size_t at = 8; at + 12 <= file.size();) {
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < 4; ++i) size = size << 8U | static_cast<unsigned char>(file[at + i]);
    if (size > file.size() - at - 12) break;
    const std::string chunk = test::png_chunk(file.substr(at + 4, 4), file.substr(at + 8, size));
    file.replace(at, chunk.size(), chunk);
    at += chunk.size();
  }
  return file;
}

const fuzz::Registered target({"picture", read, seeds, repair});
}  // namespace
