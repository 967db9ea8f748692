#include "../../examples/programs/shell/photographs.hpp"

#include "../support/catch.hpp"
#include "../support/temporary_folder.hpp"

namespace shell = tapestry::shell;
using namespace std::string_literals;

namespace {
/// The header of a JPEG of 36 × 24 pixels whose lens has 36 mm, with an orientation.
std::string header_of(char orientation) {
  const std::string tiff = "MM\0*\0\0\0\10\0\2"s +                           //
                           "\1\22\0\3\0\0\0\1\0"s + orientation + "\0\0"s +  // 0x0112, orientation
                           "\x87\x69\0\4\0\0\0\1\0\0\0\46\0\0\0\0"s +        // 0x8769, the next directory
                           "\0\1\xa4\5\0\3\0\0\0\1\0\44\0\0\0\0\0\0"s;       // 0xA405, 36 mm
  return "\xff\xd8\xff\xe1\0"s + static_cast<char>(tiff.size() + 8) + "Exif\0\0"s + tiff +
         "\xff\xc0\0\10\10\0\30\0\44\3\xff\xda"s;
}
}  // namespace

TEST_CASE("the field of view of a photograph is that of its lens, turned with it",
          "[programs][photographs]") {
  const tapestry::test::TemporaryFolder folder;
  // 2 · atan(18 / 36), and 2 · atan(12 / 36) for an upright picture.
  CHECK(shell::stated_fov_deg(folder.write("lies.jpg", header_of(1))) == Approx(53.130102));
  CHECK(shell::stated_fov_deg(folder.write("stands.jpg", header_of(6))) == Approx(36.869898));
  CHECK(shell::stated_fov_deg(folder.write("none.png", "\x89PNG")) == 0);
}
