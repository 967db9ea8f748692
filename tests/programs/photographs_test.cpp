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

TEST_CASE("photographs are divided between places that their names tell", "[programs][photographs]") {
  const auto divided = [](const std::vector<std::pair<std::string, int>>& places, std::size_t train,
                          std::size_t test) {
    std::vector<shell::Photograph> all;
    for (const auto& [place, count] : places)
      for (int i = 0; i < count; ++i)
        all.push_back({"folder_1/" + place + std::to_string(1000 + i) + ".jpg"});
    const auto shares = shell::shares_of(all, train, test);
    return std::tuple(shares.train.size(), shares.test.size(), shares.are_apart);
  };
  CHECK(divided({{"Town01_", 49}, {"Town02_", 49}, {"Town03_", 48}, {"Town04_", 14}}, 200, 50) ==
        std::tuple(146, 14, true));
  CHECK(divided({{"a", 10}, {"b", 10}}, 100, 100) == std::tuple(10, 10, true));
  CHECK(divided({{"IMG_", 10}}, 200, 50) == std::tuple(8, 2, false));
  CHECK(divided({{"IMG_", 100}, {"z", 1}}, 200, 50) == std::tuple(81, 20, false));  // one is too few
  CHECK(divided({{"a", 1}, {"b", 1}, {"c", 1}}, 2, 1) == std::tuple(2, 1, false));  // names tell no places
  CHECK(divided({{"a", 1}, {"b", 1}}, 9999, 1) == std::tuple(1, 1, false));
  CHECK(divided({{"a", 3}, {"b", 3}}, 0, 5) == std::tuple(0, 6, false));
  CHECK(divided({}, 200, 50) == std::tuple(0, 0, false));
}
