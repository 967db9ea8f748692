#include <tapestry/io/image_file.hpp>

#include <tapestry/core/random.hpp>
#include <tapestry/io/jpeg_file.hpp>
#if defined(TAPESTRY_JPEG)
#include <turbojpeg.h>
#endif

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

namespace {
using Picture = Array<std::uint8_t, 3>;
using namespace std::string_literals;

/// An EXIF segment that holds nothing but the orientation and, in a directory of its own, the focal length.
std::string exif_segment(int orientation, bool is_little, int focal_length = 0) {
  const auto number = [&](int value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i)
      text.push_back(static_cast<char>(value >> 8 * (is_little ? i : bytes - 1 - i)));
    return text;
  };
  const auto entry = [&](int tag, int type, int value, int bytes) {
    return number(tag, 2) + number(type, 2) + number(1, 4) + number(value, bytes) + number(0, 4 - bytes);
  };
  const std::string tiff = (is_little ? "II"s : "MM"s) + number(42, 2) + number(8, 4) + number(2, 2) +
                           entry(0x0112, 3, orientation, 2) + entry(0x8769, 4, 38, 4) + number(0, 4) +
                           number(1, 2) + entry(0xA405, 3, focal_length, 2) + number(0, 4);
  const std::string content = "Exif\0\0"s + tiff;
  const std::size_t length = content.size() + 2;
  return "\xff\xe1"s + static_cast<char>(length >> 8U) + static_cast<char>(length & 0xFFU) + content;
}

std::string frame_header(int marker, int bits, int height, int width, int channels) {
  std::string content;
  content.push_back(static_cast<char>(bits));
  for (const int extent : {height, width}) {
    content.push_back(static_cast<char>(extent >> 8));
    content.push_back(static_cast<char>(extent & 0xFF));
  }
  content.push_back(static_cast<char>(channels));
  return "\xff\xd8\xff"s + static_cast<char>(marker) + "\0"s + static_cast<char>(content.size() + 2) +
         content;
}
}  // namespace

TEST_CASE("JPEGs that are not read are refused by their header", "[io][jpeg][bad_input]") {
  const BadContent rows[] = {
      {"I06 cut", "\xff\xd8\xff\xdb", ErrorKind::malformed, "a.jpg:@4: JPEG ends before its picture data"},
      {"I06 length", "\xff\xd8\xff\xdb\xff\xff", ErrorKind::malformed, "JPEG segment is cut"},
      {"I06 marker", "\xff\xd8\xff\xdb\0\2xx"s, ErrorKind::malformed, "JPEG ends before its picture data"},
      {"I06 no frame", "\xff\xd8\xff\xda\0\2"s, ErrorKind::malformed, "no frame header"},
      {"I06 end", "\xff\xd8\xff\xd9"s, ErrorKind::malformed, "JPEG ends before its picture data"},
      {"I06 lossless", frame_header(0xC3, 8, 4, 4, 3), ErrorKind::malformed, "found frame type 3"},
      {"I06 arithmetic", frame_header(0xCB, 8, 4, 4, 3), ErrorKind::malformed, "found frame type 11"},
      {"I06 bits", frame_header(0xC1, 12, 4, 4, 3), ErrorKind::malformed, "expected 8, found 12"},
      {"I06 no rows", frame_header(0xC0, 8, 0, 4, 3), ErrorKind::malformed, "no extent"},
      {"I06 cut frame", "\xff\xd8\xff\xc0\0\3\10"s, ErrorKind::malformed, "frame header is cut"},
      {"I06 large", frame_header(0xC0, 8, 60000, 60000, 3), ErrorKind::limit, "found 60000 x 60000"},
      {"I11 channels", frame_header(0xC0, 8, 4, 4, 2), ErrorKind::malformed, "4 (CMYK), found 2"},
  };
  const test::TemporaryFolder folder;
  for (const BadContent& row : rows) {
    INFO(row.id);
    const std::string path = folder.write("a.jpg", row.file);
    check_refused(row.kind, row.text, [&] { (void)io::read_image(path); });
    check_refused(ErrorKind::malformed, "expected a PNG, found a JPEG", [&] { (void)io::read_mask(path); });
  }
}

TEST_CASE("an EXIF block that makes no sense turns nothing", "[io][jpeg]") {
  for (const std::string& tiff : {""s, "II"s, "XX*\0"s, "II*\0\xff\xff\xff\xff"s, "MM\0*\0\0\0\10\0\1"s})
    CHECK(io::detail::ExifReader(tiff).orientation() == 1);
  const std::string nine = exif_segment(9, true);
  CHECK(io::detail::ExifReader(std::string_view(nine).substr(10)).orientation() == 1);
}

