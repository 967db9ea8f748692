// Pictures, and NumPy's arrays and archives.
#include <random>
#include <tapestry/camouflage/run_state.hpp>
#include <tapestry/io/image_file.hpp>
#include <tapestry/io/npy.hpp>
#if defined(TAPESTRY_JPEG)
#include <turbojpeg.h>

#include <memory>
#endif

#include "../../tests/support/bmp_builder.hpp"
#include "../../tests/support/png_builder.hpp"
#include "kind.hpp"

namespace tapestry::benchmarks {
namespace {
std::string noise(std::size_t bytes) {
  std::mt19937_64 random(1);
  std::string text(bytes, '\0');
  for (char& byte : text) byte = static_cast<char>(random() >> 56U);
  return text;
}

void read_picture(const std::string& path) { (void)io::read_image(path); }
double picture_memory(const std::string& path) {
  return times_file(4)(path) + 24 * static_cast<double>(io::read_image(path).size()) / 3;
}

/// Noise that does not compress, in rows of `row_bytes` behind a filter byte of 0.
std::string noise_rows(std::size_t row_bytes, std::size_t count) {
  std::string rows = noise((row_bytes + 1) * count);
  for (std::size_t y = 0; y < count; ++y) rows[y * (row_bytes + 1)] = '\0';
  return rows;
}

std::string png_of(const test::PngParts& parts, std::size_t piece) {
  const std::string packed = test::zlib_packed(parts.rows, 0);
  std::string file = test::png_signature() + test::png_header(parts);
  for (std::size_t at = 0; at < packed.size(); at += piece)
    file += test::png_chunk("IDAT", packed.substr(at, piece));
  return file + test::png_chunk("IEND", "");
}

/// \param columns  a multiple of 8
test::PngParts noise_png(std::size_t columns, std::size_t bits, int colour_type, std::size_t bytes) {
  const std::size_t row = columns * bits * test::png_channels(colour_type) / 8, rows = bytes / (row + 1);
  return {.width = static_cast<std::uint32_t>(columns),
          .height = static_cast<std::uint32_t>(rows),
          .bits = static_cast<int>(bits),
          .colour_type = colour_type,
          .rows = noise_rows(row, rows)};
}

std::string small_pieces(std::size_t bytes) { return png_of(noise_png(1024, 8, 2, bytes / 13), 1); }
std::string single_bits(std::size_t bytes) { return png_of(noise_png(8192, 1, 0, bytes), 1U << 20U); }
std::string other_chunks(std::size_t bytes) {
  const test::PngParts parts = noise_png(8, 8, 0, 9);
  return filled(test::png_signature() + test::png_header(parts), test::png_chunk("abCd", ""),
                test::png_chunk("IDAT", test::zlib_packed(parts.rows)) + test::png_chunk("IEND", ""))(bytes);
}

std::string bits_of_bmp(std::size_t bytes) {
  const auto rows = static_cast<int>(bytes / 1024);
  return test::bmp(
      {.width = 8192, .height = rows, .bits = 1, .palette = "one_two_", .rows = noise(bytes / 1024 * 1024)});
}
std::string grey(std::size_t bytes) {
  return "P5 1000 " + std::to_string(bytes / 1000) + " 255\n" + noise(bytes / 1000 * 1000);
}

#if defined(TAPESTRY_JPEG)
std::string jpeg(std::size_t columns, std::size_t rows) {
  const std::string pixels = noise(columns * rows * 3);
  const auto close = [](void* coder) { tjDestroy(coder); };
  const std::unique_ptr<void, decltype(close)> coder(tjInitCompress(), close);
  unsigned char* file = nullptr;
  unsigned long size = 0;
  tjCompress2(coder.get(), reinterpret_cast<const unsigned char*>(pixels.data()), static_cast<int>(columns),
              0, static_cast<int>(rows), TJPF_RGB, &file, &size, TJSAMP_444, 50, TJFLAG_PROGRESSIVE);
  std::string bytes(reinterpret_cast<char*>(file), size);
  tjFree(file);
  return bytes;
}
std::string progressive(std::size_t bytes) {
  const std::size_t of_64_rows = jpeg(1024, 64).size();
  return jpeg(1024, 64 * bytes / of_64_rows);
}
#endif

std::string numbers(std::size_t bytes) {
  const std::size_t shape[]{bytes};
  const std::string values = noise(bytes);
  return io::npy_bytes<std::uint8_t>(shape, {reinterpret_cast<const std::uint8_t*>(values.data()), bytes});
}
void read_numbers(const std::string& path) {
  (void)io::parse_npy(io::read_text_file(path), path).as<double>();
}

std::string many_members(std::size_t bytes) {
  const std::size_t shape[]{0};
  const std::string empty = io::npy_bytes<double>(shape, {});
  io::ZipWriter writer;
  for (std::size_t i = 0; i < bytes / (2 * 10 + 76 + empty.size()); ++i)
    writer.add(std::to_string(i) + ".npy", empty, false);
  return writer.bytes();
}
/// Fifty times as large unpacked.
std::string deflated(std::size_t bytes) {
  std::string values(50 * bytes, '\0');
  const std::string drawn = noise(values.size() / 64);
  for (std::size_t i = 0; i < drawn.size(); ++i) values[64 * i] = drawn[i];
  const std::size_t shape[]{values.size()};
  io::ZipWriter writer;
  writer.add("a.npy",
             io::npy_bytes<std::uint8_t>(
                 shape, {reinterpret_cast<const std::uint8_t*>(values.data()), values.size()}),
             true);
  return writer.bytes();
}
void read_archive(const std::string& path) {
  const auto file = io::NpzFile::read(path);
  for (const auto& name : file.names()) (void)file.get(name);
}
/// Memory of 4 times the file and so many times its arrays.
double arrays_memory(const std::string& path, double times) {
  const auto file = io::NpzFile::read(path);
  std::size_t bytes = 0;
  for (const auto& name : file.names()) bytes += file.get(name).bytes.size();
  return times_file(4)(path) + times * static_cast<double>(bytes);
}
double archive_memory(const std::string& path) { return arrays_memory(path, 2); }

/// Bytes that become numbers of eight times their size, and rows of a history.
std::string checkpoint(std::size_t bytes) {
  const std::size_t rows = bytes / camouflage::detail::history_columns;
  io::NpzWriter writer;
  writer.add("format", camouflage::checkpoint_format);
  writer.add("settings", std::string_view("settings"));
  for (const char* name : {"step", "adam_step"}) writer.add(name, std::uint64_t(rows));
  writer.add("parameter", Array<std::uint8_t, 2>(Extents<2>{0, 0}));
  for (const char* name : {"adam_first_moment", "adam_second_moment"})
    writer.add(name, std::vector<std::uint8_t>());
  Array<std::uint8_t, 2> history(Extents<2>{rows, camouflage::detail::history_columns});
  std::fill(history.begin(), history.end(), std::uint8_t(1));
  writer.add("history", history);
  return writer.bytes();
}
void read_checkpoint(const std::string& path) { (void)camouflage::read_checkpoint<float>(path); }
double checkpoint_memory(const std::string& path) { return arrays_memory(path, 24); }
}  // namespace

std::vector<Kind> picture_kinds() {
  std::vector<Kind> kinds{{"png: 16-bit noise",
                           [](std::size_t bytes) { return png_of(noise_png(1024, 16, 6, bytes), 1U << 20U); },
                           read_picture, picture_memory},
                          {"png: 1 bit a pixel", single_bits, read_picture, picture_memory},
                          {"png: pieces of a byte", small_pieces, read_picture, picture_memory},
                          {"png: chunks to skip", other_chunks, read_picture, picture_memory},
                          {"bmp: 1 bit a pixel", bits_of_bmp, read_picture, picture_memory},
                          {"pgm", grey, read_picture, picture_memory}};
#if defined(TAPESTRY_JPEG)
  kinds.push_back({"jpeg: progressive", progressive, read_picture, picture_memory});
#endif
  return kinds;
}

std::vector<Kind> array_kinds() {
  return {{"npy: bytes to double", numbers, read_numbers, times_file(3 + 8)},
          {"npz: empty members", many_members, read_archive, archive_memory},
          {"npz: deflated", deflated, read_archive, archive_memory},
          {"checkpoint: bytes", checkpoint, read_checkpoint, checkpoint_memory}};
}
}  // namespace tapestry::benchmarks
