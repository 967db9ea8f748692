#include <tapestry/io/text_lists.hpp>

#include "../support/paths.hpp"
#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("a face list is read", "[io][face_list]") {
  const test::TemporaryFolder folder;
  const auto list =
      io::read_face_list(folder.write("f.txt", "\xEF\xBB\xBF# exterior\r\n3\r\n\r\n 1 \n3\n2"), 4);
  CHECK(list.ids == std::vector<std::int64_t>{3, 1, 2});
  REQUIRE(list.warnings.size() == 1);
  CHECK_THAT(list.warnings[0], contains("1 face numbers are repeated"));
  const auto all = io::read_face_list(folder.write("f.txt", "1\n2\n"), 2);  // O31
  CHECK_THAT(all.warnings.at(0), contains("covers every face"));
}

TEST_CASE("bad face lists are refused", "[io][face_list][bad_input]") {  // O30, O31
  const test::TemporaryFolder folder;
  const std::tuple<std::string, ErrorKind, const char*> rows[] = {
      {"1\n0\n", ErrorKind::malformed, "f.txt:2: face number 0"},
      {"-1\n", ErrorKind::malformed, "f.txt:1: face number is negative"},
      {"1\n4\n9\n", ErrorKind::mismatch, "f.txt:2: face number beyond"},
      {"1\n4\n9\n", ErrorKind::mismatch, "expected 1 to 3, found 3 numbers from 1 to 9"},
      {"one\n", ErrorKind::malformed, "'one'"},
      {"1.5\n", ErrorKind::malformed, "'1.5'"},
      {"1 2\n", ErrorKind::malformed, "more than one word"},
      {"99999999999999999999\n", ErrorKind::malformed, "not a whole number"},
      {"", ErrorKind::mismatch, "face list is empty"},
      {"\n# nothing\n", ErrorKind::mismatch, "face list is empty"},
      {std::string("1\0\n", 3), ErrorKind::malformed, "zero byte"},
  };
  for (const auto& [content, kind, text] : rows) {
    INFO(content);
    const auto path = folder.write("f.txt", content);
    check_refused(kind, text, [&] { (void)io::read_face_list(path, 3); });
  }
}

TEST_CASE("the published face list is read", "[io][face_list]") {
  const std::string path = test::in_shared("data/mesh/exterior_face.txt");
  if (is_absent(path)) return;
  CHECK(io::read_face_list(path, 23145).ids.size() == 6466);
}
