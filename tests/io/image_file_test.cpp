#include <tapestry/io/image_file.hpp>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "../support/catch.hpp"
#include "../support/png_builder.hpp"
#include "../support/random_array.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

namespace io = tapestry::io;
using tapestry::Array;
using tapestry::ErrorKind;
using tapestry::test::BadContent;
using tapestry::test::big_endian;
using tapestry::test::check_refused;
using tapestry::test::png;
using tapestry::test::png_chunk;
using tapestry::test::PngParts;

namespace {
std::string bytes(std::initializer_list<int> values) {
  std::string text;
  for (const int value : values) text += static_cast<char>(value);
  return text;
}

std::vector<int> values_of(const Array<std::uint8_t, 3>& image) { return {image.begin(), image.end()}; }

/// 3 × 2 pixels of random colours.
Array<std::uint8_t, 3> small_image() {
  Array<std::uint8_t, 3> image(tapestry::Extents<3>{3, 2, 3});
  tapestry::Random random(1);
  for (auto& value : image.storage()) value = static_cast<std::uint8_t>(random.uniform(0, 256));
  return image;
}
}  // namespace

TEST_CASE("every kind of PNG is converted by the stated rule", "[io][image]") {  // I09, I10, I12
  const tapestry::test::TemporaryFolder folder;
  struct Row {
    const char* kind;
    PngParts parts;
    std::vector<int> expected;
  };
  const std::string palette = png_chunk("PLTE", bytes({1, 2, 3, 7, 8, 9}));
  const Row rows[] = {
      {"grey", {.width = 2, .rows = bytes({0, 5, 250})}, {5, 5, 5, 250, 250, 250}},
      {"1 bit", {.width = 2, .bits = 1, .rows = bytes({0, 0x40})}, {0, 0, 0, 255, 255, 255}},
      {"2 bits", {.width = 2, .bits = 2, .rows = bytes({0, 0x60})}, {85, 85, 85, 170, 170, 170}},
      {"16 bits", {.bits = 16, .rows = bytes({0, 0x12, 0xff})}, {0x12, 0x12, 0x12}},
      {"RGB", {.colour_type = 2, .rows = bytes({0, 1, 2, 3})}, {1, 2, 3}},
      {"palette",
       {.width = 2, .bits = 4, .colour_type = 3, .rows = bytes({0, 0x10}), .before_data = palette},
       {7, 8, 9, 1, 2, 3}},
      {"beyond the palette",
       {.width = 2, .bits = 4, .colour_type = 3, .rows = bytes({0, 0x1f}), .before_data = palette},
       {7, 8, 9, 0, 0, 0}},
      {"grey and alpha", {.colour_type = 4, .rows = bytes({0, 9, 0})}, {9, 9, 9}},
      {"RGB and alpha", {.colour_type = 6, .rows = bytes({0, 1, 2, 3, 0})}, {1, 2, 3}},
      {"interlaced",
       {.width = 2, .height = 2, .interlace = 1, .rows = bytes({0, 1, 0, 2, 0, 3, 4})},
       {1, 1, 1, 2, 2, 2, 3, 3, 3, 4, 4, 4}},
  };
  for (const Row& row : rows) {
    INFO(row.kind);
    CHECK(values_of(io::read_image(folder.write("picture.jpg", png(row.parts)))) == row.expected);
  }
}

TEST_CASE("a mask keeps sixteen bits", "[io][image]") {
  const tapestry::test::TemporaryFolder folder;
  const auto deep = io::read_mask(folder.write("m.png", png({.bits = 16, .rows = bytes({0, 0x12, 0x34})})));
  CHECK(deep(0, 0) == float(0x1234) / 65535.0F);
  const auto shallow =
      io::read_mask(folder.write("m.png", png({.width = 3, .rows = bytes({0, 0, 128, 255})})));
  CHECK(std::vector<float>{shallow.begin(), shallow.end()} == std::vector<float>{0, 128.0F / 255.0F, 1});
}

