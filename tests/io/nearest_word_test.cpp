#include <tapestry/io/text_lines.hpp>

#include "../support/catch.hpp"

namespace io = tapestry::io;

TEST_CASE("edit_distance counts changes of one word into another", "[io][nearest_word]") {
  CHECK(io::edit_distance("", "abc") == 3);
  CHECK(io::edit_distance("kitten", "sitting") == 3);  // two replaced, one inserted
  CHECK(io::edit_distance("cfg", "cgf") == 1);         // neighbours exchanged
  CHECK(io::edit_distance("ca", "abc") == 3);          // exchanged letters are not changed again
  CHECK(io::edit_distance("azimuth", "azimuth") == 0);
}

TEST_CASE("nearest_word names what differs by at most a third, else nothing", "[io][nearest_word]") {
  const std::vector<std::string> known{"--json", "--epochs", "--cfg", "--scenes"};
  CHECK(io::nearest_word("--epoch", known) == "--epochs");
  CHECK(io::nearest_word("--cgf", known) == "--cfg");
  CHECK(io::nearest_word("--version", known).empty());
  CHECK(io::nearest_word("--steps", known).empty());
  CHECK(io::nearest_word("--config", known).empty());
  CHECK(io::nearest_word("--x", std::vector<std::string>{}).empty());
}
