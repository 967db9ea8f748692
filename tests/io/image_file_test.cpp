#include <tapestry/io/detail/bmp_file.hpp>
#include <tapestry/io/detail/pnm_file.hpp>
#include <tapestry/io/jpeg_file.hpp>

#include "../support/bmp_builder.hpp"
#include "../support/paths.hpp"
#include "../support/png_builder.hpp"
#include "../support/random_array.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"
#include "../support/threads.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
std::string bytes(std::initializer_list<int> values) {
  std::string text;
  for (const int value : values) text += static_cast<char>(value);
  return text;
}

std::vector<int> values_of(const Array<std::uint8_t, 3>& image) { return {image.begin(), image.end()}; }

/// 3 × 2 pixels of random colours.
Array<std::uint8_t, 3> small_image() {
  Array<std::uint8_t, 3> image(Extents<3>{3, 2, 3});
  Random random(1);
  for (auto& value : image.storage()) value = static_cast<std::uint8_t>(random.uniform(0, 256));
  return image;
}

void check_bad_pictures(std::span<const BadContent> rows) {
  const test::TemporaryFolder folder;
  for (const BadContent& row : rows) {
    INFO(row.id);
    const std::string path = folder.write("a.png", row.file);
    check_refused(row.kind, row.text, [&] { (void)io::read_image(path); });
    check_refused(row.kind, "a.png:", [&] { (void)io::read_mask(path); });
  }
}
}  // namespace