TEST_CASE("a picture comes back", "[io][image]") {
  const tapestry::test::TemporaryFolder folder;
  const auto image = small_image();
  io::write_image(folder.path("a.png"), image);
  CHECK(values_of(io::read_image(folder.path("a.png"))) == values_of(image));
  const Array<float, 3> shares = tapestry::cast<float>(image) / 255.0F;
  io::write_image(folder.path("b.png"), shares);
  CHECK(folder.read("b.png") == folder.read("a.png"));
  const Array<double, 2> mask = {{-1.0, 0.0}, {0.5, 2.0}};
  io::write_mask(folder.path("m.png"), mask);
  const auto again = io::read_mask(folder.path("m.png"));
  CHECK(std::vector<float>{again.begin(), again.end()} == std::vector<float>{0, 0, 128.0F / 255.0F, 1});
}

TEST_CASE("bad pictures are refused", "[io][image][bad_input]") {
  const tapestry::test::TemporaryFolder folder;
  const PngParts one{.rows = bytes({0, 7})};
  const std::string good = png(one);
  const std::string signature = tapestry::test::png_signature();
  const std::string header = tapestry::test::png_header(one);
  const std::string packed = tapestry::test::zlib_packed(one.rows);
  const std::string data = png_chunk("IDAT", packed);
  const std::string end = png_chunk("IEND", "");
  const auto sized = [](std::uint32_t width, std::uint32_t height) {
    return png({.width = width, .height = height});
  };
  const auto cut_stream = [&](std::size_t size) {
    return signature + header + png_chunk("IDAT", tapestry::test::zlib_packed(one.rows).substr(0, size)) +
           end;
  };
  std::string wrong_sum = tapestry::test::zlib_packed(one.rows);
  wrong_sum.back() = static_cast<char>(wrong_sum.back() + 1);
  const auto malformed = ErrorKind::malformed;
  const BadContent rows[] = {
      {"I01", sized(0, 0), malformed, "without a pixel"},
      {"I01 rows", sized(0, 5), malformed, "without a pixel"},
      {"I02", sized(1U << 24U, 1U << 24U), ErrorKind::limit, "too large"},
      {"I02 words", sized(0xFFFFFFFF, 0xFFFFFFFF), ErrorKind::limit, "too large"},
      {"I02 pixels", sized(16384, 16384), ErrorKind::limit, "64 megapixels"},
      {"I03", signature + header + big_endian(0x7A000000) + "IDAT....", malformed, "longer than the file"},
      {"I04", sized(8000, 8000), malformed, "too little picture data"},
      {"I04 smaller", png({.width = 50, .height = 50, .rows = one.rows}), malformed, "wrong size"},
      {"I04 more", png({.rows = bytes({0, 1, 2, 3})}), malformed, "wrong size"},
      {"I05 no end", signature + header + data, malformed, "cut"},
      {"I05 stream", cut_stream(8), malformed, "damaged or cut"},
      {"I05 stream sum cut", cut_stream(tapestry::test::zlib_packed(one.rows).size() - 1), malformed, "cut"},
      {"I05 stream sum", signature + header + png_chunk("IDAT", wrong_sum) + end, malformed, "damaged"},
      {"I05 checksum", std::string(good).replace(50, 1, "?"), malformed, "checksum"},
      {"I05 data apart",
       signature + header + png_chunk("IDAT", packed.substr(0, 5)) + png_chunk("tIME", "") +
           png_chunk("IDAT", packed.substr(5)) + end,
       malformed, "interrupted by another chunk"},
      {"I05 no data", signature + header + end, malformed, "no picture data"},
      {"I05 no header", signature + data + end, malformed, "header chunk"},
      {"I05 two headers", signature + header + header + data + end, malformed, "header chunk"},
      {"I05 filter", png({.rows = bytes({9, 7})}), malformed, "cannot be decoded"},
      {"I05 unknown chunk", signature + header + png_chunk("CgBI", "") + data + end, malformed,
       "unknown chunk"},
      {"I05 chunk name", signature + header + png_chunk("1234", "") + data + end, malformed, "no name"},
      {"I05 bits", png({.bits = 3, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 colour", png({.bits = 4, .colour_type = 2, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 palette", png({.colour_type = 3, .rows = one.rows}), malformed, "palette"},
      {"I05 palette size",
       png({.colour_type = 3, .rows = one.rows, .before_data = png_chunk("PLTE", "1234")}), malformed,
       "palette"},
      {"I05 interlace", png({.interlace = 2, .rows = one.rows}), malformed, "compression"},
      {"I08 GIF", "GIF89a", malformed, "found a GIF image"},
      {"I08 BMP", "BM....", malformed, "found a BMP image"},
      {"I08 PSD", "8BPS", malformed, "found a PSD image"},
      {"I08 HDR", "#?RADIANCE", malformed, "found an HDR image"},
      {"I08 PNM", "P6 1 1", malformed, "found a PNM image"},
      {"I08 TGA", std::string(18, '\2'), malformed, "found other bytes"},
      {"I19 EXR", "\x76\x2f\x31\x01", malformed, "found an EXR image"},
      {"I19 KTX", "\xabKTX 11", malformed, "found a KTX texture"},
      {"empty", "", malformed, "0 bytes"},
      {"text transfer", "\x89PNG\n\x1a\n", malformed, "text transfer"},
  };
  for (const BadContent& row : rows) {
    INFO(row.id);
    const std::string path = folder.write("a.png", row.file);
    check_refused(row.kind, row.text, [&] { (void)io::read_image(path); });
    check_refused(row.kind, "a.png:", [&] { (void)io::read_mask(path); });
  }
}

TEST_CASE("every cut and every changed byte of a PNG is refused", "[io][image][bad_input]") {
  const tapestry::test::TemporaryFolder folder;
  io::write_image(folder.path("a.png"), small_image());
  const std::string good = folder.read("a.png");
  for (std::size_t at = 0; at < good.size(); ++at) {
    INFO(at);
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 4);
    CHECK_THROWS_AS(io::scan_png(good.substr(0, at), "a.png"), tapestry::FileError);
    CHECK_THROWS_AS(io::scan_png(changed, "a.png"), tapestry::FileError);
  }
  CHECK(io::scan_png(good + "more", "a.png").width == 2);
}

TEST_CASE("a picture with a value that is not finite is not written", "[io][image]") {  // I17, I20
  const tapestry::test::TemporaryFolder folder;
  auto image = tapestry::test::random_array<float>({2, 3, 3}, 1);
  image(1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(io::write_image(folder.path("a.png"), image), tapestry::NumericError);
  check_refused(ErrorKind::numeric, "row 1, column 2", [&] { io::write_image(folder.path("a.png"), image); });
  CHECK_FALSE(std::filesystem::exists(folder.path("a.png")));
  const auto two_channels = tapestry::test::random_array<float>({2, 3, 2}, 1);
  CHECK_THROWS_AS(io::write_image(folder.path("a.png"), two_channels), tapestry::ShapeError);
  const Array<float, 2> empty(tapestry::Extents<2>{0, 3});
  CHECK_THROWS_AS(io::write_mask(folder.path("a.png"), empty), tapestry::ShapeError);
}

TEST_CASE("the real masks are read", "[io][image]") {
  const std::string path = TAPESTRY_SHARED "/data/carla/mask1.png";
  if (!std::filesystem::exists(path)) {
    WARN("skipped: " << path << " is absent");
    return;
  }
  const auto mask = io::read_mask(path);
  CHECK((mask.shape() == tapestry::Extents<2>{608, 608}));
  CHECK(std::count_if(mask.begin(), mask.end(), [](float value) { return value > 0; }) > 30000);
}