TEST_CASE("the focal length of an EXIF block is read, and 0 from a cut block", "[io][jpeg]") {
  for (const bool is_little : {true, false}) {
    const std::string segment = exif_segment(6, is_little, 27);
    const std::string_view tiff = std::string_view(segment).substr(10);
    CHECK(io::detail::ExifReader(tiff).focal_length_35mm() == 27);
    CHECK(io::detail::ExifReader(tiff).orientation() == 6);
    for (std::size_t length = 0; length < 52; ++length)  // where its entry ends
      CHECK(io::detail::ExifReader(tiff.substr(0, length)).focal_length_35mm() == 0);
    const std::string file = "\xff\xd8"s + segment + frame_header(0xC0, 8, 4, 4, 3).substr(2) + "\xff\xda"s;
    CHECK(io::scan_jpeg(file, "a.jpg").focal_length_35mm == 27);
  }
}

TEST_CASE("an EXIF block of any bytes has some focal length", "[io][jpeg][bad_input]") {
  Random random(2);
  for (int trial = 0; trial < 20000; ++trial) {
    const std::string segment = exif_segment(1, trial % 2 == 0, 27);
    std::string tiff = segment.substr(10, random.index(segment.size() - 10));
    for (int change = 0; change < 3 && tiff.size() > 4; ++change)
      tiff[4 + random.index(tiff.size() - 4)] = static_cast<char>(random.index(256));
    CHECK(io::detail::ExifReader(tiff).focal_length_35mm() <= 65535);
  }
}

TEST_CASE("an upright picture is passed on without a copy", "[io][jpeg]") {
  Picture stored(Extents<3>{2, 3, 3});
  const std::uint8_t* const pixels = stored.data();
  CHECK(io::turned_upright(std::move(stored), 1).data() == pixels);
}

TEST_CASE("eight orientations are turned upright", "[io][jpeg]") {
  Picture stored(Extents<3>{2, 3, 3});  // 0 1 2 / 3 4 5
  for (std::size_t i = 0; i < stored.size(); ++i) stored.data()[i] = static_cast<std::uint8_t>(i / 3);
  const std::vector<std::vector<int>> expected{{0, 1, 2, 3, 4, 5}, {2, 1, 0, 5, 4, 3}, {5, 4, 3, 2, 1, 0},
                                               {3, 4, 5, 0, 1, 2}, {0, 3, 1, 4, 2, 5}, {3, 0, 4, 1, 5, 2},
                                               {5, 2, 4, 1, 3, 0}, {2, 5, 1, 4, 0, 3}};
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const Picture upright = io::turned_upright(stored, orientation);
    CHECK(upright.shape(0) == (orientation >= 5 ? 3 : 2));
    std::vector<int> values;
    for (std::size_t i = 0; i < upright.size(); i += 3) values.push_back(upright.data()[i]);
    CHECK(values == expected[static_cast<std::size_t>(orientation - 1)]);
  }
}

#if defined(TAPESTRY_JPEG)
namespace {
/// Smooth, so that a JPEG keeps it within a few levels, and different in every corner.
Picture smooth_picture(std::size_t height, std::size_t width) {
  Picture picture(Extents<3>{height, width, 3});
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      picture(y, x, 0) = static_cast<std::uint8_t>(250 * y / height);
      picture(y, x, 1) = static_cast<std::uint8_t>(250 * x / width);
      picture(y, x, 2) = static_cast<std::uint8_t>(60 + 100 * (x + y) / (width + height));
    }
  return picture;
}

std::string jpeg_of(const Picture& picture, int flags = 0, int sampling = TJSAMP_444, int quality = 95) {
  const tjhandle encoder = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  REQUIRE(tjCompress2(encoder, picture.data(), static_cast<int>(picture.shape(1)), 0,
                      static_cast<int>(picture.shape(0)), picture.shape(2) == 4 ? TJPF_CMYK : TJPF_RGB,
                      &bytes, &size, sampling, quality, flags) == 0);
  std::string file(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(encoder);
  return file;
}

int largest_difference(const Picture& a, const Picture& b) {
  REQUIRE(a.shape() == b.shape());
  int largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    largest = std::max(largest, std::abs(int(a.data()[i]) - int(b.data()[i])));
  return largest;
}
}  // namespace

TEST_CASE("a JPEG shows what was put into it, baseline or progressive, colour or grey", "[io][jpeg]") {
  // At quality 95 the coarsest steps of a coefficient are 10 and 12 levels; chroma shared by pixels adds to
  // that.
  const Picture picture = smooth_picture(37, 53);
  const test::TemporaryFolder folder;
  for (const int flags : {0, TJFLAG_PROGRESSIVE})
    for (const int sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420}) {
      const Picture read = io::read_image(folder.write("a.png", jpeg_of(picture, flags, sampling)));
      CHECK(largest_difference(read, picture) <= (sampling == TJSAMP_444 ? 8 : 12));
    }
  const Picture grey = io::parse_jpeg(jpeg_of(picture, 0, TJSAMP_GRAY), "grey.jpg");
  for (std::size_t i = 0; i < grey.size(); i += 3) CHECK(grey.data()[i] == grey.data()[i + 2]);
}

