#include <tapestry/io/text_lists.hpp>

#include "../support/refusal.hpp"
#include "../support/temporary_folder.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("a palette is read", "[io][palette]") {
  const test::TemporaryFolder folder;
  const auto palette = io::read_palette(
      folder.write("p.txt", "\xEF\xBB\xBF# a printer's\r\n0.1 0.2 0.3\r\n\r\n 1,0,0.5 \n0, 1 ,1e-3"));
  CHECK((palette == Array<double, 2>{{0.1, 0.2, 0.3}, {1, 0, 0.5}, {0, 1, 1e-3}}));
}

TEST_CASE("bad palettes are refused", "[io][palette][bad_input]") {
  const test::TemporaryFolder folder;
  const std::tuple<std::string, ErrorKind, const char*> rows[] = {
      {"0 0 0\n0 0\n", ErrorKind::malformed, "p.txt:2: not a colour"},
      {"red\n", ErrorKind::malformed, "'red'"},
      {"0 nan 0\n", ErrorKind::malformed, "p.txt:1: not a colour"},
      {"0 0 0 0\n", ErrorKind::malformed, "p.txt:1: more than three numbers"},
      {"0 128 255\n", ErrorKind::malformed, "are the colours those of bytes?"},
      {"0 -0.1 0\n", ErrorKind::malformed, "expected numbers from 0 to 1, found '0 -0.1 0'"},
      {"", ErrorKind::mismatch, "the palette is empty"},
      {"\n# nothing\n", ErrorKind::mismatch, "the palette is empty"},
      {std::string("0 0\0 0\n", 7), ErrorKind::malformed, "zero byte"},
  };
  for (const auto& [content, kind, text] : rows) {
    INFO(content);
    const auto path = folder.write("p.txt", content);
    check_refused(kind, text, [&] { (void)io::read_palette(path); });
  }
  std::string many;
  for (int i = 0; i < 4097; ++i) many += "0 0 0\n";
  check_refused(ErrorKind::limit, "p.txt:4097: too many colours",
                [&] { (void)io::read_palette(folder.write("p.txt", many)); });
}
