#include <tapestry/io/detail/picture_format.hpp>

#include <tapestry/io/image_file.hpp>

#include "../support/bmp_builder.hpp"
#include "../support/catch.hpp"
#include "../support/png_builder.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;

namespace {
/// A picture of 2 x 2 pixels in each format, by its names. A new format needs one.
const std::map<std::string_view, std::string>& samples() {
  static const std::map<std::string_view, std::string> files{
      {"PNG", test::png({2, 2, 8, 0, 0, std::string("\0ab\0cd", 6)})},
      {"JPEG", io::jpeg_file("a", tapestry::zeros<std::uint8_t, 3>({2, 2, 3}), 90)},
      {"BMP", test::bmp({.width = 2, .height = 2, .rows = "abcdef..ghijkl.."})},
      {"PBM PGM PPM", "P6 2 2 255\nabcdefghijkl"}};
  return files;
}
}  // namespace

TEST_CASE("every format of pictures is read by its content and listed by its endings",
          "[io][image][bad_input]") {
  const test::TemporaryFolder folder;
  for (const auto& format : io::detail::picture_formats()) {
    INFO(format.names);
    REQUIRE(samples().contains(format.names));
    const std::string& sample = samples().at(format.names);
    for (const auto& other : io::detail::picture_formats())
      CHECK(other.recognises(sample) == (&other == &format));
    std::istringstream endings{std::string(format.endings)};
    for (std::string ending; endings >> ending;) CHECK_THAT(io::picture_endings(), contains(ending));

    const auto path = folder.write("picture.of_any_name", sample);
#ifndef TAPESTRY_JPEG
    if (format.mask == nullptr) continue;
#endif
    CHECK(io::read_image(path).shape() == Extents<3>{2, 2, 3});
    CHECK((io::read_texture(path) == io::read_image(path)));
    if (format.mask != nullptr)
      CHECK(io::read_mask(path).shape() == Extents<2>{2, 2});
    else
      CHECK_THROWS_WITH(io::read_mask(path), contains("a mask must not have lost anything"));
    for (std::size_t size = 0; size < sample.size(); ++size) {
      const auto cut = folder.write("cut", sample.substr(0, size));
      CHECK_THROWS_AS(io::read_image(cut), FileError);
      CHECK_THROWS_AS(io::read_mask(cut), FileError);
    }
  }
}

TEST_CASE("pictures of a folder are found by their endings", "[io][image]") {
  for (const char* name : {"a.png", "a.b.JPG", "x/a.jpeg", "a.bmp", "a.pgm", "a.Ppm", "a.pnm"})
    CHECK(io::has_picture_name(name));
  for (const char* name : {"a", "png", "a.", "a.pn", "a.png,", "a.or", ".png", "a.tiff", "a.p"})
    CHECK_FALSE(io::has_picture_name(name));
  CHECK(io::picture_endings() == ".png, .jpg, .jpeg, .bmp, .pgm, .ppm or .pnm");
}