TEST_CASE("every kind of PNG is converted by the stated rule", "[io][image]") {  // I09, I10, I12
  const test::TemporaryFolder folder;
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

namespace {
/// A kind of pixel that PNG knows.
struct PixelKind {
  int colour_type;
  unsigned bits;
};
constexpr PixelKind pixel_kinds[]{{0, 1}, {0, 2}, {0, 4}, {0, 8}, {0, 16}, {2, 8}, {2, 16}, {3, 1},
                                  {3, 2}, {3, 4}, {3, 8}, {4, 8}, {4, 16}, {6, 8}, {6, 16}};

test::PngSamples random_samples(const PixelKind& kind, std::size_t height, std::size_t width,
                                std::uint64_t seed) {
  test::PngSamples picture{height, width, test::png_channels(kind.colour_type), kind.bits};
  Random random(seed);
  for (std::size_t i = 0; i < height * width * picture.channels; ++i)
    picture.samples.push_back(static_cast<unsigned>(random.uniform(0, double(1U << kind.bits))));
  return picture;
}

/// Entry k of the palette is (k, 255 - k, 3 k mod 256).
std::string palette_of(unsigned bits) {
  std::string colours;
  for (int k = 0; k < 1 << bits; ++k) colours += bytes({k, 255 - k, 3 * k % 256});
  return png_chunk("PLTE", colours);
}

/// Values of a pixel by the rule of read_image().
std::vector<int> expected_values(const PixelKind& kind, const test::PngSamples& picture) {
  std::vector<int> values;
  for (std::size_t y = 0; y < picture.height; ++y)
    for (std::size_t x = 0; x < picture.width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        const bool is_colour = kind.colour_type == 2 || kind.colour_type == 6;
        const auto sample = static_cast<int>(picture.at(y, x, is_colour ? c : 0));
        if (kind.colour_type == 3)
          values.push_back(c == 0 ? sample : c == 1 ? 255 - sample : 3 * sample % 256);
        else
          values.push_back(kind.bits == 16 ? sample >> 8 : sample * 255 / ((1 << kind.bits) - 1));
      }
  return values;
}

PngParts parts_of(const PixelKind& kind, const test::PngSamples& picture, bool interlaced, unsigned filter) {
  return {.width = static_cast<std::uint32_t>(picture.width),
          .height = static_cast<std::uint32_t>(picture.height),
          .bits = static_cast<int>(kind.bits),
          .colour_type = kind.colour_type,
          .interlace = interlaced ? 1 : 0,
          .rows = test::png_rows(picture, interlaced, filter),
          .before_data = kind.colour_type == 3 ? palette_of(kind.bits) : std::string()};
}
}  // namespace

// The kinds of pictures of PngSuite (van Schaik), drawn anew: all pixels, sizes, filters, passes, chunks and
// streams.
TEST_CASE("every pixel, filter, size and order of rows of a PNG is read", "[io][image]") {
  const test::TemporaryFolder folder;
  std::uint64_t seed = 0;
  for (const PixelKind& kind : pixel_kinds)
    for (const bool interlaced : {false, true})
      for (const std::size_t size : {1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U, 33U, 40U}) {
        const auto filter = static_cast<unsigned>(++seed % 6);
        INFO("colour type " << kind.colour_type << " of " << kind.bits << " bits, size " << size
                            << ", filter " << filter << (interlaced ? ", interlaced" : ""));
        const std::size_t width = size, height = seed % 2 == 0 ? size : 10 - size % 10;
        const auto picture = random_samples(kind, height, width, seed);
        const auto file = folder.write("a.png", png(parts_of(kind, picture, interlaced, filter)));
        CHECK(values_of(io::read_image(file)) == expected_values(kind, picture));
        if (kind.colour_type != 0 && kind.colour_type != 4) continue;
        const auto mask = io::read_mask(file);
        const auto largest = static_cast<float>((1U << kind.bits) - 1);
        for (std::size_t y = 0; y < height; ++y)
          for (std::size_t x = 0; x < width; ++x)
            CHECK(std::abs(mask(y, x) - static_cast<float>(picture.at(y, x, 0)) / largest) <= 1e-7F);
      }
}

TEST_CASE("what a PNG says beside its pixels does not change them", "[io][image]") {
  const test::TemporaryFolder folder;
  const std::string date = bytes({7, 208, 1, 1, 0, 0, 0}), text = "Title" + std::string(1, '\0');
  const std::string packed = std::string(1, '\0') + test::zlib_packed("words");
  for (const PixelKind& kind : pixel_kinds) {
    const auto picture = random_samples(kind, 5, 9, 7);
    const auto expected = expected_values(kind, picture);
    const std::size_t channels = picture.channels;
    const bool is_palette = kind.colour_type == 3, has_alpha = kind.colour_type >= 4;
    const std::string palette = is_palette ? palette_of(kind.bits) : std::string();
    const std::string one = is_palette ? std::string(1, '\1') : std::string(channels >= 3 ? 6 : 2, '\0');
    const std::string clear = is_palette ? std::string(1, '\0') : std::string(channels == 3 ? 6 : 2, '\0');
    const std::string depth(is_palette ? 3 : channels, '\1');
    const std::pair<const char*, std::string> rows[] = {
        {"gamma", png_chunk("gAMA", big_endian(45455)) + palette},
        {"chromaticities", png_chunk("cHRM", std::string(32, '\1')) + palette},
        {"sRGB", png_chunk("sRGB", std::string(1, '\0')) + palette},
        {"significant bits", png_chunk("sBIT", depth) + palette},
        {"background", palette + png_chunk("bKGD", one)},
        {"physical size", palette + png_chunk("pHYs", std::string(8, '\1') + '\1')},
        {"date", palette + png_chunk("tIME", date)},
        {"texts", palette + png_chunk("tEXt", text) + png_chunk("zTXt", text + packed) +
                      png_chunk("iTXt", text + std::string(4, '\0') + "words")},
        {"EXIF", palette + png_chunk("eXIf", std::string("MM\0*", 4) + std::string(8, '\0'))},
        {"suggested palette", png_chunk("sPLT", text + bytes({8, 1, 2, 3, 4, 0, 5})) + palette},
        {"histogram",
         palette + (is_palette ? png_chunk("hIST", std::string(std::size_t{2} << kind.bits, '\1'))
                               : std::string())},
        {"palette of colours", channels >= 3 ? palette_of(8) : palette},
        {"transparency", palette + (has_alpha ? std::string() : png_chunk("tRNS", clear))},
        {"unknown", palette + png_chunk("abCd", "anything")},
    };
    for (const auto& [what, before_data] : rows) {
      INFO(what << ", colour type " << kind.colour_type << " of " << kind.bits << " bits");
      PngParts parts = parts_of(kind, picture, false, 5);
      parts.before_data = before_data;
      CHECK(values_of(io::read_image(folder.write("a.png", png(parts)))) == expected);
    }
  }
}

TEST_CASE("PNG picture data may come in any pieces and at any level of compression", "[io][image]") {
  const test::TemporaryFolder folder;
  const PixelKind kind{2, 8};
  const auto picture = random_samples(kind, 12, 13, 9);
  const auto expected = expected_values(kind, picture);
  const PngParts parts = parts_of(kind, picture, true, 5);
  const std::string beginning = test::png_signature() + test::png_header(parts);
  for (const int level : {0, 1, 3, 6, 9})
    for (const std::size_t piece : {1U, 2U, 4U, 100U, 100000U}) {
      INFO("level " << level << ", pieces of " << piece);
      const std::string packed = test::zlib_packed(parts.rows, level);
      std::string file = beginning;
      for (std::size_t at = 0; at < packed.size();
           at += piece)  // empty ones between: of a first one stb copies from null
        file += png_chunk("IDAT", packed.substr(at, piece)) + png_chunk("IDAT", "");
      CHECK(values_of(io::read_image(folder.write("a.png", file + png_chunk("IEND", "")))) == expected);
    }
}

TEST_CASE("a texture that is not opaque is named, its colours are those of its pixels", "[io][image]") {
  const test::TemporaryFolder folder;
  const std::string palette = png_chunk("PLTE", bytes({1, 2, 3}));
  const struct {
    PngParts parts;
    bool is_opaque;
  } rows[]{
      {{.colour_type = 6, .rows = bytes({0, 1, 2, 3, 255})}, true},
      {{.colour_type = 6, .rows = bytes({0, 1, 2, 3, 254})}, false},
      {{.colour_type = 4, .rows = bytes({0, 9, 0})}, false},
      {{.colour_type = 2, .rows = bytes({0, 1, 2, 3})}, true},
      {{.colour_type = 3, .rows = bytes({0, 0}), .before_data = palette}, true},
      {{.colour_type = 3, .rows = bytes({0, 0}), .before_data = palette + png_chunk("tRNS", "\x80")}, false},
  };
  for (const auto& [parts, is_opaque] : rows) {
    const std::string path = folder.write("a.png", png(parts));
    std::vector<std::string> warnings;
    CHECK((io::read_texture(path, &warnings) == io::read_image(path, &warnings)));
    CHECK(warnings.size() == (is_opaque ? 0U : 1U));
    for (const std::string& word : warnings) CHECK_THAT(word, test::contains("transparency"));
  }
}

TEST_CASE("a PNG is turned upright by its EXIF block", "[io][image]") {
  const test::TemporaryFolder folder;
  const PixelKind kind{2, 8};
  PngParts parts = parts_of(kind, random_samples(kind, 3, 2, 9), false, 5);
  const auto stored = io::read_image(folder.write("a.png", png(parts)));
  for (char orientation = 1; orientation <= 8; ++orientation) {
    std::string block("II*\0\x8\0\0\0\1\0\x12\1\3\0\1\0\0\0?\0\0\0\0\0\0\0", 26);
    block[18] = orientation;
    parts.before_data = png_chunk("eXIf", block);
    const std::string path = folder.write("a.png", png(parts));
    CHECK((io::read_image(path) == io::turned_upright(stored, orientation)));
    CHECK((io::read_texture(path) == stored));
    const auto mask = io::read_mask(path);
    CHECK(mask.shape(0) == (orientation < 5 ? stored.shape(0) : stored.shape(1)));
  }
  const PngParts row{.width = 2, .height = 1, .rows = bytes({0, 0, 255})};
  PngParts turned = row;
  turned.before_data = png_chunk("eXIf", std::string("MM\0*\0\0\0\x8\0\1\1\x12\0\3\0\0\0\1\0\6\0\0", 22));
  const auto mask = io::read_mask(folder.write("m.png", png(turned)));  // by a quarter, clockwise
  REQUIRE((mask.shape() == Extents<2>{2, 1}));
  CHECK(mask(0, 0) == 0);
  CHECK(mask(1, 0) == 1);
}

TEST_CASE("a PNG whose picture is whole is read without a sound end chunk, with a warning",
          "[io][image]") {  // I05
  const test::TemporaryFolder folder;
  const PixelKind kind{2, 8};
  const std::string file = png(parts_of(kind, random_samples(kind, 3, 2, 9), false, 5));
  const auto whole = io::read_image(folder.write("a.png", file));
  const auto read_with_warning = [&](const std::string& content) {
    std::vector<std::string> warnings;
    const std::string path = folder.write("a.png", content);
    CHECK((io::read_image(path, &warnings) == whole));
    CHECK(warnings == std::vector{path + ": PNG lacks a sound end chunk behind its picture data"});
    CHECK_THROWS_AS(io::read_image(path), FileError);
  };
  for (const std::size_t missing : {1U, 5U, 12U}) read_with_warning(file.substr(0, file.size() - missing));
  std::string damaged = file;
  damaged.back() = '?';  // its checksum
  read_with_warning(damaged);
  std::vector<std::string> warnings;
  CHECK_THROWS_AS(io::read_image(folder.write("a.png", file.substr(0, file.size() - 13)), &warnings),
                  FileError);  // of the picture data's checksum
}

TEST_CASE("a mask keeps sixteen bits", "[io][image]") {
  const test::TemporaryFolder folder;
  const auto deep = io::read_mask(folder.write("m.png", png({.bits = 16, .rows = bytes({0, 0x12, 0x34})})));
  CHECK(deep(0, 0) == float(0x1234) / 65535.0F);
  const auto shallow =
      io::read_mask(folder.write("m.png", png({.width = 3, .rows = bytes({0, 0, 128, 255})})));
  CHECK(std::vector<float>{shallow.begin(), shallow.end()} == std::vector<float>{0, 128.0F / 255.0F, 1});
}

TEST_CASE("a picture comes back", "[io][image]") {
  const test::TemporaryFolder folder;
  const auto image = small_image();
  io::write_image(folder.path("a.png"), image);
  CHECK(values_of(io::read_image(folder.path("a.png"))) == values_of(image));
  const Array<float, 3> shares = tapestry::cast<float>(image) / 255.0F;
  io::write_image(folder.path("b.png"), shares);
  CHECK(folder.read("b.png") == folder.read("a.png"));
  CHECK(io::png_file("bytes", image) == folder.read("a.png"));
  Array<std::uint8_t, 3> clear(Extents<3>{image.shape(0), image.shape(1), 4});
  for (std::size_t i = 0; i < clear.size(); ++i)
    clear.data()[i] = i % 4 == 3 ? static_cast<std::uint8_t>(i) : image.data()[i / 4 * 3 + i % 4];
  io::write_image(folder.path("c.png"), clear);
  std::vector<std::string> warnings;
  CHECK(values_of(io::read_texture(folder.path("c.png"), &warnings)) == values_of(image));
  CHECK(warnings.size() == 1);  // of its opacity
  const Array<double, 2> mask = {{-1.0, 0.0}, {0.5, 2.0}};
  io::write_mask(folder.path("m.png"), mask);
  const auto again = io::read_mask(folder.path("m.png"));
  CHECK(std::vector<float>{again.begin(), again.end()} == std::vector<float>{0, 0, 128.0F / 255.0F, 1});
}

TEST_CASE("a large picture is packed by several threads into one stream of the same bytes", "[io][image]") {
  constexpr std::size_t height = 1000, width = 1100;  // 3.3 million bytes
  Array<std::uint8_t, 3> image(Extents<3>{height, width, 3});
  Random random(1);
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = static_cast<std::uint8_t>(i / 3 % width / 8 + random.index(3));
  const auto packed_by = [&](int threads) {
    const test::Threads limit(threads);
    return io::detail::encode_png(image.data(), height, width, 3);
  };
  const std::string file = packed_by(1);
  CHECK((packed_by(3) == file));
  auto decoded = tapestry::zeros<std::uint8_t, 3>(image.shape());
  CHECK(io::detail::decode_png(file, decoded));
  CHECK((decoded == image));
  constexpr std::size_t first = 41;  // after the signature, the header, and the length and name of this chunk
  REQUIRE(file.substr(first - 4, 4) == "IDAT");
  std::vector<unsigned char> rows(height * (1 + 3 * width) + 1);
  auto size = static_cast<uLongf>(rows.size());
  CHECK(uncompress(rows.data(), &size, reinterpret_cast<const unsigned char*>(file.data()) + first,
                   static_cast<uLong>(file.size() - first)) == Z_OK);
  CHECK(size == rows.size() - 1);
}

TEST_CASE("a picture becomes a JPEG", "[io][image]") {
  // A level picture loses the rounding of its frequency of zero: half a step of quantisation, one level at
  // quality 100, and half a level in each conversion of colours.
  Array<std::uint8_t, 3> level(Extents<3>{20, 30, 3});
  for (std::size_t i = 0; i < level.size(); ++i)
    level.data()[i] = std::array<std::uint8_t, 3>{200, 90, 40}[i % 3];
  const std::string file = io::jpeg_file("level", level, 100);
  CHECK(io::is_jpeg(file));
  const auto header = io::scan_jpeg(file, "level");
  CHECK(header.height == 20);
  CHECK(header.width == 30);
#if defined(TAPESTRY_JPEG)
  const auto again = io::parse_jpeg(file, "level");
  for (std::size_t i = 0; i < level.size(); ++i) CHECK(std::abs(again.data()[i] - level.data()[i]) <= 3);
#endif
  CHECK(io::jpeg_file("small", small_image(), 40).size() < io::jpeg_file("small", small_image(), 100).size());
  CHECK_THROWS_WITH(io::jpeg_file("level", level, 0), "jpeg_file: quality is 0, expected 1 to 100");
  CHECK_THROWS_AS(io::jpeg_file("level", level, 101), DomainError);
  CHECK_THROWS_AS(io::jpeg_file("none", Array<std::uint8_t, 3>(Extents<3>{0, 4, 3}), 90), ShapeError);
}

TEST_CASE("bad pictures are refused", "[io][image][bad_input]") {
  const PngParts one{.rows = bytes({0, 7})};
  const std::string good = png(one);
  const std::string signature = test::png_signature();
  const std::string header = test::png_header(one);
  const std::string packed = test::zlib_packed(one.rows);
  const std::string data = png_chunk("IDAT", packed), end = png_chunk("IEND", "");
  const auto sized = [](std::uint32_t width, std::uint32_t height) {
    return png({.width = width, .height = height});
  };
  const auto cut_stream = [&](std::size_t size) {
    return signature + header + png_chunk("IDAT", packed.substr(0, size)) + end;
  };
  std::string wrong_sum = packed;
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
      {"I04 bomb", png({.rows = std::string(std::size_t{1} << 18U, '\0')}), malformed, "damaged or cut"},
      {"I05 no end", signature + header + data, malformed, "cut"},
      {"I05 stream", cut_stream(8), malformed, "damaged or cut"},
      {"I05 stream sum cut", cut_stream(packed.size() - 1), malformed, "cut"},
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
      {"I05 depth 0", png({.bits = 0, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 depth 99", png({.bits = 99, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 colour type 1", png({.colour_type = 1, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 colour type 9", png({.colour_type = 9, .rows = one.rows}), malformed, "kind of pixel"},
      {"I05 header checksum", std::string(good).replace(29, 1, "?"), malformed, "checksum"},
      {"I05 signature 1", std::string(good).replace(0, 1, "\xC9"), malformed, "found other bytes"},
      {"I05 signature 2", std::string(good).replace(1, 1, "p"), malformed, "found other bytes"},
      {"I05 signature CR", std::string(good).replace(4, 2, "\r"), malformed, "text transfer"},
      {"I05 signature LF", std::string(good).replace(4, 2, "\n"), malformed, "text transfer"},
      {"I08 GIF", "GIF89a", malformed, "found a GIF image"},
      {"I08 PSD", "8BPS", malformed, "found a PSD image"},
      {"I08 HDR", "#?RADIANCE", malformed, "found an HDR image"},
      {"I08 PNM", "P7\nWIDTH 1", malformed, "found a PNM image of another kind"},
      {"I08 TGA", std::string(18, '\2'), malformed, "found other bytes"},
      {"I19 EXR", "\x76\x2f\x31\x01", malformed, "found an EXR image"},
      {"I19 KTX", "\xabKTX 11", malformed, "found a KTX texture"},
      {"empty", "", malformed, "0 bytes"},
      {"text transfer", "\x89PNG\n\x1a\n", malformed, "text transfer"},
  };
  check_bad_pictures(rows);
}

TEST_CASE("every kind of uncompressed BMP is converted by the stated rule", "[io][image]") {
  const test::TemporaryFolder folder;
  const std::string palette = bytes({3, 2, 1, 0, 9, 8, 7, 0});  // (1, 2, 3), (7, 8, 9)
  const std::string pixel_24 = bytes({3, 2, 1, 0});
  const auto masks = [](std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    return test::little_endian(r, 4) + test::little_endian(g, 4) + test::little_endian(b, 4);
  };
  struct Row {
    const char* kind;
    std::string file;
    std::vector<int> expected;
  };
  const Row rows[] = {
      {"24 bits, from below",
       bmp({.width = 1, .height = 2, .rows = bytes({3, 2, 1, 0, 6, 5, 4, 0})}),
       {4, 5, 6, 1, 2, 3}},
      {"from above", bmp({.height = -2, .rows = bytes({3, 2, 1, 0, 6, 5, 4, 0})}), {1, 2, 3, 4, 5, 6}},
      {"header of 124 bytes", bmp({.header_size = 124, .rows = pixel_24}), {1, 2, 3}},
      {"header of 12 bytes", bmp({.header_size = 12, .rows = pixel_24}), {1, 2, 3}},
      {"1 bit",
       bmp({.width = 2, .bits = 1, .palette = palette, .rows = bytes({0x40, 0, 0, 0})}),
       {1, 2, 3, 7, 8, 9}},
      {"4 bits beyond the palette",
       bmp({.width = 3, .bits = 4, .used = 2, .palette = palette, .rows = bytes({0x1F, 0, 0, 0})}),
       {7, 8, 9, 0, 0, 0, 1, 2, 3}},
      {"8 bits of a short header",
       bmp({.header_size = 12, .bits = 8, .palette = bytes({3, 2, 1, 9, 8, 7}), .rows = bytes({1, 0, 0, 0})}),
       {7, 8, 9}},
      {"32 bits", bmp({.bits = 32, .rows = bytes({3, 2, 1, 9})}), {1, 2, 3}},
      {"32 bits, masks",
       bmp({.bits = 32,
            .compression = 3,
            .palette = masks(0xFF000000U, 0xFF0000, 0xFF00),
            .rows = bytes({9, 3, 2, 1})}),
       {1, 2, 3}},
      {"5, 5 and 5 bits", bmp({.bits = 16, .rows = bytes({0x1F, 0x40, 0, 0})}), {132, 0, 255}},  // 16 of 31
      {"5, 6 and 5 bits",
       bmp({.bits = 16,
            .compression = 3,
            .palette = masks(0xF800, 0x7E0, 0x1F),
            .rows = bytes({0xE0, 0x07, 0, 0})}),
       {0, 255, 0}},
  };
  for (const Row& row : rows) {
    INFO(row.kind);
    CHECK(values_of(io::read_image(folder.write("picture.png", row.file + "more"))) == row.expected);
  }
  const auto mask = io::read_mask(folder.write("m.bmp", bmp({.rows = bytes({30, 20, 10, 0})})));
  CHECK(mask(0, 0) == float((77 * 10 + 150 * 20 + 29 * 30) / 256) / 255.0F);
}

TEST_CASE("a PNG with more data than its size is read with a warning", "[io][image]") {  // I04
  const test::TemporaryFolder folder;
  const std::string path = folder.write("a.png", png({.rows = bytes({0, 7, 2, 3})}));
  std::vector<std::string> warnings;
  CHECK(values_of(io::read_image(path, &warnings)) == std::vector<int>{7, 7, 7});
  CHECK(warnings == std::vector<std::string>{
                        path + ": PNG has more picture data than its size needs; the rest is ignored"});
  CHECK(io::read_mask(path)(0, 0) == 7.0F / 255.0F);
}

TEST_CASE("run lengths of a BMP are unpacked, and refused where they are cut",
          "[io][image][bad_input]") {  // I21
  const test::TemporaryFolder folder;
  const std::string palette = bytes({1, 1, 1, 0, 2, 2, 2, 0, 3, 3, 3, 0});
  const auto red_of = [&](int width, int height, int bits, const std::string& runs) {
    const auto file = bmp({.width = width,
                           .height = height,
                           .bits = bits,
                           .compression = bits == 8 ? 1U : 2U,
                           .used = 3,
                           .palette = palette,
                           .rows = runs});
    const auto picture = io::read_image(folder.write("a.bmp", file));
    std::vector<int> red;
    for (std::size_t i = 0; i < picture.size(); i += 3) red.push_back(picture.data()[i]);
    return red;
  };
  // The lower row is two pixels of 1 and one of 2; the upper one is absolute, with a byte that fills the
  // pair.
  const std::string runs = bytes({2, 1, 1, 2, 0, 0, 0, 3, 2, 0, 1, 9, 0, 1});
  CHECK(red_of(3, 2, 8, runs) == std::vector<int>{3, 1, 2, 2, 2, 3});
  for (std::size_t length = 0; length + 3 < runs.size(); ++length)
    CHECK_THROWS_WITH(red_of(3, 2, 8, runs.substr(0, length)), contains("BMP is cut"));
  CHECK(red_of(3, 1, 4, bytes({3, 0x12, 0, 1})) == std::vector<int>{2, 3, 2});
  CHECK(red_of(5, 1, 4, bytes({0, 5, 0x01, 0x21, 0x00, 0, 0, 1})) == std::vector<int>{1, 2, 3, 2, 1});
  CHECK(red_of(3, 2, 8, bytes({0, 2, 1, 1, 9, 1, 0, 1})) == std::vector<int>{1, 2, 2, 1, 1, 1});
}

TEST_CASE("plain and binary PBM, PGM and PPM of the same samples are the same picture", "[io][image]") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& file) {
    return values_of(io::read_image(folder.write("a.pnm", file)));
  };
  CHECK(read("P3\n# text\n2 1 15\n15 0 1\n2 # three\n3 15\n") ==
        read("P6 2 1 15\n" + bytes({15, 0, 1, 2, 3, 15})));
  CHECK(read("P2 2 1 1000 1000 250") == std::vector<int>{255, 255, 255, 64, 64, 64});
  CHECK(read("P1 3 2 010 1 1\n0") == read("P4 3 2\n" + bytes({0x40, 0xC0})));
  CHECK(read("P1 2 1 01") == std::vector<int>{255, 255, 255, 0, 0, 0});  // 1 is black
  CHECK_THROWS_WITH(read("P2 2 1 9 9"), contains("PNM picture is cut"));
  CHECK_THROWS_WITH(read("P2 1 1 9 10"), contains("expected at most 9, found 10"));
  CHECK_THROWS_WITH(read("P2 1 1 9 x"), contains("lacks a number"));
  CHECK_THROWS_WITH(read("P1 2 1 02"), contains("expected 0 or 1"));
}

TEST_CASE("PGM and PPM are scaled by their greatest sample", "[io][image]") {
  const test::TemporaryFolder folder;
  const auto read = [&](const std::string& file) { return io::read_image(folder.write("a.ppm", file)); };
  const auto mask = [&](const std::string& file) { return io::read_mask(folder.write("a.pgm", file)); };
  CHECK(values_of(read("P6\n# by hand\n1 2\n255\n" + bytes({1, 2, 3, 4, 5, 6}))) ==
        std::vector<int>{1, 2, 3, 4, 5, 6});
  CHECK(values_of(read("P5#\n#\n 2\t1 15 " + bytes({15, 8}))) ==
        std::vector<int>{255, 255, 255, 136, 136, 136});
  CHECK(values_of(read("P5 1 1 65535\n" + bytes({0x7F, 0x80}))) == std::vector<int>{127, 127, 127});
  CHECK(mask("P5 1 1 65535\n" + bytes({0x12, 0x34}))(0, 0) == float(0x1234) / 65535.0F);
  CHECK(mask("P5 1 1 1\n" + bytes({1}) + "P5 the next one")(0, 0) == 1);
  CHECK(mask("P6 1 1 255\n" + bytes({9, 9, 9}))(0, 0) == 9.0F / 255.0F);
}

TEST_CASE("bad BMP, PGM and PPM pictures are refused", "[io][image][bad_input]") {
  const test::TemporaryFolder folder;
  const auto malformed = ErrorKind::malformed;
  const std::string row(4, '\0'), palette(8, '\0');
  const BadContent rows[] = {
      {"I21 header", "BM....", malformed, "ends in its header"},
      {"I21 header size", bmp({.header_size = 64, .rows = row}), malformed, "of no known size"},
      {"I21 no pixel", bmp({.width = 0, .rows = row}), malformed, "without a pixel"},
      {"I21 wide", bmp({.width = 20000, .rows = row}), ErrorKind::limit, "found 20000 x 1"},
      {"I21 pixels", bmp({.width = 16384, .height = 16384, .rows = row}), ErrorKind::limit, "64 megapixels"},
      {"I21 lowest rows", bmp({.height = std::numeric_limits<int>::min(), .rows = row}), ErrorKind::limit,
       "too large"},
      {"I21 bits", bmp({.bits = 2, .rows = row}), malformed, "found 2"},
      {"I21 runs", bmp({.bits = 8, .compression = 2, .palette = palette, .rows = row}), malformed, "kind 2"},
      {"I21 rows", bmp({.height = 2, .rows = row}), malformed, "expected 8 bytes of rows, found 4"},
      {"I21 offset", bmp({.rows = row, .rows_at = 1000}), malformed, "found 0"},
      {"I21 offset in header", bmp({.rows = row, .rows_at = 20}), malformed, "begin in its header"},
      {"I21 no palette", bmp({.bits = 8, .rows = row}), malformed, "begin in its palette"},
      {"I21 colours", bmp({.bits = 1, .used = 3, .palette = palette, .rows = row}), malformed,
       "at most 2 colours"},
      {"I21 palette cut", bmp({.bits = 8, .used = 9, .palette = palette, .rows = row, .rows_at = 1000}),
       malformed, "ends in its palette"},
      {"I21 masks", bmp({.bits = 32, .compression = 3, .palette = std::string(12, '\5'), .rows = row}),
       malformed, "no row of 1 to 16 bits"},
      {"I21 PNM number", "P6 1 x", malformed, "a.png:@5: PNM picture lacks a number"},
      {"I21 PNM digits", "P6 12345678 1 255\n", malformed, "too long"},
      {"I21 PNM end", "P6 1 1 255", malformed, "does not end"},
      {"I21 PNM pixels", "P5 9999999 9999999 255\n", ErrorKind::limit, "too large"},
      {"I21 PNM none", "P5 0 1 255\n", malformed, "without a pixel"},
      {"I21 PNM greatest", "P5 1 1 65536\n..", malformed, "found 65536"},
      {"I21 PNM cut", "P6 1 1 255\n..", malformed, "expected 3 bytes, found 2"},
      {"I21 PNM sample", "P5 2 1 9\n\1:", malformed, "expected at most 9, found 58"},
  };
  check_bad_pictures(rows);
  for (const char* part : {"", "P", "P7 1 1\n."})
    check_refused(malformed, "not a PBM, PGM", [&] { (void)io::parse_pnm(part, "a.pgm"); });
  for (const std::string& good :
       {bmp({.bits = 8, .palette = palette, .rows = row}), std::string("P6 1 1 255\n...")})  // every cut
    for (std::size_t length = 3; length < good.size(); ++length) {
      INFO(length);
      check_refused(malformed,
                    "a.png:", [&] { (void)io::read_image(folder.write("a.png", good.substr(0, length))); });
    }
}

TEST_CASE("every cut and every changed byte of a PNG is refused", "[io][image][bad_input]") {
  const test::TemporaryFolder folder;
  io::write_image(folder.path("a.png"), small_image());
  const std::string good = folder.read("a.png");
  for (std::size_t at = 0; at < good.size(); ++at) {
    INFO(at);
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 4);
    CHECK_THROWS_AS(io::scan_png(good.substr(0, at), "a.png"), FileError);
    CHECK_THROWS_AS(io::scan_png(changed, "a.png"), FileError);
  }
  CHECK(io::scan_png(good + "more", "a.png").width == 2);
}

TEST_CASE("a picture with a value that is not finite is not written", "[io][image]") {  // I17, I20
  const test::TemporaryFolder folder;
  auto image = test::random_array<float>({2, 3, 3}, 1);
  image(1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_AS(io::write_image(folder.path("a.png"), image), NumericError);
  check_refused(ErrorKind::numeric, "row 1, column 2", [&] { io::write_image(folder.path("a.png"), image); });
  CHECK_FALSE(std::filesystem::exists(folder.path("a.png")));
  CHECK_THROWS_AS(io::write_image(folder.path("a.png"), test::random_array<float>({2, 3, 2}, 1)), ShapeError);
  CHECK_THROWS_AS(io::png_file("a.png", Array<std::uint8_t, 3>(Extents<3>{2, 3, 5})), ShapeError);
  const Array<float, 2> empty(Extents<2>{0, 3});
  CHECK_THROWS_AS(io::write_mask(folder.path("a.png"), empty), ShapeError);
}

TEST_CASE("the real masks are read", "[io][image]") {
  const std::string path = test::in_shared("data/carla/mask1.png");
  if (is_absent(path)) return;
  const auto mask = io::read_mask(path);
  CHECK((mask.shape() == Extents<2>{608, 608}));
  CHECK(std::count_if(mask.begin(), mask.end(), [](float value) { return value > 0; }) > 30000);
}