TEST_CASE("a photograph taken on its side is read upright, a texture as it is stored", "[io][jpeg]") {
  const test::TemporaryFolder folder;
  const std::string plain = jpeg_of(smooth_picture(24, 40));
  const Picture stored = io::parse_jpeg(plain, "a.jpg");
  for (const bool is_little : {true, false})
    for (int orientation = 1; orientation <= 8; ++orientation) {
      const std::string tagged = plain.substr(0, 2) + exif_segment(orientation, is_little) + plain.substr(2);
      const Picture read = io::parse_jpeg(tagged, "a.jpg");
      CHECK(read.shape(0) == (orientation >= 5 ? 40 : 24));
      CHECK(largest_difference(read, io::turned_upright(stored, orientation)) == 0);
      CHECK(largest_difference(io::read_texture(folder.write("a.jpg", tagged)), stored) == 0);
    }
}

TEST_CASE("I07: every cut of a JPEG is refused", "[io][jpeg][bad_input]") {
  for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
    const std::string good = jpeg_of(smooth_picture(16, 16), flags);
    INFO("progressive: " << (flags != 0));
    for (std::size_t length = 3; length + 2 < good.size(); ++length)
      check_refused(ErrorKind::malformed, "a.jpg",
                    [&] { (void)io::parse_jpeg(good.substr(0, length), "a.jpg"); });
  }
}

TEST_CASE("I07: a JPEG that is cut or holds junk is read as far as it goes, with a warning",
          "[io][jpeg][bad_input]") {
  const Picture picture = smooth_picture(64, 64);
  const std::string good = jpeg_of(picture);
  const Picture whole = io::parse_jpeg(good, "a.jpg");
  std::vector<std::string> warnings;
  const auto cut = io::parse_jpeg(good.substr(0, good.size() * 3 / 4), "a.jpg", &warnings);
  CHECK(warnings.size() == 1);
  CHECK_THAT(warnings.at(0),
             contains("a.jpg: JPEG is damaged or cut (") && contains("what is missing is grey"));
  for (std::size_t i = 0; i < 8 * 64 * 3; ++i) CHECK(cut.data()[i] == whole.data()[i]);  // the first blocks
  CHECK(largest_difference(cut, whole) > 0);
  CHECK(largest_difference(io::parse_jpeg(good.substr(0, good.size() * 3 / 4), "a.jpg", &warnings), cut) ==
        0);
  warnings.clear();
  const std::string junk = good.substr(0, 20) + "junk" + good.substr(20);  // behind the first segment
  CHECK(largest_difference(io::parse_jpeg(junk, "a.jpg", &warnings), whole) == 0);
  CHECK(warnings.size() == 1);
  warnings.clear();
  CHECK(largest_difference(io::parse_jpeg(good + "junk", "a.jpg", &warnings), whole) == 0);
  CHECK(warnings.empty());
}

TEST_CASE("I06: a JPEG of arithmetic coding shows what one of Huffman coding shows", "[io][jpeg]") {
  const Picture picture = smooth_picture(37, 53);
  const std::string huffman = jpeg_of(picture);
  ::setenv("TJ_ARITHMETIC", "1", 1);
  const std::string arithmetic = jpeg_of(picture);
  ::unsetenv("TJ_ARITHMETIC");
  REQUIRE(arithmetic.find("\xff\xc9") != std::string::npos);
  CHECK(largest_difference(io::parse_jpeg(arithmetic, "a.jpg"), io::parse_jpeg(huffman, "a.jpg")) == 0);
}

TEST_CASE("I11: a CMYK JPEG is taken for inverted, as Adobe's programs write it", "[io][jpeg]") {
  // Ink shares as stored, 255 for none: channel · key / 255.
  const std::vector<std::array<std::uint8_t, 4>> inks{
      {255, 255, 255, 255}, {255, 0, 0, 255}, {200, 100, 50, 128}};
  for (const auto& ink : inks) {
    Picture cmyk(Extents<3>{16, 16, 4});
    for (std::size_t i = 0; i < cmyk.size(); ++i) cmyk.data()[i] = ink[i % 4];
    const Picture read = io::parse_jpeg(jpeg_of(cmyk, 0, TJSAMP_444, 100), "a.jpg");
    REQUIRE(read.shape(2) == 3);
    for (std::size_t i = 0; i < read.size(); ++i)
      CHECK(std::abs(int(read.data()[i]) - int(ink[i % 3]) * int(ink[3]) / 255) <=
            3);  // two roundings of YCCK
  }
}

TEST_CASE("a JPEG with changed bytes is read or refused, and nothing worse", "[io][jpeg][bad_input]") {
  const std::string good = jpeg_of(smooth_picture(16, 16), TJFLAG_PROGRESSIVE);
  Random random(1);
  std::size_t refused = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string file = good;
    for (int change = 0; change < 3; ++change)
      file[3 + static_cast<std::size_t>(random.uniform(0, 1) * static_cast<double>(file.size() - 4))] =
          static_cast<char>(static_cast<unsigned char>(random.uniform(0, 256)));
    try {
      std::vector<std::string> warnings;
      (void)io::parse_jpeg(file, "a.jpg", trial % 2 == 0 ? nullptr : &warnings);
    } catch (const FileError&) {
      ++refused;
    }
  }
  CHECK(refused > 100);
}
#endif
